"""What a picture or a table shows: a plan looked up in its instance, without any drawing."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import dist
from typing import TYPE_CHECKING

from qrobot._files import StrPath
from qrobot._numbers import number
from qrobot._text import count, shown
from qrobot.errors import InputError
from qrobot.plan import Plan, Trip, as_picked, check, objective_named, plan_of
from qrobot.problem import AisleWarehouse, Instance, Item, Place, Robot, Slot, Warehouse
from qrobot.problem.formats import instance_of
from qrobot.report.lanes import XY
from qrobot.report.palette import Colour, colour_of
from qrobot.warehouse import POLICIES, route

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["Journey", "Scene", "checked_scene", "number", "scene_of"]


@dataclass(frozen=True, slots=True)
class Journey:
    """A trip with all that is drawn of it.

    Parameters
    ----------
    trip
        The trip.
    number
        Of the trip in the plan, from 1.
    name
        Of the robot, with the turn when it makes several trips.
    colour
        Of the robot where each makes one trip, otherwise of the trip: no two trips have the same.
    turn
        Which trip of its robot, from 0.
    robot
        Who makes it.
    items
        What is collected, in sequence.
    legs
        Corner points from the depot to the first stop, ..., from the last to the depot.
    lengths
        Of each leg, metres.
    """

    trip: Trip
    number: int
    name: str
    colour: Colour
    turn: int
    robot: Robot
    items: tuple[Item, ...]
    legs: tuple[tuple[XY, ...], ...]
    lengths: tuple[float, ...]

    @property
    def capacity(self) -> Fraction:
        """Of the robot."""
        return self.robot.capacity

    @property
    def tag(self) -> str:
        """The number of the trip as it stands on a picture."""
        return f"#{self.number}"


@dataclass(frozen=True, slots=True)
class Scene:
    """A plan in its warehouse.

    Parameters
    ----------
    instance
        The question.
    journeys
        The trips.
    title, subtitle
        What stands above the picture.
    unit
        Of distances, with a space before it, or nothing where it is unknown.
    """

    instance: Instance
    journeys: tuple[Journey, ...]
    title: str
    subtitle: str
    unit: str

    def length(self, value: float) -> str:
        """Return a distance with its unit."""
        return f"{number(value)}{self.unit}"

    def texts(self) -> list[str]:
        """Return all texts of the picture that are not ours."""
        return [
            self.title,
            *(j.name for j in self.journeys),
            *(shown(item.label or item.id) for item in self.instance.items),
        ]


def scene_of(answer: Result | Plan | StrPath, instance: Instance | StrPath | None = None) -> Scene:
    """Look a plan up in its instance.

    Raises
    ------
    InputError
        When the plan is not one of this instance, or no instance was given.
    """
    plan, quality = plan_of(answer), ""
    if not isinstance(answer, Plan | str | os.PathLike):
        quality = _quality(answer)
        instance = answer.instance if instance is None else instance
    if instance is None:
        raise InputError("a plan alone has no warehouse", advice="give its instance too")
    instance = as_picked(instance_of(instance), plan.picks)
    items = {item.id: item for item in instance.items}
    fleet = {robot.id: i for i, robot in enumerate(instance.robots)}
    several = {robot for robot, n in Counter(t.robot for t in plan.trips).items() if n > 1}
    turns: dict[str, int] = {}
    journeys = []
    for n, trip in enumerate(plan.trips, 1):
        if trip.robot not in fleet:
            raise InputError(f"robot {trip.robot!r} is not in the instance", advice=_ADVICE)
        for stop in trip.stops:
            if stop not in items:
                raise InputError(f"item {stop!r} is not in the instance", advice=_ADVICE)
        turn = turns[trip.robot] = turns.get(trip.robot, -1) + 1
        picked = tuple(items[stop] for stop in trip.stops)
        legs, lengths = _legs(instance, [item.place for item in picked], plan.routing)
        journeys.append(
            Journey(
                trip=trip,
                number=n,
                name=shown(trip.robot, 20)
                + (f", trip {turn + 1}" if trip.robot in several else ""),
                colour=colour_of(n - 1 if several else fleet[trip.robot]),
                turn=turn,
                robot=instance.robots[fleet[trip.robot]],
                items=picked,
                legs=legs,
                lengths=lengths,
            )
        )
    unit = _unit(instance)
    return Scene(
        instance=instance,
        journeys=tuple(journeys),
        title=f"{shown(instance.name, 60)}: {_cost(plan, unit)}{quality}",
        subtitle=_subtitle(plan, instance),
        unit=unit,
    )


def _legs(
    instance: Instance, places: Sequence[Place], routing: str
) -> tuple[tuple[tuple[XY, ...], ...], tuple[float, ...]]:
    """Return the legs from stop to stop and their lengths: of shortest ways, or of a policy's."""
    house = instance.warehouse
    slots = [place for place in places if isinstance(place, Slot)]
    if routing in POLICIES and isinstance(house, AisleWarehouse) and slots:
        way = route(house, slots, routing)
        if way.sequence == tuple(range(len(slots))):
            # A policy goes along the axes only.
            return way.legs, tuple(sum(map(dist, leg, leg[1:])) for leg in way.legs)
    rows = [0, *(instance.row_of_place[place] for place in places), 0]
    lengths = tuple(float(instance.place_distances[a, b]) for a, b in pairwise(rows))
    return tuple(_leg(house, a, b) for a, b in pairwise([None, *places, None])), lengths


