"""The board and its processor: model, temperature, throttling; features, page size, emulation."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from functools import partial

from qrobot._machine import read_cpuinfo
from qrobot.health.model import Finding
from qrobot.health.system.machine import Machine

__all__ = ["HOT", "THROTTLED", "board", "board_model", "processor"]

HOT = 80.0
"""Degrees Celsius from which a Raspberry Pi 4 slows its cores."""

TIMEOUT = 0.4
"""Seconds that vcgencmd may take."""

THROTTLED = {
    0: "under-voltage",
    1: "frequency capped",
    2: "throttled",
    3: "soft temperature limit",
}
"""Bits of ``vcgencmd get_throttled``: now; the same sixteen bits higher: since the start."""

PROCESSOR_ZONES = ("cpu-thermal", "cpu_thermal", "soc-thermal", "x86_pkg_temp", "TCPU")

WHEELS = ("aarch64", "x86_64")
"""Architectures that every stack has compiled packages for."""

PARTS = {
    "0xd03": "Cortex-A53", "0xd04": "Cortex-A35", "0xd05": "Cortex-A55", "0xd07": "Cortex-A57",
    "0xd08": "Cortex-A72", "0xd09": "Cortex-A73", "0xd0a": "Cortex-A75", "0xd0b": "Cortex-A76",
    "0xd0c": "Neoverse-N1", "0xd40": "Neoverse-V1", "0xd49": "Neoverse-N2",
}  # fmt: skip
"""Arm's numbers of its processors (of implementer 0x41)."""

ARM = {"neon": 1, "aes": 3, "crc32": 7, "lse": 8, "fp16": 10, "dotprod": 20, "sve": 22}
"""Bits of AT_HWCAP on aarch64, from linux/arch/arm64/include/uapi/asm/hwcap.h."""

X86 = ("sse4_2", "avx", "f16c", "fma", "avx2", "avx512f")


def board(machine: Machine) -> Iterator[Finding]:
    """Find out about the board."""
    model = board_model(machine)
    if model is None:
        yield Finding("board", "Board", "unknown", None, "the firmware does not name it")
    else:
        yield Finding("board", "Board", "good", model, "as the firmware names it")
    yield _temperature(machine)
    yield _throttled(machine, model)


def board_model(machine: Machine) -> str | None:
    """Return what the firmware calls the board or computer."""
    if model := machine.text("proc/device-tree/model"):
        return model
    names = [machine.text(f"sys/class/dmi/id/{name}") for name in ("sys_vendor", "product_name")]
    return " ".join(name for name in names if name) or None


def _temperature(machine: Machine) -> Finding:
    fact = partial(Finding, "temperature", "Temperature", unit="°C", steady=False)
    found: dict[str, float] = {}
    for zone in machine.folders("sys/class/thermal/thermal_zone*"):
        thousandths = machine.number(f"{zone}/temp")
        if thousandths is not None and -40_000 < thousandths < 150_000:
            found[machine.text(f"{zone}/type") or zone] = thousandths / 1000
    if not found:
        return fact("unknown", None, "no sensor tells")
    named = [found[name] for name in PROCESSOR_ZONES if name in found]
    degrees = round(named[0] if named else max(found.values()), 1)
    if degrees >= HOT:
        text = f"a Raspberry Pi slows down from {HOT:.0f} °C; add a heat sink or a fan"
        return fact("warning", degrees, text)
    return fact("good", degrees, f"below {HOT:.0f} °C")


def _throttled(machine: Machine, model: str | None) -> Finding:
    fact = partial(Finding, "throttled", "Throttling", steady=False)
    bits = _throttled_bits(machine)
    if bits is None:
        text = "no Raspberry Pi firmware tells"
        if "Raspberry Pi" in (model or ""):
            text = "vcgencmd does not tell; install it, and add the user to the group video"
        return fact("unknown", None, text)
    now = [name for bit, name in THROTTLED.items() if bits >> bit & 1]
    before = [name for bit, name in THROTTLED.items() if bits >> (bit + 16) & 1]
    if not now and not before:
        return fact("good", bits, "not since the start", "hex")
    parts = [f"{' and '.join(now)} now"] if now else []
    parts += [f"{' and '.join(before)} since the start"] if before else []
    advice = "add a heat sink or a fan"
    if "under-voltage" in now + before:
        advice = "use the board's own power supply and a short, thick cable"
    return fact("warning", bits, f"{', '.join(parts)}; {advice}", "hex")


def _throttled_bits(machine: Machine) -> int | None:
    if tool := shutil.which("vcgencmd"):
        with suppress(OSError, ValueError, subprocess.SubprocessError):
            done = subprocess.run(
                [tool, "get_throttled"],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=TIMEOUT,
                check=False,
            )
            said = done.stdout.decode(errors="replace")
            if found := re.fullmatch(r"throttled=0x([0-9a-fA-F]{1,8})", said.strip()):
                return int(found[1], 16)
    # The kernel of Raspberry Pi OS shows the same, where vcgencmd may not be run.
    for path in machine.folders("sys/devices/platform/soc/soc*firmware/get_throttled"):
        if found := re.fullmatch(r"(?:0x)?([0-9a-fA-F]{1,8})", machine.text(path) or ""):
            return int(found[1], 16)
    return None


