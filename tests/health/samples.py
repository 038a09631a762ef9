"""Reports as other machines would write them, for tests of what is made of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from qrobot.health import CheckResult, Finding, Report
from qrobot.health.model import Status

NASTY = "<b>&\"'</b> \x00\x1b[31m \ud800 ü 5 > 3 ]]>"


def check(name: str, status: Status = "pass", **fields: Any) -> CheckResult:
    """Return a check that reached all, unless its status or the fields say otherwise."""
    reached = status in ("pass", "fail")
    known: dict[str, Any] = {
        "name": name,
        "title": f"what {name} computes",
        "group": "base",
        "status": status,
        "versions": {} if status == "absent" else {name: "1.2.3"},
        "import_seconds": 0.5 if status != "absent" else None,
        "run_seconds": 0.25 if reached else None,
        "peak_mb": 80.0 if status != "absent" else None,
        "answer": (1.0, 2.0) if reached else None,
        "expected": (1.0, 2.0) if reached else None,
        "tolerance": 1e-9,
        "message": f"why {name} is {status}",
    }
    return CheckResult(**known | fields)


FINDINGS = (
    Finding("board", "Board", "good", "Raspberry Pi 4 Model B Rev 1.4", "as it names itself"),
    Finding("temperature", "Temperature", "good", 51.5, "cool", "°C", steady=False),
    Finding(
        "throttled", "Throttling", "warning", 0x50005, "under-voltage now", "hex", steady=False
    ),
    Finding("cpu-features", "Instructions", "good", ("neon", "crc32"), "no LSE"),
    Finding("memory", "Memory", "good", 3792, "in all", "MiB"),
    Finding("memory-available", "Memory available", "good", 2000, "free", "MiB", steady=False),
    Finding("clock-synchronised", "Clock synchronised", "good", True, "it is", steady=False),
    Finding("libc", "C library", "unknown", None, "not told"),
)


def report(host: str = "pi-01", **fields: Any) -> Report:
    """Return a healthy report of a Pi, unless the fields say otherwise."""
    known: dict[str, Any] = {
        "qrobot": "0.1.0",
        "python": "3.11.2",
        "made": "2026-11-20T08:00:00+00:00",
        "host": host,
        "machine_id": f"id-{host}",
        "machine": "aarch64",
        "model": "Raspberry Pi 4 Model B Rev 1.4",
        "profile": "all",
        "required": False,
        "seconds": 12.5,
        "system": FINDINGS,
        "checks": (check("numpy"), check("qiskit", group="gate model"), check("dimod")),
    }
    return Report(**known | fields)


def changed(one: Report, name: str, **fields: Any) -> Report:
    """Return a report whose check of a name has other fields."""
    checks = tuple(replace(c, **fields) if c.name == name else c for c in one.checks)
    return replace(one, checks=checks)


def found(one: Report, name: str, **fields: Any) -> Report:
    """Return a report whose finding of a name has other fields."""
    system = tuple(replace(f, **fields) if f.name == name else f for f in one.system)
    return replace(one, system=system)


MIXED = replace(
    report(),
    checks=(
        check("numpy"),
        check("scipy", "fail", message="number 1 is 2, expected is 1"),
        check("aer", "error", group="gate model"),
        check("pyscf", "absent", group="science"),
    ),
)
BROKEN = found(MIXED, "memory", status="fault", message="too little")

STRANGE = replace(
    report(host=NASTY, model=NASTY),
    checks=(
        check("numpy", "error", message=NASTY, title=NASTY),
        check(NASTY, group=NASTY, versions={NASTY: NASTY}),
    ),
    system=(Finding("x", NASTY, "warning", NASTY, NASTY),),
)
