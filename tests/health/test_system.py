"""What is said of a machine, held against made-up machines; whatever is broken, it is told."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot.health import Finding
from qrobot.health.system import Machine, system_findings
from qrobot.health.system.clock import clock

PI4 = {
    "proc/cpuinfo": "processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd08\n"
    "Model\t\t: Raspberry Pi 4 Model B Rev 1.4\n",
    "proc/meminfo": "MemTotal:        3884092 kB\nMemFree:  100 kB\nMemAvailable:    3145728 kB\n"
    "SwapTotal:       524288 kB\nSwapFree:        524288 kB\n",
    "proc/device-tree/model": "Raspberry Pi 4 Model B Rev 1.4\0",
    "proc/device-tree/serial-number": "10000000abcdef01\0",
    "proc/sys/kernel/arch": "aarch64\n",
    "etc/os-release": 'NAME="Debian"\nPRETTY_NAME="Debian GNU/Linux 12 (bookworm)"\n',
    "etc/machine-id": "0123456789abcdef0123456789abcdef\n",
    "sys/class/thermal/thermal_zone0/type": "cpu-thermal\n",
    "sys/class/thermal/thermal_zone0/temp": "51608\n",
}

ASIMD_CRC = 1 << 1 | 1 << 7
LSE = 1 << 8


@pytest.fixture(autouse=True)
def no_tool(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Let nothing on the PATH be found but what a test puts there."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    return folder


def machine(root: Path, files: dict[str, str | bytes] | None = None, **facts: Any) -> Machine:
    for name, text in (PI4 if files is None else files).items():
        path = root / "root" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    (root / "root").mkdir(exist_ok=True)
    known: dict[str, Any] = {
        "root": root / "root",
        "architecture": "aarch64",
        "bits": 64,
        "page_bytes": 4096,
        "hwcap": ASIMD_CRC,
        "python": (3, 11, 2),
        "implementation": "CPython",
        "libc": "glibc 2.36",
        "cores": 4,
        "folder": root,
        "now": datetime(2026, 11, 22, tzinfo=UTC),
    }
    return Machine(**known | facts)


def told(one: Machine) -> dict[str, Finding]:
    found = {finding.name: finding for finding in system_findings(one)}
    for finding in found.values():
        assert finding.message
        assert "\n" not in finding.message
        json.dumps(finding.to_dict(), allow_nan=False)
    return found


def vcgencmd(folder: Path, script: str) -> None:
    tool = folder / "vcgencmd"
    tool.write_text(f"#!/bin/sh\n{script}\n")
    tool.chmod(0o755)


def test_a_pi_4_is_good(tmp_path: Path, no_tool: Path) -> None:
    vcgencmd(no_tool, "echo throttled=0x0")
    found = told(machine(tmp_path))
    values = {name: finding.value for name, finding in found.items()}
    assert values["board"] == "Raspberry Pi 4 Model B Rev 1.4"
    assert values["cpu"] == "Cortex-A72"
    assert values["cpu-features"] == ("neon", "crc32")
    assert values["memory"] == 3884092 // 1024
    assert values["memory-available"] == 3072
    assert values["swap-used"] == 0
    assert values["temperature"] == 51.6
    assert values["throttled"] == 0
    assert values["os"] == "Debian GNU/Linux 12 (bookworm)"
    assert values["emulation"] == "none"
    assert values["userland-bits"] == 64
    bad = [name for name, finding in found.items() if finding.status not in ("good",)]
    assert set(bad) <= {"clock-synchronised", "disk-free", "container"}


@pytest.mark.parametrize(
    ("facts", "name", "status", "words"),
    [
        ({"bits": 32}, "userland-bits", "fault", "32-bit programs on a 64-bit kernel"),
        ({"bits": 32, "architecture": "armv7l"}, "architecture", "fault", "64-bit system"),
        ({"architecture": "riscv64"}, "architecture", "warning", "aarch64 and x86_64"),
        ({"python": (3, 10, 9)}, "python", "fault", "3.11 to 3.13"),
        ({"python": (3, 14, 0)}, "python", "warning", "newer than what is tested"),
        ({"now": datetime(2027, 11, 1, tzinfo=UTC)}, "python", "warning", "no security updates"),
        ({"implementation": "PyPy"}, "python", "fault", "CPython"),
        ({"libc": "glibc 2.27"}, "libc", "fault", "2.28"),
        ({"libc": "glibc 2.28"}, "libc", "good", "2.28"),
        ({"libc": ""}, "libc", "unknown", "2.28"),
        ({"page_bytes": 16384}, "page-size", "warning", "kernel8.img"),
        ({"hwcap": ASIMD_CRC | LSE}, "cpu-features", "good", "with LSE"),
        ({"hwcap": ASIMD_CRC}, "cpu-features", "good", "SIGILL"),
        ({"hwcap": 0}, "cpu-features", "unknown", "getauxval"),
        ({"now": datetime(1970, 1, 2, tzinfo=UTC)}, "clock-synchronised", "warning", "1970-01-02"),
        ({"folder": Path("/no/such/folder")}, "disk-free", "unknown", "/no/such/folder"),
    ],
)  # fmt: skip
def test_facts_are_judged(
    tmp_path: Path, facts: dict[str, Any], name: str, status: str, words: str
) -> None:
    finding = told(machine(tmp_path, **facts))[name]
    assert (finding.status, words in finding.message) == (status, True), finding


SWAP_TIGHT = (
    "MemTotal: 3884092 kB\nMemAvailable: 1048576 kB\nSwapTotal: 2048000 kB\nSwapFree: 512000 kB\n"
)
SMALL = "MemTotal: 921600 kB\nMemAvailable: 204800 kB\nSwapTotal: 0 kB\nSwapFree: 0 kB\n"


@pytest.mark.parametrize(
    ("files", "name", "status", "value"),
    [
        ({"proc/meminfo": SMALL}, "memory", "warning", 900),
        ({"proc/meminfo": SMALL}, "memory-available", "warning", 200),
        ({"proc/meminfo": SMALL}, "swap-used", "warning", 0),
        ({"proc/meminfo": SWAP_TIGHT}, "swap-used", "warning", 1500),
        ({"sys/fs/cgroup/memory.max": "536870912\n"}, "memory", "warning", 512),
        ({"sys/fs/cgroup/memory.max": "max\n"}, "memory", "good", 3884092 // 1024),
        ({"sys/fs/cgroup/memory.max": "536870912\n", "sys/fs/cgroup/memory.current": "419430400"},
         "memory-available", "warning", 112),
        ({"sys/class/thermal/thermal_zone0/temp": "80000"}, "temperature", "warning", 80.0),
        ({"sys/class/thermal/thermal_zone0/temp": "79900"}, "temperature", "good", 79.9),
        ({"sys/class/thermal/thermal_zone0/temp": "999999999"}, "temperature", "unknown", None),
        ({"sys/devices/platform/soc/soc:firmware/get_throttled": "50000\n"},
         "throttled", "warning", 0x50000),
        ({".dockerenv": ""}, "container", "good", "docker"),
        ({"run/.containerenv": ""}, "container", "good", "podman"),
        ({"proc/cpuinfo": "vendor_id : GenuineIntel\nmodel name : i7\nflags : sse avx\n"},
         "emulation", "warning", "qemu-user"),
        ({"proc/cpuinfo": "vendor_id : GenuineIntel\nmodel name : i7\nflags : sse avx\n"},
         "cpu", "unknown", None),
        ({"proc/sys/kernel/arch": "x86_64"}, "emulation", "warning", "qemu-user"),
        ({"proc/thread-self/cmdline": "/usr/bin/qemu-aarch64-static\0python3"},
         "emulation", "warning", "qemu-user"),
        ({"proc/device-tree/compatible": "linux,dummy-virt\0"},
         "emulation", "good", "virtual machine"),
        ({"proc/cpuinfo": "CPU implementer : 0x41\nCPU part : 0xfff\n"},
         "cpu", "good", "part 0xfff"),
        ({"proc/cpuinfo": "CPU implementer : 0x61\nCPU part : 0xd08\n"},
         "cpu", "good", "part 0xd08"),
    ],
)  # fmt: skip
def test_files_are_judged(
    tmp_path: Path, files: dict[str, str], name: str, status: str, value: Any
) -> None:
    finding = told(machine(tmp_path, {**PI4, **files}))[name]
    assert (finding.status, finding.value) == (status, value), finding


@pytest.mark.parametrize(
    ("free", "flag", "status"),
    [(2000, 0, "good"), (999, 0, "warning"), (49, 0, "fault"), (0, os.ST_RDONLY, "good")],
)
def test_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free: int, flag: int, status: str
) -> None:
    real = os.statvfs(tmp_path)
    numbers = [*real][:10]
    numbers[0] = numbers[1] = 2**20  # block size
    numbers[2], numbers[3], numbers[4], numbers[8] = 10**6, free, free, flag
    monkeypatch.setattr(os, "statvfs", lambda path: os.statvfs_result(numbers))
    finding = told(machine(tmp_path))["disk-free"]
    assert (finding.value, finding.status) == (free, status)


def test_x86_features_come_from_the_kernels_list(tmp_path: Path) -> None:
    files = {"proc/cpuinfo": "vendor_id : x\nmodel name : An i7\nflags : fpu sse4_2 avx avx2\n"}
    found = told(machine(tmp_path, {**files}, architecture="x86_64"))
    assert found["cpu-features"].value == ("sse4_2", "avx", "avx2")
    assert found["cpu"].value == "An i7"
    files = {"proc/cpuinfo": "vendor_id : x\nmodel name : Old\nflags : fpu sse4_2 hypervisor\n"}
    found = told(machine(tmp_path, {**files}, architecture="x86_64"))
    assert found["cpu-features"].status == "warning"
    assert "tensorflow" in found["cpu-features"].message
    assert found["emulation"].value == "virtual machine"


@pytest.mark.parametrize(
    ("said", "status", "words"),
    [
        ("throttled=0x0", "good", ["not since the start"]),
        ("throttled=0x1", "warning", ["under-voltage now", "power supply"]),
        ("throttled=0x50005", "warning",
         ["under-voltage and throttled now", "under-voltage and throttled since the start"]),
        ("throttled=0xe0000", "warning",
         ["frequency capped and throttled and soft temperature limit since", "fan"]),
        ("throttled=0xZZ", "unknown", ["group video"]),
        ("VCHI initialization failed", "unknown", ["group video"]),
        ("", "unknown", ["group video"]),
    ],
)  # fmt: skip
def test_throttling_bits_are_decoded(
    tmp_path: Path, no_tool: Path, said: str, status: str, words: list[str]
) -> None:
    vcgencmd(no_tool, f"echo '{said}'")
    finding = told(machine(tmp_path))["throttled"]
    assert finding.status == status
    for word in words:
        assert word in finding.message


@pytest.mark.parametrize(
    "script", ["exit 1", "exec sleep 60", "head -c 300000 /dev/urandom", "kill -9 $$"]
)
def test_a_broken_vcgencmd_harms_nothing(
    tmp_path: Path, no_tool: Path, monkeypatch: pytest.MonkeyPatch, script: str
) -> None:
    monkeypatch.setenv("PATH", f"{no_tool}:/usr/bin:/bin")
    vcgencmd(no_tool, script)
    assert told(machine(tmp_path))["throttled"].status == "unknown"


def test_a_vcgencmd_that_is_no_program_harms_nothing(tmp_path: Path, no_tool: Path) -> None:
    (no_tool / "vcgencmd").write_bytes(b"\x7fELFnonsense")
    (no_tool / "vcgencmd").chmod(0o755)
    assert told(machine(tmp_path))["throttled"].status == "unknown"


def test_an_empty_root_tells_nothing_and_raises_nothing(tmp_path: Path) -> None:
    found = told(machine(tmp_path, {}, hwcap=0, libc="", architecture=""))
    for name in ("board", "temperature", "throttled", "cpu", "os", "memory", "swap-used"):
        assert found[name].status == "unknown"
        assert found[name].value is None


@given(noise=st.binary(max_size=300))
def test_noise_in_every_file_raises_nothing(
    noise: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    root = tmp_path_factory.mktemp("noise")
    found = told(machine(root, dict.fromkeys(PI4, noise)))
    assert len(found) == 19
    assert not [name for name, finding in found.items() if "could not be told" in finding.message]


def test_folders_where_files_should_be_raise_nothing(tmp_path: Path) -> None:
    for name in PI4:
        (tmp_path / "root" / name).mkdir(parents=True)
    assert len(told(machine(tmp_path, {}))) == 19


def test_a_probe_that_raises_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self: Machine, path: str) -> str:
        raise RuntimeError("secret words")

    monkeypatch.setattr(Machine, "text", broken)
    found = told(machine(tmp_path))
    assert found["board"].message == "could not be told: RuntimeError"
    assert "clock-synchronised" in found


def test_the_digest_tells_cloned_cards_apart(tmp_path: Path) -> None:
    one = machine(tmp_path / "a").identity()
    other = {**PI4, "proc/device-tree/serial-number": "10000000abcdef02\0"}
    (tmp_path / "b").mkdir()
    assert one is not None
    assert one == machine(tmp_path / "a").identity()
    assert one != machine(tmp_path / "b", other).identity()
    assert PI4["etc/machine-id"].strip() not in one
    (tmp_path / "c").mkdir()
    assert machine(tmp_path / "c", {}).identity() is None


def test_this_machine_is_told_as_others_tell_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = {finding.name: finding for finding in system_findings()}
    assert found["architecture"].value == os.uname().machine
    assert found["page-size"].value == os.sysconf("SC_PAGESIZE")
    memory, page = found["memory"].value, os.sysconf("SC_PAGESIZE")
    assert isinstance(memory, int)
    assert memory <= os.sysconf("SC_PHYS_PAGES") * page // 2**20
    if os.uname().machine == "aarch64":
        assert found["cpu-features"].value is not None


@pytest.mark.parametrize(
    ("state", "status"), [(True, "good"), (False, "warning"), (None, "unknown")]
)
def test_the_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, state: bool | None, status: str
) -> None:
    monkeypatch.setattr(sys.modules[clock.__module__], "synchronised", lambda: state)
    (finding,) = clock(machine(tmp_path))
    assert (finding.status, finding.value) == (status, state)


def test_the_kernels_own_word_on_the_clock_agrees(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", os.defpath)
    tool = shutil.which("adjtimex") or shutil.which("ntptime")
    from qrobot.health.system.clock import synchronised

    if tool is None:
        pytest.skip("no other program to ask the kernel")
    said = subprocess.run([tool, *(["-p"] if "adjtimex" in tool else [])],
                          capture_output=True, text=True, check=False).stdout  # fmt: skip
    assert synchronised() is not ("UNSYNC" in said or "status: 64" in said)
