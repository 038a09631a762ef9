"""What was found: one model for the terminal, JSON and every other face."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

__all__ = ["SCHEMA", "CheckResult", "Finding", "FindingStatus", "Report", "Status"]

SCHEMA = "qrobot.health/1"
"""Name and version of the JSON; the number rises when a field changes its meaning or goes."""

Status = Literal["pass", "fail", "absent", "error"]
"""Right, wrong, not installed, or no answer at all (it crashed, hung, took too much memory)."""

FindingStatus = Literal["good", "warning", "fault", "unknown"]
"""Fine; worth a look; qRobot cannot work here; could not be told."""

Value = bool | int | float | str | tuple[str, ...] | None
"""What a finding may hold."""


@dataclass(frozen=True)
class CheckResult:
    """The outcome of one check.

    Parameters
    ----------
    name, title, group
        Which check it was.
    status
        ``pass``, ``fail``: an answer came and is right or wrong. ``absent``: the stack is not
        installed. ``error``: there was no answer.
    versions
        Distribution to version, read from the metadata; installed ones only.
    import_seconds, run_seconds
        Wall-clock time of the imports and of the computation; None where it was not reached.
    peak_mb
        Largest resident memory in MiB; for a process that was killed, the largest seen.
    answer, expected
        What the stack computed, and what it should have; in a report that was read, a number
        that was not finite is None.
    tolerance
        Largest allowed absolute difference of any of the numbers.
    message
        What went wrong, or where the expected answer comes from.
    """

    name: str
    title: str
    group: str
    status: Status
    versions: dict[str, str]
    import_seconds: float | None
    run_seconds: float | None
    peak_mb: float | None
    answer: tuple[float | None, ...] | None
    expected: tuple[float | None, ...] | None
    tolerance: float
    message: str

    @property
    def seconds(self) -> float | None:
        """Import and computation together; None where the computation was not reached."""
        return None if self.run_seconds is None else (self.import_seconds or 0.0) + self.run_seconds

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; a number that is not finite becomes ``None``."""
        return asdict(self) | {
            "answer": _finite(self.answer),
            "expected": _finite(self.expected),
        }


@dataclass(frozen=True)
class Finding:
    """One fact about the machine, and whether qRobot can live with it.

    Parameters
    ----------
    name, title
        For programs, and for people.
    status
        ``good``, ``warning``: worth a look, never changes the exit code. ``fault``: qRobot
        cannot work here. ``unknown``: could not be told.
    value
        For programs: a number, a text, a yes or no, a list of words; None when unknown.
    message
        What it means, with the advice, as one clause.
    unit
        Of a number: ``MiB``, ``°C``, ``bytes``, ``hex`` for a number of bits; None without one.
    steady
        A property of the machine, which a comparison shows when it changes; False for what
        is another at every moment, such as a temperature.
    """

    name: str
    title: str
    status: FindingStatus
    value: Value
    message: str
    unit: str | None = None
    steady: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)

    def text(self) -> str:
        """Return the value as people read it, with its unit."""
        if self.value is None:
            return "-"
        if isinstance(self.value, bool):
            return "yes" if self.value else "no"
        if isinstance(self.value, tuple):
            return " ".join(self.value) or "none"
        if self.unit == "hex" and isinstance(self.value, int):
            return f"{self.value:#x}"
        number = f"{self.value:.1f}" if isinstance(self.value, float) else str(self.value)
        return f"{number} {self.unit}" if self.unit else number


@dataclass(frozen=True)
class Report:
    """One run on one machine.

    Parameters
    ----------
    qrobot, python
        Versions.
    made
        When the run began: UTC, ISO 8601.
    host
        The machine's name.
    machine_id
        Tells machines of one name apart: a digest of the system's own id, which it does not
        give away; None where the system has none.
    machine, model
        Architecture, and the board's name or None.
    profile
        What was asked for: a profile, ``quick``, ``all`` or ``named``.
    required
        Whether an absent stack is a fault.
    seconds
        Wall-clock time of the whole run.
    system
        About the machine; empty when it was left out.
    checks
        In the sequence of their groups, or as they were named.
    """

    qrobot: str
    python: str
    made: str
    host: str
    machine_id: str | None
    machine: str
    model: str | None
    profile: str
    required: bool
    seconds: float
    system: tuple[Finding, ...]
    checks: tuple[CheckResult, ...]

    @property
    def bad(self) -> list[CheckResult]:
        """The checks that make this machine unhealthy."""
        wrong = {"fail", "error", "absent"} if self.required else {"fail", "error"}
        return [check for check in self.checks if check.status in wrong]

    @property
    def faults(self) -> list[Finding]:
        """The findings that make this machine unhealthy."""
        return [finding for finding in self.system if finding.status == "fault"]

    @property
    def healthy(self) -> bool:
        """Whether all is right; warnings do not count."""
        return not self.bad and not self.faults

    @property
    def totals(self) -> dict[str, int]:
        """How many checks and findings there are of each status."""
        checks = Counter(check.status for check in self.checks)
        findings = Counter(finding.status for finding in self.system)
        return {
            **{name: checks[name] for name in ("pass", "fail", "error", "absent")},
            **{name: findings[name] for name in ("good", "warning", "fault", "unknown")},
        }

    @property
    def versions(self) -> dict[str, str]:
        """Every distribution that a check met, with its version."""
        found: dict[str, str] = {}
        for check in self.checks:
            found |= check.versions
        return dict(sorted(found.items()))

    def finding(self, name: str) -> Finding | None:
        """Return the finding of a name."""
        return next((finding for finding in self.system if finding.name == name), None)

    def to_dict(self) -> dict[str, Any]:
        """Return the document that ``qrobot health --json`` prints."""
        return {
            "schema": SCHEMA,
            **{f.name: getattr(self, f.name) for f in fields(self)[:-2]},  # the lists come last
            "healthy": self.healthy,
            "totals": self.totals,
            "system": [finding.to_dict() for finding in self.system],
            "checks": [check.to_dict() for check in self.checks],
        }


def _finite(numbers: tuple[float | None, ...] | None) -> list[float | None] | None:
    if numbers is None:
        return None
    return [n if n is not None and math.isfinite(n) else None for n in numbers]