def _leg(house: Warehouse, start: Place | None, end: Place | None) -> tuple[XY, ...]:
    """Return the corner points of a leg as it is drawn.

    The depot's ways to other aisles have a length and no shape; they are drawn along the front of
    the depot and then straight on.
    """
    points = house.way(start, end)
    if isinstance(house, AisleWarehouse) and len(points) > 1:
        x, y = house.depot
        if start is None and points[1][0] != x:
            points.insert(1, (points[1][0], y))
        if end is None and points[-2][0] != x:
            points.insert(-1, (points[-2][0], y))
    return tuple(a for a, b in pairwise([*points, None]) if a is not None and a != b)


def checked_scene(
    answer: Result | Plan | StrPath, instance: Instance | StrPath | None = None
) -> Scene:
    """Look a plan up in its instance, and refuse a wrong one.

    Raises
    ------
    InputError
        When the plan is not right for the instance, as `qrobot.check` says.
    """
    scene = scene_of(answer, instance)
    report = check(plan_of(answer), scene.instance)
    if not report.ok:
        raise InputError(
            f"the plan is not right for this instance: {report.problems[0]}",
            advice="`qrobot check` lists all that is wrong",
        )
    return scene


_ADVICE = "give the instance that the plan was made for"


def _quality(result: Result) -> str:
    if result.is_optimal:
        return ", proven optimal"
    gap = result.gap
    return f", at most {gap:.1%} above the optimum" if gap < 10 else ""


def _cost(plan: Plan, unit: str) -> str:
    """Return the distance, or what the plan costs by another objective, with its unit."""
    if plan.objective == "distance":
        return f"{number(plan.distance)}{unit}"
    return f"{plan.objective} {number(plan.cost)} {objective_named(plan.objective).unit}".rstrip()


def _unit(instance: Instance) -> str:
    unit = instance.warehouse.unit
    return f" {unit}" if unit else ""


def _subtitle(plan: Plan, instance: Instance) -> str:
    orders = f" in {count(len(instance.orders), 'order')}" if instance.whole_orders else ""
    robots = f"{plan.robots_used} of {count(len(instance.robots), 'robot')} used"
    trips = f", {len(plan.trips)} trips" if len(plan.trips) > plan.robots_used else ""
    return f"{count(instance.size, 'item')}{orders}, {robots}{trips}"
