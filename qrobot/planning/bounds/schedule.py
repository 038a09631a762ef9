"""A bound for objectives that count trips, robots, and when orders are back."""

from __future__ import annotations

import math
from collections.abc import Sequence

from qrobot.plan.objective import Objective
from qrobot.planning.bounds.quick import fewest_trips, least_trips
from qrobot.problem import Instance

__all__ = ["schedule_bound"]


def schedule_bound(instance: Instance, objective: Objective, distance: float) -> float:
    """Return a cost that no plan is below, when none is shorter than a distance.

    Each part of the objective has its own bound. The trips cost the lowest rate for a metre, and
    there must be so many of them; all robots work until the last is back, so the makespan is no
    less than the least work shared out evenly, nor than the trip of any one order by the fastest
    robot after its release; and no order is back before that.
    """
    if not instance.orders:
        return 0.0
    trips = fewest_trips(instance)
    value = objective.bound(instance, distance) + objective.per_robot
    value += trips * objective.per_trip(instance.times)
    fastest = max(robot.speed for robot in instance.robots)
    times, items = instance.times, instance.items
    alone = [
        order.release
        + times.per_trip
        + math.fsum(times.of(items[v - 1]) for v in nodes)
        + least / fastest
        for order, nodes, least in zip(
            instance.orders, instance.order_nodes, least_trips(instance).tolist(), strict=True
        )
    ]
    standing = trips * times.per_trip + math.fsum(map(times.of, items))
    shared = _least_end(distance, standing, [robot.speed for robot in instance.robots])
    value += objective.makespan * max(shared, *alone)
    value += objective.lateness * math.fsum(
        order.priority * max(0.0, ends - order.due)
        for order, ends in zip(instance.orders, alone, strict=True)
    )
    return float(value * (1 - 1e-9))


def _least_end(distance: float, standing: float, speeds: Sequence[float]) -> float:
    """Return when robots are back at the soonest that share metres and seconds of standing.

    A robot of speed v that drives x seconds and stands y until T has v x + p y <= max(v, p) T, for
    any p >= 0. Summed over all robots: distance + p standing <= T sum of max(v, p).
    """
    ends = [standing / len(speeds)]
    for price in (0.0, *speeds):
        together = math.fsum(max(v, price) for v in speeds)
        ends.append((distance + price * standing) / together)
    return max(ends)
