"""``qrobot compare-routing``: a plan's trips by every routing policy."""

from __future__ import annotations

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options_of_plan
from qrobot.cli.streams import say, say_json

__all__ = ["command"]


@click.command("compare-routing", cls=ReadingCommand)
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@click.option(
    "--picture",
    "-p",
    multiple=True,
    type=FILE,
    help="Draw the ways, a panel a policy: .svg, .png or .html. Repeatable.",
)
@reading_options_of_plan
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON, nothing else.")
def command(plan: str, question: Question, picture: tuple[str, ...], as_json: bool) -> None:
    """Compare the routing policies that pickers know on the trips of a plan.

    The orders stay on their trips; each trip is walked by a shortest tour, by S-shape, return,
    midpoint, largest gap, combined, aisle-by-aisle, and in the sequence of the locations. Policies
    that say nothing about the layout are named with the reason. Give --robots, --capacity and
    --split-orders as they were given to solve.

    \b
    Examples:
      qrobot compare-routing plan.json examples/small-warehouse.json
      qrobot compare-routing plan.json examples/small-warehouse.json --picture ways.html
      qrobot compare-routing plan.json orders.csv --layout layout.json --json
    """
    from qrobot._files import check_outputs
    from qrobot.plan import read_plan
    from qrobot.report import check_picture_path, compare_routing

    for path in picture:
        check_picture_path(path, animated=True)
    check_outputs([*picture], [plan, *question.files])
    comparison = compare_routing(read_plan(plan), question.read())
    notes = dict.fromkeys(note for path in picture for note in comparison.draw(path))
    for note in notes:
        say(f"qrobot: warning: {note}", err=True)
    if as_json:
        say_json(comparison.to_dict())
        return
    say(comparison.to_text())
    for path in picture:
        say(f"written: {path}")
