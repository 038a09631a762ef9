"""Reports on a terminal, which must obey no character of theirs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from qrobot._text import Table, columns, printable

if TYPE_CHECKING:
    from qrobot.health import Finding, Report
    from qrobot.health.reports import Comparison, FleetHealth

__all__ = ["show_comparison", "show_fleet", "show_report"]

COLUMNS = 6
"""Most columns of differences in the table of a fleet; more are told in sentences only."""


def show_report(report: Report, comparison: Comparison | None) -> str:
    """Return the table of the checks, and a sentence for all that needs attention."""
    from qrobot.health.reports import attention, checks_table, machine_line, totals_line

    findings, checks = attention(report)
    lines: list[str] = []
    if report.system:
        lines += _lines([machine_line(report)])
    if report.checks:
        lines.append(_text(checks_table(report)))
    lines += _lines(f"{check.name}: {check.message}" for check in checks)
    lines += _lines(_sentence(finding) for finding in findings)
    if comparison is not None:
        lines.append(show_comparison(comparison))
    return "\n".join([*lines, totals_line(report)])


def show_comparison(comparison: Comparison) -> str:
    """Return the changes as a table."""
    lines = [_text(comparison.table())] if comparison.changes else []
    return "\n".join([*lines, *_lines([comparison.headline()])])


def show_fleet(fleet: FleetHealth) -> str:
    """Return the machines as a table, and what differs in sentences."""
    few = len(fleet.columns) <= COLUMNS
    lines = [_text(fleet.table(None if few else []))]
    lines += _lines(column.sentence() for column in fleet.columns)
    lines += _lines([*fleet.bad_lines(), *fleet.slow_lines(), *fleet.notes])
    return "\n".join([*lines, fleet.headline()])


def _text(table: Table) -> str:
    return columns(_lines(table.heads), [_lines(row) for row in table.rows], table.numbers)


def _lines(texts: Iterable[str]) -> list[str]:
    """Return each text as one line that a terminal only shows."""
    return [printable(text) for text in texts]


def _sentence(finding: Finding) -> str:
    said = finding.value is None or isinstance(finding.value, bool)  # by the status already
    value = "" if said else f" {finding.text()}"
    return f"{finding.status}: {finding.title}{value}: {finding.message}"
