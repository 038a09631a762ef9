"""Right plans of drawn instances, made without any solver; used by the tests of several rooms.

>>> from plans import plans, restated
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from hypothesis import assume
from hypothesis import strategies as st
from strategies import instances

from qrobot.plan import Plan, Trip
from qrobot.problem import Instance

__all__ = ["planned", "plans", "restated"]


def planned(instance: Instance, choices: list[int]) -> Plan | None:
    """Return a plan that puts each order on a trip that has room, as the choices say.

    Returns
    -------
    Plan or None
        ``None`` when some order found no room.
    """
    seats = [robot.capacity for robot in instance.robots for _ in range(robot.trips)]
    weight = {item.id: item.weight for item in instance.items}
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    routes: list[list[int]] = [[] for _ in seats]
    for order, choice in zip(instance.orders, choices, strict=True):
        load = sum((weight[i] for i in order.items), Fraction(0))
        roomy = [k for k, room in enumerate(seats) if room >= load]
        if not roomy:
            return None
        seat = roomy[choice % len(roomy)]
        seats[seat] -= load
        routes[seat] += [node[i] for i in order.items]
    return Plan.from_routes(instance, routes)


@st.composite
def plans(draw: st.DrawFn, **options: Any) -> tuple[Plan, Instance]:
    """Draw an instance and a right (not a good) plan of it."""
    instance = draw(instances(**options))
    count = len(instance.orders)
    plan = planned(instance, draw(st.lists(st.integers(0, 99), min_size=count, max_size=count)))
    assume(plan is not None)
    assert plan is not None
    return plan, instance


def restated(plan: Plan, instance: Instance) -> Plan:
    """Return the plan with orders, loads, distances and times stated as its stops demand."""
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    weight = {item.id: item.weight for item in instance.items}
    owner = {item: order.id for order in instance.orders for item in order.items}
    speed = {robot.id: robot.speed for robot in instance.robots}

    def again(trip: Trip) -> Trip:
        nodes = [0, *(node[s] for s in trip.stops), 0]
        length = float(sum(instance.distances[a, b] for a, b in pairwise(nodes)))
        return replace(
            trip,
            orders=tuple(dict.fromkeys(owner[s] for s in trip.stops)),
            distance=length,
            load=float(sum((weight[s] for s in trip.stops), Fraction(0))),
            seconds=length / speed.get(trip.robot, 1.0),
        )

    trips = tuple(again(trip) for trip in plan.trips)
    return replace(plan, trips=trips, distance=sum(t.distance for t in trips))
