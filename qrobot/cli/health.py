"""``qrobot health``: every installed stack computes something whose answer is known."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from qrobot.health import Check, CheckResult

__all__ = ["command"]


@click.command("health")
@click.argument("names", nargs=-1)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
@click.option("--quick", is_flag=True, help="The cheap checks only.")
@click.option("--list", "as_list", is_flag=True, help="List the checks and run none.")
@click.option(
    "--timeout", type=click.FloatRange(min=0, min_open=True), default=300.0, show_default=True,
    metavar="SECONDS", help="What one check may take.",
)  # fmt: skip
def command(
    names: tuple[str, ...], as_json: bool, quick: bool, as_list: bool, timeout: float
) -> None:
    """Prove that every installed stack computes right.

    Each check imports one stack and lets it compute something whose answer is known from
    elsewhere, in a process of its own: a crash or a hang is reported and the others go on.
    Without NAMES all are run; a stack that is not installed is then no fault.

    Exit code 0: healthy, 1: a check failed, or one that was named is absent, 2: bad input.

    \b
    Examples:
      qrobot health
      qrobot health qiskit aer --json
      qrobot health --quick
    """
    from qrobot.health import Limits, choose, report, run

    checks = choose(names, quick=quick)
    if as_list:
        click.echo(_list(checks, as_json))
        return
    results = []
    for number, check in enumerate(checks, 1):
        click.echo(f"{number}/{len(checks)} {check.name}", err=True)
        results.append(run(check, Limits(seconds=timeout)))
    click.echo(json.dumps(report(results), indent=1) if as_json else _table(results))
    bad = {"fail", "error", "absent"} if names else {"fail", "error"}
    sys.exit(1 if any(result.status in bad for result in results) else 0)


def _list(checks: list[Check], as_json: bool) -> str:
    from qrobot.report.text import columns

    if as_json:
        rows: list[dict[str, Any]] = [
            {"name": c.name, "group": c.group, "title": c.title, "quick": c.quick,
             "expected_from": c.source, "extra": c.extra, "versions": c.versions()}
            for c in checks
        ]  # fmt: skip
        return json.dumps(rows, indent=1)
    heads = ["check", "group", "computes", "quick", "installed"]
    return columns(
        heads,
        [
            [c.name, c.group, c.title, "yes" if c.quick else "no", _first_version(c.versions())]
            for c in checks
        ],
    )


def _first_version(versions: dict[str, str]) -> str:
    return next(iter(versions.values()), "no")


def _table(results: list[CheckResult]) -> str:
    from qrobot.report.text import columns

    heads = ["check", "result", "version", "import s", "run s", "peak MB"]
    lines = [
        [r.name, r.status, _first_version(r.versions), _number(r.import_seconds, 2),
         _number(r.run_seconds, 3), _number(r.peak_mb, 0)]
        for r in results
    ]  # fmt: skip
    told = [f"{r.name}: {r.message}" for r in results if r.status != "pass"]
    counts = [
        f"{sum(r.status == status for r in results)} {word}"
        for status, word in (
            ("pass", "passed"), ("fail", "failed"), ("error", "without an answer"),
            ("absent", "absent"),
        )
    ]  # fmt: skip
    return "\n".join([columns(heads, lines, frozenset({3, 4, 5})), *told, ", ".join(counts)])


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
