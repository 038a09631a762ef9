"""One report as tables, sentences and facts: what the terminal and the page have in common."""

from __future__ import annotations

from datetime import UTC, datetime

from qrobot._text import Table, count
from qrobot.health.model import CheckResult, Finding, Report

__all__ = [
    "attention",
    "checks_table",
    "facts",
    "machine_line",
    "system_table",
    "totals_line",
    "when",
]


def checks_table(report: Report) -> Table:
    """Return one row a check."""
    return Table(
        "Checks",
        ("check", "result", "version", "import s", "run s", "peak MB"),
        tuple(
            (
                check.name,
                check.status,
                next(iter(check.versions.values()), "-"),  # of the stack itself
                _number(check.import_seconds, 2),
                _number(check.run_seconds, 3),
                _number(check.peak_mb, 0),
            )
            for check in report.checks
        ),
        frozenset({3, 4, 5}),
        1,
    )


def system_table(report: Report) -> Table:
    """Return one row a finding."""
    return Table(
        "Machine",
        ("fact", "status", "value", "meaning"),
        tuple((f.title, f.status, f.text(), f.message) for f in report.system),
        status=1,
    )


def attention(report: Report) -> tuple[list[Finding], list[CheckResult]]:
    """Return what somebody has to look at: faults and failures before warnings and absences."""
    findings = [f for f in report.system if f.status in ("fault", "warning")]
    checks = [check for check in report.checks if check.status != "pass"]
    ranks = {"error": 0, "fail": 0, "fault": 0, "absent": 1, "warning": 1}
    return (
        sorted(findings, key=lambda finding: ranks[finding.status]),
        sorted(checks, key=lambda check: ranks[check.status]),
    )


def machine_line(report: Report) -> str:
    """Return the machine in one line."""
    parts = [report.model or "", report.machine]
    for name in ("cpu", "memory", "temperature", "os"):
        found = report.finding(name)
        if found is not None and found.value is not None:
            parts.append(found.text())
    return ", ".join(part for part in (*parts, f"Python {report.python}") if part)


def totals_line(report: Report) -> str:
    """Return how many checks and findings there are of each status, in one line."""
    total = report.totals
    checks = (
        f"{total['pass']} passed, {total['fail']} failed, "
        f"{total['error']} without an answer, {total['absent']} absent"
    )
    if not report.system:
        return checks
    faults, warnings = count(total["fault"], "fault"), count(total["warning"], "warning")
    return f"{checks}; machine: {faults}, {warnings}"


def when(report: Report) -> str:
    """Return when a report was made, for people: UTC, to the minute."""
    return f"{datetime.fromisoformat(report.made).astimezone(UTC):%Y-%m-%d %H:%M}"


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


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
