"""``qrobot replan``: a new plan while robots drive."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import click

from qrobot.cli.options import FILE, objective, written
from qrobot.cli.streams import say, say_json
from qrobot.errors import InputError

if TYPE_CHECKING:
    from qrobot.planning.state import State

__all__ = ["command"]

AISLE = re.compile(r"(\d{1,6})(?::(\d{1,6}))?")


@click.command("replan")
@click.argument("state", type=FILE)
@click.option("--cancel", "cancelled", multiple=True, metavar="ORDER", help="Nobody wants it.")
@click.option("--missing", multiple=True, metavar="ITEM", help="It is not where it should be.")
@click.option("--lost", multiple=True, metavar="ROBOT", help="It has broken down.")
@click.option(
    "--close", "closed", multiple=True, metavar="AISLE[:BLOCK]", help="Nobody can enter it."
)
@click.option("--add", type=FILE, help="New orders: an instance in the same warehouse.")
@objective
@click.option(
    "--stability",
    type=float,
    default=1.0,
    show_default=True,
    help="What changing an untouched trip costs, in usual costs of a trip; 0: nothing.",
)
@click.option("--deadline", "-t", type=float, help="Seconds.  [default: 2]")
@click.option("--max-work", type=int, help="Limit of work units, for the same plan anywhere.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of every random choice.")
@written("--output", "-o", help="Write the plan of the open orders, .json.")
@written("--open", "open_file", help="Write the open orders and robots as an instance, .json.")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON, nothing else.")
def command(
    state: str, output: str | None, open_file: str | None, as_json: bool, **asked: Any
) -> None:
    """Plan the rest of a plan in progress anew, and tell what changes.

    STATE is a file that `qrobot state` wrote, maybe changed by hand. Robots under way finish
    their trips with what is on board; all other orders are planned for the robots as they come
    back. Trips that nothing forces to change stay as they are, unless a change pays.

    \b
    Examples:
      qrobot replan state.json
      qrobot replan state.json --cancel C --lost R2 --objective makespan
      qrobot replan state.json --add more.json --stability 0 -t 5
      qrobot replan state.json --close 3:0 -o plan.json --open open.json
    """
    from qrobot import write
    from qrobot._files import check_outputs
    from qrobot.planning import read_state, replan

    files = [path for path in (output, open_file) if path is not None]
    check_outputs(files, [path for path in (state, asked["add"]) if path is not None])
    changes = {name: asked.pop(name) for name in ("cancelled", "missing", "lost", "closed", "add")}
    found = replan(_changed(read_state(state), **changes), **asked)
    if found.result is not None:
        if output is not None:
            found.result.save(output)
        if open_file is not None:
            write(found.result.instance, open_file)
    if as_json:
        say_json(found.to_dict())
        return
    say(found.summary())
    if files and found.result is not None:
        say(f"written: {', '.join(files)}")


def _changed(
    state: State,
    cancelled: tuple[str, ...],
    missing: tuple[str, ...],
    lost: tuple[str, ...],
    closed: tuple[str, ...],
    add: str | None,
) -> State:
    """Return a state with what else has happened."""
    from dataclasses import replace

    from qrobot import read
    from qrobot.planning.state import RobotState

    instance = state.instance
    if add is not None:
        more = read(add)
        if more.warehouse != instance.warehouse:
            raise InputError("is of another warehouse", source=add, advice="give one of the same")
        try:
            instance = replace(
                instance,
                items=(*instance.items, *more.items),
                orders=(*instance.orders, *more.orders),
            )
        except InputError as error:
            raise error.in_file(add) from None
    if closed:
        instance = replace(instance, warehouse=_closed(instance.warehouse, closed))
    robots = {one.robot: one for one in state.robots}
    for name in lost:
        robots[name] = replace(robots.get(name, RobotState(name)), lost=True)
    return replace(
        state,
        instance=instance,
        robots=tuple(robots.values()),
        cancelled=(*state.cancelled, *cancelled),
        missing=(*state.missing, *missing),
    )


def _closed(warehouse: Any, closed: tuple[str, ...]) -> Any:
    """Return a warehouse with more closed aisles."""
    from dataclasses import replace

    from qrobot.problem import AisleWarehouse

    if not isinstance(warehouse, AisleWarehouse):
        raise InputError(
            f"a warehouse of kind {warehouse.kind} does not have aisles",
            field="--close",
            advice="change the state's warehouse",
        )
    parts = set(warehouse.closed_aisles)
    for text in closed:
        found = AISLE.fullmatch(text)
        if found is None:
            raise InputError(
                f"{text!r} is not an aisle", field="--close", advice="write 3 or, of one block, 3:0"
            )
        blocks = range(warehouse.blocks) if found[2] is None else [int(found[2])]
        parts |= {(int(found[1]), block) for block in blocks}
    return replace(warehouse, closed_aisles=frozenset(parts))
