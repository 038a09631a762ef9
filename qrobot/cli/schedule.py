"""``qrobot schedule``: when each robot is where, and when the last one is back."""

from __future__ import annotations

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options_of_plan, written
from qrobot.cli.streams import say, say_json
from qrobot.errors import InputError

__all__ = ["command"]


@click.command("schedule", cls=ReadingCommand)
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@click.option(
    "--per-aisle",
    type=int,
    metavar="N",
    help="At most N robots at a time in each sub-aisle; others wait at its crossing.",
)
@written("--output", "-o", help="Write every stop to a file, .csv or .json.")
@written("--picture", "-p", help="Draw a bar a trip, a row a robot: .svg or .png.")
@reading_options_of_plan
@click.option("--json", "as_json", is_flag=True, help="Print the schedule as JSON, nothing else.")
def command(
    plan: str,
    question: Question,
    per_aisle: int | None,
    output: str | None,
    picture: str | None,
    as_json: bool,
) -> None:
    """Print when each robot leaves and is back, trip by trip.

    PLAN is a plan that solve wrote, INSTANCE its question; the plan is checked first. All robots
    begin at once, each makes its trips one after the other, drives at its speed and stays at
    each stop as long as the pick takes. Give --robots, --capacity, --split-orders and the like
    as they were given to solve.

    \b
    Examples:
      qrobot schedule plan.json examples/small-warehouse.json
      qrobot schedule plan.json examples/small-warehouse.json -p bars.svg
      qrobot schedule plan.json examples/small-warehouse.json --per-aisle 1
      qrobot schedule plan.json orders.csv --layout layout.json -o stops.csv
      qrobot schedule plan.json examples/small-warehouse.json --json
    """
    form = output.lower().rpartition(".")[2] if output is not None else ""
    if form not in ("", "csv", "json"):
        raise InputError(
            f"{output!r} does not say the format",
            field="--output",
            advice="end it with .csv or .json",
        )
    from qrobot._files import check_outputs, write_text_atomic
    from qrobot.plan import read_plan
    from qrobot.report import check_picture_path, draw_schedule, schedule

    files = [path for path in (output, picture) if path is not None]
    check_outputs(files, [plan, *question.files])
    if picture is not None:
        check_picture_path(picture)
    found = schedule(read_plan(plan), question.read(), per_aisle=per_aisle)
    if output is not None:
        write_text_atomic(output, found.to_csv() if form == "csv" else found.to_json())
    for note in draw_schedule(found, picture) if picture is not None else ():
        say(f"qrobot: note: {note}", err=True)
    if as_json:
        say_json(found.to_dict())
        return
    say(found.to_text(), end="")
    if files:
        say(f"written: {', '.join(files)}")
