"""A plan as a table: trip, robot, load, distance, stops."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from qrobot._numbers import number
from qrobot._text import columns

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["table"]

STOPS_WIDTH = 60


def table(result: Result) -> str:
    """Return the trips of a result as aligned text, long stop lists on several lines."""
    capacity = {robot.id: float(robot.capacity) for robot in result.instance.robots}
    rows: list[list[str]] = []
    for place, trip in enumerate(result.plan.trips, 1):
        wrapped = textwrap.wrap(
            " ".join(trip.stops), STOPS_WIDTH, break_long_words=False, break_on_hyphens=False
        )
        rows.append(
            [
                str(place),
                trip.robot,
                f"{number(trip.load)} / {number(capacity[trip.robot])}",
                number(trip.distance),
                f"{trip.seconds:.0f} s",
                str(len(trip.orders)),
                wrapped[0] if wrapped else "",
            ]
        )
        rows.extend([["", "", "", "", "", "", more] for more in wrapped[1:]])
    heads = ["trip", "robot", "load", "distance", "time", "orders", "stops in sequence"]
    return columns(heads, rows, numbers=frozenset({0, 2, 3, 4, 5}))
