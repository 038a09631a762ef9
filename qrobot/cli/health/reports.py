"""``qrobot health compare`` and ``merge``, which read reports; and reports as text for a terminal.

A terminal must obey no character of theirs: they may come from another machine.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

from qrobot._text import Table, columns, printable
from qrobot.cli.options import FILE, written
from qrobot.cli.streams import show
from qrobot.errors import InputError

if TYPE_CHECKING:
    from qrobot.health import Finding, Report
    from qrobot.health.reports import Comparison, FleetHealth

__all__ = ["compare_", "merge", "show_comparison", "show_fleet", "show_report"]


@click.command("compare")
@click.argument("before", type=FILE)
@click.argument("after", type=FILE)
@click.option("--strict", is_flag=True, help="Exit with 1 for any difference.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def compare_(before: str, after: str, strict: bool, as_json: bool) -> None:
    """Show what drifted from one report to another.

    Exit code 0: nothing got worse, 1: a check did or a fact of the machine became a fault, 2: a
    file is not a report. Times, memory and what changes all the time, such as a temperature, do
    not count as drift.

    \b
    Examples:
      qrobot health compare monday.json today.json
      qrobot health compare pi-01.json pi-02.json --strict --json
    """
    from qrobot.health import read_report
    from qrobot.health.reports import compare

    found = compare(read_report(before), read_report(after))
    show(show_comparison(found), found.to_dict(), as_json)
    sys.exit(1 if found.worse or (strict and found.drift) else 0)


@click.command("merge")
@click.argument("files", nargs=-1, required=True, type=FILE)
@written("--html", "html_path", help="Write a page.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def merge(files: tuple[str, ...], html_path: str | None, as_json: bool) -> None:
    """Show which machine of a fleet differs, and in what.

    FILES are reports that qrobot health --output wrote, one a machine; of several of one machine
    the newest counts. Exit code 0: all machines are healthy, 1: one is not, 2: a file is not a
    report or the page cannot be written.

    \b
    Examples:
      qrobot health merge reports/*.json
      qrobot health merge reports/*.json --html fleet.html
    """
    from qrobot._files import check_outputs, write_text_atomic
    from qrobot.health import read_report
    from qrobot.health.reports import fleet, fleet_html

    check_outputs([html_path] if html_path else [], files)
    found = fleet([read_report(path) for path in files])
    trouble = None
    if html_path:
        try:
            write_text_atomic(html_path, fleet_html(found))
        except InputError as error:  # a full disk; the terminal still has it
            trouble = error
    show(show_fleet(found), found.to_dict(), as_json)
    if trouble is not None:
        raise trouble
    sys.exit(1 if found.unhealthy else 0)


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
