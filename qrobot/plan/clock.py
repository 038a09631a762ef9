"""The checker's own clock: what a plan costs in time, robots and trips, without the solvers' code.

It walks through the trips of each robot as a person with a watch would: the robot waits until the
last order of its trip is there, sets up, drives, collects, and looks at the clock when it is back.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from qrobot.plan.objective import MEASURES
from qrobot.plan.plan import Trip
from qrobot.problem.entities import Item, Robot
from qrobot.problem.instance import Instance

__all__ = ["Measures", "measure"]


@dataclass(frozen=True, slots=True)
class Measures:
    """What a plan comes to by every measure.

    Parameters
    ----------
    distance
        Metres of all trips.
    time
        Seconds that robots work: set-up, driving, collecting; waiting does not count.
    makespan
        When the last robot is back, seconds.
    lateness
        Seconds of all orders after their due times, times their priorities.
    trips, robots
        How many there are, and how many robots leave the depot.
    back
        For each order when its trip is back, seconds.
    """

    distance: float
    time: float
    makespan: float
    lateness: float
    trips: int
    robots: int
    back: Mapping[str, float]

    def value(self, name: str) -> float:
        """Return one of the numbers by its name."""
        return float(getattr(self, name))

    def to_dict(self) -> dict[str, float]:
        """Return the numbers as plain data, without the orders."""
        return {name: self.value(name) for name in MEASURES}

    def late(self, instance: Instance) -> dict[str, float]:
        """Return for each order that is late by how much, seconds."""
        due = {order.id: order.due for order in instance.orders}
        return {
            name: back - due[name]
            for name, back in self.back.items()
            if back - due[name] > 1e-9 * (1.0 + back)
        }


def measure(instance: Instance, trips: Sequence[Trip], lengths: Sequence[float]) -> Measures:
    """Return what trips with measured lengths come to; those of unknown robots are passed over."""
    robots: dict[str, Robot] = {robot.id: robot for robot in instance.robots}
    items: dict[str, Item] = {item.id: item for item in instance.items}
    owner = {item: order for order in instance.orders for item in order.items}
    watch: dict[str, float] = {}
    back: dict[str, float] = {}
    worked = 0.0
    for trip, length in zip(trips, lengths, strict=True):
        robot = robots.get(trip.robot)
        if robot is None:
            continue
        now = watch.get(robot.id, robot.available)
        own = [items[stop] for stop in trip.stops if stop in items]
        for item in own:
            now = max(now, owner[item.id].release)
        begun = now
        now += instance.times.per_trip
        for item in own:
            now += item.pick_seconds + instance.times.per_pick
            now += instance.times.per_piece * item.quantity + instance.times.per_level * item.level
        now += length / robot.speed
        watch[robot.id] = now
        worked += now - begun
        for item in own:
            back[owner[item.id].id] = max(now, back.get(owner[item.id].id, 0.0))
    wishes = {order.id: order for order in instance.orders}
    return Measures(
        distance=math.fsum(lengths),
        time=worked,
        makespan=max(watch.values(), default=0.0),
        lateness=math.fsum(
            wishes[name].priority * max(0.0, when - wishes[name].due) for name, when in back.items()
        ),
        trips=len(trips),
        robots=len(watch),
        back=back,
    )
