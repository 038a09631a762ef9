"""``qrobot state``: where a plan stands at a moment."""

from __future__ import annotations

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options_of_plan, written
from qrobot.cli.streams import say, say_json

__all__ = ["command"]


@click.command("state", cls=ReadingCommand)
@click.argument("plan", type=FILE)
@click.argument("instance", type=FILE)
@click.option("--now", type=float, required=True, help="Seconds since all robots began.")
@written("--output", "-o", help="Write the state to a .json file.")
@reading_options_of_plan
@click.option("--json", "as_json", is_flag=True, help="Print the state as JSON, nothing else.")
def command(plan: str, question: Question, now: float, output: str | None, as_json: bool) -> None:
    """Print what is delivered and under way at a moment, if all goes as planned.

    PLAN is a plan that solve wrote, INSTANCE its question. The file that --output writes can be
    changed by hand (orders added, robots lost, items picked) and given to replan.

    \b
    Examples:
      qrobot state plan.json examples/morning.json --now 160
      qrobot state plan.json examples/morning.json --now 160 -o state.json
    """
    from qrobot._files import check_outputs
    from qrobot._text import count, printable
    from qrobot.plan import read_plan
    from qrobot.planning import state_at

    files = [output] if output is not None else []
    check_outputs(files, [plan, *question.files])
    found = state_at(read_plan(plan), question.read(), now)
    if output is not None:
        found.save(output)
    if as_json:
        say_json(found.to_dict())
        return
    say(f"after {now:g} s {count(len(found.delivered), 'order')} delivered")
    for one in found.robots:
        where = f"at the depot since {one.back:g} s" if one.back else "at the depot"
        if one.trip:
            picked = count(len(one.picked), "item")
            where = f"on trip {one.trip} with {picked} on board, back at {one.back:g} s"
        say(f"{printable(one.robot)}: {where}")
    if files:
        say(f"written: {files[0]}")
