"""``qrobot check``: the independent checker by itself."""

from __future__ import annotations

import sys

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options_of_plan
from qrobot.cli.streams import show

__all__ = ["command"]


@click.command("check", cls=ReadingCommand)
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@reading_options_of_plan
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
def command(plan: str, question: Question, as_json: bool) -> None:
    """Check a plan against its instance, without trusting any solver.

    Every item once, orders whole, loads within capacity, robots known, and every distance
    measured anew. Give --robots, --capacity and --split-orders as they were given to solve.
    Exit code 0: right, 1: problems found, 2: a file cannot be read.

    \b
    Examples:
      qrobot check plan.json examples/small-warehouse.json
      qrobot check plan.json examples/small-warehouse.json --json
      qrobot check plan.json orders.csv --layout layout.json --split-orders
    """
    from qrobot.plan import check, read_plan

    report = check(read_plan(plan), question.read())
    show(str(report), report.to_dict(), as_json)
    sys.exit(0 if report.ok else 1)
