"""Another number of robots than a file has."""

from __future__ import annotations

import dataclasses
from itertools import count as numbers
from itertools import islice

from qrobot.errors import InputError
from qrobot.problem.entities import Robot
from qrobot.problem.validity import MAX_ITEMS

__all__ = ["fleet_of_size"]


def fleet_of_size(robots: tuple[Robot, ...], count: int | None, orders: int) -> tuple[Robot, ...]:
    """Return so many robots.

    Parameters
    ----------
    robots
        Those that there are.
    count
        How many are wanted; ``None`` sets no limit.
    orders
        How many there are to collect: no limit means a trip for each.

    Raises
    ------
    InputError
        When the count is out of range, or more than there are and these are not alike.
    """
    if count is None:
        largest = max(robots, key=lambda r: r.capacity)
        return tuple(
            dataclasses.replace(largest, id=f"R{k + 1}", trips=1) for k in range(max(orders, 1))
        )
    if isinstance(count, bool) or not isinstance(count, int):
        raise InputError(
            f"{count!r} is not a number of robots",
            field="robots",
            advice="give a whole number above 0, or 'free'",
        )
    if count < 1:
        raise InputError(
            f"{count} robots are too few", field="robots", advice="give 1 or more, or 'free'"
        )
    if count > MAX_ITEMS:
        raise InputError(
            f"{count} robots are more than {MAX_ITEMS}", field="robots", advice="give fewer"
        )
    if count <= len(robots):
        return robots[:count]
    if len({(r.capacity, r.speed, r.trips) for r in robots}) > 1:
        raise InputError(
            f"{count} robots are more than the {len(robots)} that there are, and these are not "
            "alike",
            field="robots",
            advice=f"give at most {len(robots)}, describe more of them in the file, or give 'free'",
        )
    used = {robot.id for robot in robots}
    names = (name for k in numbers(1) if (name := f"R{k}") not in used)
    more = islice(names, count - len(robots))
    return (*robots, *(dataclasses.replace(robots[0], id=name) for name in more))
