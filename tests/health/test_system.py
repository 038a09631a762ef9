"""What is said of a machine, held against made-up machines."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from health.made_up import ASIMD_CRC, LSE, PI4, machine, told, vcgencmd

from qrobot.health.system import system_findings

pytestmark = pytest.mark.usefixtures("no_tool")


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
        ({"sys/fs/cgroup/memory.max": "536870912\n", "sys/fs/cgroup/memory.current": "419430400",
          "sys/fs/cgroup/memory.stat": "file 1\ninactive_file 314572800\nactive_file 7\n"},
         "memory-available", "good", 412),  # a cache of files is free when somebody needs it
        ({"sys/fs/cgroup/memory.max": "536870912\n", "sys/fs/cgroup/memory.current": "1000",
          "sys/fs/cgroup/memory.stat": "inactive_file 2000\n"}, "memory-available", "good", 512),
        ({"sys/fs/cgroup/memory/memory.limit_in_bytes": "536870912\n",
          "sys/fs/cgroup/memory/memory.usage_in_bytes": "419430400\n",
          "sys/fs/cgroup/memory/memory.stat":
          "inactive_file 1048576\ntotal_inactive_file 314572800\n"},
         "memory-available", "good", 412),
        ({"sys/fs/cgroup/memory/memory.limit_in_bytes": "9223372036854771712\n"},
         "memory", "good", 3884092 // 1024),
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
