"""Time the trips of a plan: robots begin at once, wait for orders, and for each other if asked."""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from typing import TYPE_CHECKING

from qrobot._files import StrPath
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Instance
from qrobot.report.reservations import Reservations
from qrobot.report.scene import Journey, Scene, checked_scene
from qrobot.report.schedules import RobotSchedule, Schedule, TimedTrip
from qrobot.report.timeline import timeline

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["schedule", "schedule_of"]


def schedule(
    answer: Result | Plan | StrPath,
    instance: Instance | StrPath | None = None,
    *,
    per_aisle: int | None = None,
) -> Schedule:
    """Return when each robot is where.

    Parameters
    ----------
    answer
        A result, or a plan (or the path of its file) together with its instance.
    instance
        The question; needed for a plan alone.
    per_aisle
        How many robots may be in a sub-aisle at once: others wait at the crossing. ``None``: any
        number, and nobody waits.

    Raises
    ------
    InputError
        When the plan is not right for the instance, as `qrobot.check` says, or `per_aisle` is
        given where there are no aisles.

    Examples
    --------
    >>> import qrobot
    >>> found = schedule(qrobot.solve("examples/paper-7-items.json"))
    >>> [(own.robot, len(own.trips)) for own in found.robots]
    [('R1', 1), ('R2', 1), ('R3', 1)]
    >>> found.ends == max(trip.ends for own in found.robots for trip in own.trips)
    True
    """
    return schedule_of(checked_scene(answer, instance), per_aisle)


def schedule_of(scene: Scene, per_aisle: int | None = None) -> Schedule:
    """Return when each robot of a plan is where, its trips in the sequence of the plan."""
    free = _scheduled(scene, None)
    if per_aisle is None:
        return Schedule(scene, free, None, max((own.ends for own in free), default=0.0))
    warehouse = scene.instance.warehouse
    if not isinstance(warehouse, AisleWarehouse):
        raise InputError(
            f"a {warehouse.kind} has no aisles to reserve",
            field="per_aisle",
            advice="leave it out (--per-aisle)",
        )
    if per_aisle < 1:
        raise InputError(f"{per_aisle} is below 1", field="per_aisle", advice="give 1 or more")
    robots = _scheduled(scene, Reservations(warehouse, per_aisle))
    return Schedule(scene, robots, per_aisle, max((own.ends for own in free), default=0.0))


def _scheduled(scene: Scene, reservations: Reservations | None) -> tuple[RobotSchedule, ...]:
    """Time all trips, always the one that may begin first."""
    times = scene.instance.times
    release = {order.id: order.release for order in scene.instance.orders}
    waiting: dict[str, list[Journey]] = {robot.id: [] for robot in scene.instance.robots}
    for journey in scene.journeys:
        waiting[journey.robot.id].append(journey)
    done: dict[str, list[TimedTrip]] = {name: [] for name in waiting}
    ready = [(_begins(own[0], 0.0, release), r, name) for r, (name, own) in
             enumerate(waiting.items()) if own]  # fmt: skip
    heapq.heapify(ready)
    while ready:
        begins, r, name = heapq.heappop(ready)
        own = done[name]
        journey = waiting[name][len(own)]
        leaves = begins + times.per_trip
        if reservations is None:
            own.append(TimedTrip(journey, begins, leaves, tuple(timeline(journey, times))))
        else:
            visits, inside, waits = reservations.take(journey, times, begins)
            own.append(
                TimedTrip(journey, begins, leaves, tuple(visits), tuple(waits), tuple(inside))
            )
        if len(own) < len(waiting[name]):
            following = waiting[name][len(own)]
            heapq.heappush(ready, (_begins(following, own[-1].ends, release), r, name))
    return tuple(RobotSchedule(name, tuple(own)) for name, own in done.items())


def _begins(journey: Journey, back: float, release: Mapping[str, float]) -> float:
    """Return when a trip may begin whose robot is back at a time."""
    released = max((release[order] for order in journey.trip.orders), default=0.0)
    return max(back, journey.robot.available, released)
