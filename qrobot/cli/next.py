"""``qrobot next``: which waiting order a robot should collect, from where it stands."""

from __future__ import annotations

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options
from qrobot.cli.streams import show

__all__ = ["command"]

NEXT_SCHEMA = "qrobot.next/1"


@click.command("next", cls=ReadingCommand)
@click.argument("instance", type=FILE)
@click.option(
    "--at",
    metavar="PLACE",
    default="depot",
    show_default=True,
    help="Where the robot stands: depot, the id of an item or the label of its bin, AISLE,SLOT or "
    "AISLE,SLOT,BLOCK (from 0), X,Y, or the node of a table.",
)
@click.option("--robot", metavar="ID", help="Whose capacity and speed count.  [default: the first]")
@reading_options
@click.option("--json", "as_json", is_flag=True, help="Print the ranking as JSON, nothing else.")
def command(question: Question, at: str, robot: str | None, as_json: bool) -> None:
    """Rank the waiting orders by what each costs from where a robot stands now.

    One order at a time, each by a shortest way past its items and on to the depot; the extra
    distance is what is longer than going to the depot at once. Orders that are too heavy for the
    robot are left out. To collect several orders on one trip: qrobot solve.

    \b
    Examples:
      qrobot next examples/small-warehouse.json
      qrobot next examples/small-warehouse.json --at 8,10,1
      qrobot next examples/small-warehouse.json --at 12-a --robot R2
      qrobot next examples/orders.csv --layout examples/layout.json --json
    """
    from qrobot._text import count, shown
    from qrobot.planning import rank_orders
    from qrobot.report.tables import ranking_table

    instance = question.read()
    ranked = rank_orders(instance, at, robot)
    heavy = len(instance.orders) - len(ranked)
    lines = [f"next: {shown(ranked[0].order)}" if ranked else "no order waits"]
    if ranked:
        lines += ["", ranking_table(ranked)]
    if heavy:
        lines += ["", f"left out: {count(heavy, 'order')} too heavy for the robot"]
    document = {
        "schema": NEXT_SCHEMA,
        "instance": instance.name,
        "at": at,
        "robot": robot or instance.robots[0].id,
        "orders": [one.to_dict() for one in ranked],
    }
    show("\n".join(lines), document, as_json)
