"""The board: its model, its temperature, and whether the firmware slows it down."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress

from qrobot.health.model import Finding
from qrobot.health.system.machine import Machine

__all__ = ["THROTTLED", "board", "board_model"]

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
    about = ("temperature", "Temperature")
    found: dict[str, float] = {}
    for zone in machine.folders("sys/class/thermal/thermal_zone*"):
        thousandths = machine.number(f"{zone}/temp")
        if thousandths is not None and -40_000 < thousandths < 150_000:
            found[machine.text(f"{zone}/type") or zone] = thousandths / 1000
    if not found:
        return Finding(*about, "unknown", None, "no sensor tells", "°C", steady=False)
    named = [found[name] for name in PROCESSOR_ZONES if name in found]
    degrees = round(named[0] if named else max(found.values()), 1)
    if degrees >= HOT:
        text = f"a Raspberry Pi slows down from {HOT:.0f} °C; add a heat sink or a fan"
        return Finding(*about, "warning", degrees, text, "°C", steady=False)
    return Finding(*about, "good", degrees, f"below {HOT:.0f} °C", "°C", steady=False)


def _throttled(machine: Machine, model: str | None) -> Finding:
    about = ("throttled", "Throttling")
    bits = _throttled_bits(machine)
    if bits is None:
        text = "no Raspberry Pi firmware tells"
        if "Raspberry Pi" in (model or ""):
            text = "vcgencmd does not tell; install it, and add the user to the group video"
        return Finding(*about, "unknown", None, text, steady=False)
    now = [name for bit, name in THROTTLED.items() if bits >> bit & 1]
    before = [name for bit, name in THROTTLED.items() if bits >> (bit + 16) & 1]
    if not now and not before:
        return Finding(*about, "good", bits, "not since the start", "hex", steady=False)
    parts = [f"{' and '.join(now)} now"] if now else []
    parts += [f"{' and '.join(before)} since the start"] if before else []
    advice = "add a heat sink or a fan"
    if "under-voltage" in now + before:
        advice = "use the board's own power supply and a short, thick cable"
    return Finding(*about, "warning", bits, f"{', '.join(parts)}; {advice}", "hex", steady=False)


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
            told = done.stdout.decode(errors="replace")
            if found := re.fullmatch(r"throttled=0x([0-9a-fA-F]{1,8})", told.strip()):
                return int(found[1], 16)
    # The kernel of Raspberry Pi OS shows the same, where vcgencmd may not be run.
    for path in machine.folders("sys/devices/platform/soc/soc*firmware/get_throttled"):
        if found := re.fullmatch(r"(?:0x)?([0-9a-fA-F]{1,8})", machine.text(path) or ""):
            return int(found[1], 16)
    return None
