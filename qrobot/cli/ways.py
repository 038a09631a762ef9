"""``qrobot ways``: where robots drive and halt, as GeoJSON for maps of other programs."""

from __future__ import annotations

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options_of_plan, written
from qrobot.cli.streams import say, say_json

__all__ = ["command"]


@click.command("ways", cls=ReadingCommand)
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@written("--output", "-o", help="Write to a file, not to the standard output.")
@reading_options_of_plan
def command(plan: str, question: Question, output: str | None) -> None:
    """Write the ways and stops of a plan as GeoJSON.

    PLAN is a plan that solve wrote, INSTANCE its question; the plan is checked first. A line for
    each trip and a point for each stop and the depot (RFC 7946); coordinates are metres of the
    warehouse's own frame, that of the map where it is one. Give --robots, --capacity,
    --split-orders and the like as they were given to solve.

    \b
    Examples:
      qrobot ways plan.json examples/small-warehouse.json
      qrobot ways plan.json examples/small-warehouse.json -o plan.geojson
    """
    from qrobot._files import check_outputs, write_text_atomic
    from qrobot.plan import read_plan
    from qrobot.report import geojson, geojson_text

    check_outputs([output] if output is not None else [], [plan, *question.files])
    answer, instance = read_plan(plan), question.read()
    if output is None:
        say_json(geojson(answer, instance))
    else:
        write_text_atomic(output, geojson_text(answer, instance))
        say(f"written: {output}")
