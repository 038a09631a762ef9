"""``qrobot health compare``: two reports against each other."""

from __future__ import annotations

import sys

import click

from qrobot.cli.options import FILE
from qrobot.cli.streams import say, say_json

__all__ = ["compare_"]


@click.command("compare")
@click.argument("before", type=FILE)
@click.argument("after", type=FILE)
@click.option("--strict", is_flag=True, help="Any drift is code 1.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def compare_(before: str, after: str, strict: bool, as_json: bool) -> None:
    """Show what drifted from one report to another.

    Exit code 0: nothing got worse, 1: a check did or a fact of the machine became a fault, 2: a
    file is not a report. Times, memory and what is another at every moment, such as a temperature,
    do not count as drift.

    \b
    Examples:
      qrobot health compare monday.json today.json
      qrobot health compare pi-01.json pi-02.json --strict --json
    """
    from qrobot.cli.health.show import show_comparison
    from qrobot.health import read_report
    from qrobot.health.reports import compare

    found = compare(read_report(before), read_report(after))
    if as_json:
        say_json(found.to_dict())
    else:
        say(show_comparison(found))
    sys.exit(1 if found.worse or (strict and found.drift) else 0)
