"""``qrobot check``: the independent checker by itself."""

from __future__ import annotations

import sys

import click

from qrobot.cli.options import FILE, Robots, ignore_columns, rounding
from qrobot.cli.streams import say, say_json

__all__ = ["command"]


@click.command("check")
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@click.option("--layout", type=FILE, help="Layout and robots of CSV orders.")
@ignore_columns
@rounding
@click.option("--robots", type=Robots(), help="The number of robots that the plan was made with.")
@click.option("--capacity", help="The capacity that the plan was made with.")
@click.option("--split-orders", is_flag=True, help="The orders were allowed to be split.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
def command(
    plan: str,
    instance: str,
    layout: str | None,
    ignore_columns: tuple[str, ...],
    rounding: str | None,
    robots: int | str | None,
    capacity: str | None,
    split_orders: bool,
    as_json: bool,
) -> None:
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
    from qrobot.problem.formats import read

    answer = read_plan(plan)
    question = read(
        instance,
        layout=layout,
        robots=robots,
        capacity=capacity,
        split_orders=split_orders,
        rounding=rounding,
        ignore_columns=ignore_columns,
    )
    report = check(answer, question)
    if as_json:
        say_json(report.to_dict())
    else:
        say(str(report))
    sys.exit(0 if report.ok else 1)
