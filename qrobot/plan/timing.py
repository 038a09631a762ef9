"""When trips begin and end: each robot makes its own one after the other, as early as it may."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from qrobot.problem.entities import Robot
from qrobot.problem.instance import Instance

__all__ = ["TimedRoute", "lateness", "overdue", "seconds_of", "spans", "timed"]

ROUNDING = 1e-9
"""Relative and absolute, seconds: a trip that ends so much after a deadline keeps it."""


class TimedRoute(NamedTuple):
    """What the time of a trip depends on, whoever makes it.

    Parameters
    ----------
    length
        Metres.
    standing
        Seconds of set-up and of collecting.
    release
        When all its orders are there, seconds.
    orders
        Indices of its orders, rising.
    load
        In units of the instance.
    """

    length: float
    standing: float
    release: float
    orders: tuple[int, ...]
    load: int


def timed(instance: Instance, route: Sequence[int], length: float | None = None) -> TimedRoute:
    """Return what the time of a route depends on.

    Parameters
    ----------
    instance
        The question.
    route
        Its nodes (item index + 1).
    length
        Its length, where it is known already.
    """
    orders = tuple(sorted({int(instance.order_of_node[v]) for v in route}))
    items = instance.items
    return TimedRoute(
        instance.route_length(route) if length is None else length,
        instance.times.per_trip + math.fsum(instance.times.of(items[v - 1]) for v in route),
        max((instance.orders[o].release for o in orders), default=0.0),
        orders,
        sum(int(instance.weights[v - 1]) for v in route),
    )


def seconds_of(trip: TimedRoute, speed: float) -> float:
    """Return how long a robot of a speed needs for a trip, with its set-up."""
    return trip.standing + trip.length / speed


def spans(trips: Iterable[TimedRoute], robot: Robot) -> list[tuple[float, float]]:
    """Return when each trip of a robot begins and ends, seconds since all robots began.

    A trip, with its set-up, begins when the robot is available or back from the one before, and
    all orders of the trip are released.
    """
    found, now = [], robot.available
    for trip in trips:
        begins = max(now, trip.release)
        now = begins + seconds_of(trip, robot.speed)
        found.append((begins, now))
    return found


def _after(ends: float, time: float) -> float:
    """Return how long after a time a trip ends; what is within rounding is not late."""
    return 0.0 if ends <= time + ROUNDING * (1.0 + ends) else ends - time


def lateness(instance: Instance, trip: TimedRoute, ends: float) -> float:
    """Return the seconds after due times of all orders of a trip, times their priorities."""
    orders = instance.orders
    return sum(orders[o].priority * _after(ends, orders[o].due) for o in trip.orders)


def overdue(instance: Instance, trip: TimedRoute, ends: float) -> float:
    """Return the seconds after deadlines of all orders of a trip."""
    return sum(_after(ends, instance.orders[o].deadline) for o in trip.orders)
