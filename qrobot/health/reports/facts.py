"""What of a report can be held against another one."""

from __future__ import annotations

from qrobot.health.model import CheckResult, Finding, Report

__all__ = ["facts", "seconds"]


def facts(report: Report) -> dict[str, str]:
    """Return the steady facts of a machine as text; what could not be told is left out."""
    found = {"architecture": report.machine, "python": report.python}
    if report.model:
        found["board"] = report.model
    for finding in report.system:
        if finding.steady and finding.value is not None:
            found[finding.name] = _text(finding)
    return found


def _text(finding: Finding) -> str:
    if finding.name == "memory" and isinstance(finding.value, int):
        # The kernel keeps some MiB for itself, and more or less of it with every version.
        return f"{finding.value / 1024:.1f} GiB"
    return finding.text()


def seconds(check: CheckResult) -> float | None:
    """Return what a check that passed took, import and computation."""
    if check.status != "pass" or check.run_seconds is None:
        return None
    return (check.import_seconds or 0.0) + check.run_seconds
