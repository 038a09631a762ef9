"""``qrobot picklist``: what each robot takes at each stop, for people, paper and programs."""

from __future__ import annotations

from typing import Any

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options_of_plan, written
from qrobot.cli.streams import say, say_json
from qrobot.errors import InputError

__all__ = ["command"]

FORMATS = ("csv", "json", "html")


@click.command("picklist", cls=ReadingCommand)
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@click.option(
    "--format",
    "form",
    type=click.Choice(FORMATS),
    help="What is written.  [default: as OUTPUT ends; a table on the terminal]",
)
@written("--output", "-o", help="Write the lists to a file, not to the standard output.")
@click.option("--robot", multiple=True, help="Only the lists of this robot. Repeatable.")
@click.option(
    "--paper",
    type=click.Choice(["a4", "a5", "label"]),
    help="What the page is printed on; a label is 100 x 150 mm.  [default: a4]",
)
@reading_options_of_plan
@click.option("--json", "as_json", is_flag=True, help="Print the lists as JSON, nothing else.")
def command(
    plan: str,
    question: Question,
    form: str | None,
    output: str | None,
    robot: tuple[str, ...],
    paper: str | None,
    as_json: bool,
) -> None:
    """Print what each robot takes at each stop, and the basket that it goes into.

    PLAN is a plan that solve wrote, INSTANCE its question; the plan is checked first. Every trip
    has a list: location, article, quantity, basket (one for each order of the trip) and the
    load so far. As html it is a page to be printed, with a map, and each trip begins on a new
    sheet. Give --robots, --capacity, --split-orders and the like as they were given to solve.

    \b
    Examples:
      qrobot picklist plan.json examples/small-warehouse.json
      qrobot picklist plan.json examples/small-warehouse.json -o picks.html
      qrobot picklist plan.json examples/small-warehouse.json -o r1.html --robot R1 --paper label
      qrobot picklist plan.json orders.csv --layout layout.json --format csv
      qrobot picklist plan.json examples/small-warehouse.json --json
    """
    form = _form(form, output, as_json)
    if paper is not None and form != "html":
        raise InputError("is for pages", field="--paper", advice="add --format html")
    from qrobot._files import check_outputs, write_text_atomic
    from qrobot._text import count
    from qrobot.plan import read_plan
    from qrobot.report import pick_lists

    check_outputs([output] if output is not None else [], [plan, *question.files])
    lists = pick_lists(read_plan(plan), question.read(), robot)
    if output is not None:
        write_text_atomic(output, _text(lists, form, paper))
    if as_json or (form == "json" and output is None):
        say_json(lists.to_dict())
    elif output is not None:
        picks = sum(len(one.picks) for one in lists.lists)
        trips, taken = count(len(lists.lists), "list"), count(picks, "pick")
        say(f"written: {output} ({trips}, {taken})")
    else:
        say(_text(lists, form, paper), end="")


def _form(form: str | None, output: str | None, as_json: bool) -> str:
    """Return the format that is asked for; ``text`` is the table on a terminal."""
    if form is None and output is not None:
        form = output.lower().rpartition(".")[2]
        if form not in FORMATS:
            raise InputError(
                f"{output!r} does not say the format",
                field="--output",
                advice="end it with .csv, .json or .html, or give --format",
            )
    if as_json and output is None and form not in (None, "json"):
        raise InputError(
            f"--json contradicts --format {form}", field="--format", advice="give one of them"
        )
    return form or ("json" if as_json else "text")


def _text(lists: Any, form: str, paper: str | None) -> str:
    if form == "html":
        from qrobot.report import picklist_page

        return picklist_page(lists, paper or "a4")
    return str({"csv": lists.to_csv, "json": lists.to_json, "text": lists.to_text}[form]())
