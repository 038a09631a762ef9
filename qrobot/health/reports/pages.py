"""Pages: one report, and the reports of many machines beside each other."""

from __future__ import annotations

from pathlib import Path

from qrobot.health.model import Report
from qrobot.health.reports.compare import Comparison
from qrobot.health.reports.fleet import FleetHealth
from qrobot.health.reports.summary import (
    attention,
    checks_table,
    machine_line,
    system_table,
    totals_line,
    when,
)
from qrobot.pages import Bar, render

__all__ = ["fleet_html", "html"]

HERE = Path(__file__).parent


def html(report: Report, comparison: Comparison | None = None) -> str:
    """Return the page of one report: what needs attention first, then charts, then all of it.

    Parameters
    ----------
    report
        What was found.
    comparison
        With an earlier report, to be shown beside it.
    """
    asked = "the checks that were named" if report.profile == "named" else report.profile
    times, memory = _charts(report)
    return render(
        HERE / "report.html",
        report=report,
        machine=machine_line(report),
        when=when(report),
        asked=asked + (", none may be absent" if report.required else ""),
        totals=totals_line(report),
        attention=_attention(report),
        comparison=comparison,
        times=times,
        memory=memory,
        checks=checks_table(report),
        system=system_table(report),
    )


def fleet_html(fleet: FleetHealth) -> str:
    """Return the page of a fleet: who is unhealthy, what differs and on whom, and who is slow."""
    notes = [*fleet.notes, *fleet.bad_lines(), *fleet.slow_lines()]
    differences = [column.sentence().partition(": ") for column in fleet.columns]
    return render(
        HERE / "fleet.html",
        fleet=fleet,
        notes=[("", "", note) for note in notes],
        differences=[("", f"{head}:", rest) for head, _, rest in differences],
        pace=[Bar(name, (pace,), f"{pace:.2f}") for name, pace in fleet.pace.items() if pace],
    )


def _attention(report: Report) -> list[tuple[str, str, str]]:
    findings, checks = attention(report)
    rows: list[tuple[str, str, str]] = [(f.status, f.title, f.message) for f in findings]
    rows += [(check.status, check.name, check.message) for check in checks]
    return sorted(rows, key=lambda row: row[0] not in {"fault", "fail", "error"})


def _charts(report: Report) -> tuple[list[Bar], list[Bar]]:
    """Return the seconds and the memory of the checks that began."""
    times, memory = [], []
    for check in report.checks:
        if check.import_seconds is not None:
            parts = (check.import_seconds, check.run_seconds or 0.0)
            took = sum(parts)
            times.append(Bar(check.name, parts, f"{took:.2f}" if took < 100 else f"{took:.0f}"))
        if check.peak_mb is not None:
            memory.append(Bar(check.name, (check.peak_mb,), f"{check.peak_mb:.0f}"))
    return times, memory