def processor(machine: Machine) -> Iterator[Finding]:
    """Find out about the processor."""
    about = read_cpuinfo(machine.root)
    yield _architecture(machine)
    yield _bits(machine)
    yield _processor_name(machine, about)
    yield _features(machine, about)
    yield _page(machine)
    yield _emulation(machine, about)


def _architecture(machine: Machine) -> Finding:
    name = machine.architecture
    fact = partial(Finding, "architecture", "Architecture")
    if name in WHEELS:
        return fact("good", name, "every stack has compiled packages for it")
    if machine.bits == 32 or name.startswith("armv"):
        return fact("fault", name or None, "there are no 32-bit packages; install a 64-bit system")
    text = f"compiled packages are known for {' and '.join(WHEELS)} only"
    return fact("warning", name or None, text)


def _bits(machine: Machine) -> Finding:
    fact = partial(Finding, "userland-bits", "Programs", unit="bits")
    if machine.bits == 64:
        return fact("good", 64, "64-bit programs")
    kernel = "64-bit kernel" if machine.architecture in WHEELS else "kernel"
    text = (
        f"{machine.bits}-bit programs on a {kernel}: no stack has packages for them; "
        "write the 64-bit image of Raspberry Pi OS to the card"
    )
    return fact("fault", machine.bits, text)


def _foreign(machine: Machine, about: dict[str, str]) -> bool:
    """Return whether /proc/cpuinfo is of another kind of processor: the emulator's host."""
    intel, arm = "vendor_id" in about, "CPU implementer" in about
    if machine.architecture == "aarch64":
        return intel
    return machine.architecture == "x86_64" and arm and not intel


def _processor_name(machine: Machine, about: dict[str, str]) -> Finding:
    if _foreign(machine, about):
        text = "/proc/cpuinfo is the host's, not that of the emulated processor"
        return Finding("cpu", "Processor", "unknown", None, text)
    name = about.get("model name", "")
    if not name and (part := about.get("CPU part", "")):
        arm = about.get("CPU implementer", "") in ("0x41", "")
        name = PARTS.get(part, f"part {part}") if arm else f"part {part}"
    text = f"{machine.cores} of its cores may be used"
    if not name:
        return Finding("cpu", "Processor", "unknown", None, "/proc/cpuinfo does not name it")
    return Finding("cpu", "Processor", "good", name, text)


def _features(machine: Machine, about: dict[str, str]) -> Finding:
    fact = partial(Finding, "cpu-features", "Instructions")
    if machine.architecture == "aarch64" and machine.bits == 64:
        if not machine.hwcap:
            return fact("unknown", None, "the C library does not tell (getauxval)")
        found = tuple(name for name, bit in ARM.items() if machine.hwcap >> bit & 1)
        text = "with LSE atomics"
        if "lse" not in found:
            text = (
                "no LSE atomics, as on any Raspberry Pi 3 and 4: a package built for newer "
                "processors dies with SIGILL"
            )
        return fact("good", found, text)
    if machine.architecture == "x86_64":
        flags = set(about.get("flags", "").split())
        if not flags:
            return fact("unknown", None, "/proc/cpuinfo lists none")
        found = tuple(name for name in X86 if name in flags)
        if "avx" in flags:
            return fact("good", found, "with AVX")
        return fact("warning", found, "no AVX: tensorflow's package needs it")
    return fact("unknown", None, "not known for this architecture")


def _page(machine: Machine) -> Finding:
    about, size = ("page-size", "Memory page"), machine.page_bytes
    if size == 4096:
        return Finding(*about, "good", size, "the usual size", "bytes")
    text = (
        "some compiled packages expect 4096; on a Raspberry Pi 5 put kernel=kernel8.img into "
        "/boot/firmware/config.txt when a check dies"
    )
    return Finding(*about, "warning", size, text, "bytes")


def _emulation(machine: Machine, about: dict[str, str]) -> Finding:
    fact = partial(Finding, "emulation", "Emulation")
    kernel = machine.text("proc/sys/kernel/arch")  # Linux 6.1: not rewritten by an emulator
    # qemu-user shows its guest a /proc/self of its own making, but not this view of it.
    command = machine.text("proc/thread-self/cmdline") or ""
    other = kernel is not None and kernel not in ("", machine.architecture)
    if other or "qemu-" in command[:200] or _foreign(machine, about):
        text = "a program plays the processor (qemu-user): times are not those of a machine"
        return fact("warning", "qemu-user", text)
    maker = " ".join(
        machine.text(path) or ""
        for path in (
            "sys/class/dmi/id/sys_vendor", "sys/class/dmi/id/product_name",
            "proc/device-tree/compatible", "sys/hypervisor/type",
        )
    ).lower()  # fmt: skip
    virtual = ("qemu", "kvm", "dummy-virt", "vmware", "virtualbox", "xen", "virtual machine")
    if any(name in maker for name in virtual) or "hypervisor" in about.get("flags", "").split():
        return fact("good", "virtual machine", "times depend on what it shares")
    if not about and not maker.strip():
        return fact("unknown", None, "/proc and /sys tell nothing")
    return fact("good", "none", "no sign of an emulator or a virtual machine")
