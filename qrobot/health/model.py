"""What a check found: one model for the terminal, JSON and every report to come."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from qrobot._version import __version__

__all__ = ["SCHEMA", "CheckResult", "Status", "report"]

SCHEMA = "qrobot.health/1"
"""Name and version of the JSON; the number rises when a field changes its meaning or goes."""

Status = Literal["pass", "fail", "absent", "error"]
"""Right, wrong, not installed, or no answer at all (it crashed, hung, took too much memory)."""


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
        What the stack computed, and what it should have.
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
    answer: tuple[float, ...] | None
    expected: tuple[float, ...] | None
    tolerance: float
    message: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; a number that is not finite becomes ``None``."""
        return asdict(self) | {
            "answer": _plain(self.answer),
            "expected": _plain(self.expected),
        }


def report(results: Sequence[CheckResult]) -> dict[str, Any]:
    """Return results as the document that ``qrobot health --json`` prints."""
    return {
        "schema": SCHEMA,
        "qrobot": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "checks": [result.to_dict() for result in results],
    }


def _plain(numbers: tuple[float, ...] | None) -> list[float | None] | None:
    if numbers is None:
        return None
    return [number if math.isfinite(number) else None for number in numbers]
