"""What a plan costs: the objective that `solve` makes small."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from qrobot._parameters import near
from qrobot.errors import InputError
from qrobot.problem.entities import Item, Robot
from qrobot.problem.instance import Instance
from qrobot.problem.times import Times

__all__ = [
    "DISTANCE",
    "MEASURES",
    "OBJECTIVES",
    "TIME",
    "Objective",
    "objective_named",
]

Form = Literal["distance", "sum", "schedule"]


@dataclass(frozen=True, slots=True)
class Objective:
    """What trips, robots and time cost.

    Parameters
    ----------
    name
        What the value is called, such as ``time``.
    unit
        Its unit, such as ``s``; empty: that of the instance's distances.
    rate
        What a robot pays for a metre; zero or more.
    handling
        What an item costs, whoever collects it; zero or more.
    per_trip
        What a trip costs beside its way and its items, by the instance's times.
    per_robot
        What a robot costs that leaves the depot at all.
    makespan
        What a second costs until the last robot is back.
    lateness
        What a second of an order after its due time costs, times its priority.

    Examples
    --------
    >>> from qrobot.problem import Robot, Times
    >>> TIME.trip(30.0, Robot("R1", 10, speed=1.5), [], Times(per_trip=5))
    25.0
    """

    name: str
    unit: str
    rate: Callable[[Robot], float]
    handling: Callable[[Times, Item], float] = lambda _times, _item: 0.0
    per_trip: Callable[[Times], float] = lambda _: 0.0
    per_robot: float = 0.0
    makespan: float = 0.0
    lateness: float = 0.0

    def __reduce__(self) -> tuple[Any, ...]:
        # Functions cannot be pickled: another process finds the objective by its name.
        return objective_named, (self.name,)

    def trip(
        self, length: float, robot: Robot, items: Iterable[Item], times: Times | None = None
    ) -> float:
        """Return what a trip of a length costs, whenever a robot makes it."""
        times = times or Times()
        handled = math.fsum(self.handling(times, item) for item in items)
        return self.rate(robot) * length + handled + self.per_trip(times)

    def form(self, instance: Instance) -> Form:
        """Return what a plan of least cost is among all plans of an instance.

        ``distance``: a shortest one. ``sum``: one of the least sum over trips, each at the rate of
        its robot. ``schedule``: anything else, since it counts how many trips there are, who
        makes them, or when.
        """
        timely = self.makespan or self.lateness or instance.has_deadlines
        rates = {self.rate(robot) for robot in instance.robots}
        if timely or self.per_robot or self.per_trip(instance.times) or min(rates) <= 0:
            return "schedule"
        return "distance" if len(rates) == 1 else "sum"

    def optimised_by(self, objectives: Container[str], instance: Instance) -> bool:
        """Return whether a backend that declares these objectives can make this one small."""
        form = self.form(instance)
        # Every backend makes distances small: that says nothing of those that deadlines bind.
        named = self.name != "distance" and self.name in objectives
        return form == "distance" or named or form in objectives

    def fixed(self, instance: Instance) -> float:
        """Return what every plan of an instance costs beside its trips."""
        return math.fsum(self.handling(instance.times, item) for item in instance.items)

    def common_rate(self, instance: Instance) -> float | None:
        """Return what a metre costs where a shortest plan is a cheapest one, else None.

        Any backend can optimise this objective then.
        """
        return self.rate(instance.robots[0]) if self.form(instance) == "distance" else None

    def bound(self, instance: Instance, distance: float) -> float:
        """Return a cost that no plan is below, when none is shorter than a distance."""
        return min(map(self.rate, instance.robots)) * distance + self.fixed(instance)


DISTANCE = Objective("distance", "", rate=lambda _: 1.0)
"""Total length of all trips."""

TIME = Objective(
    "time",
    "s",
    rate=lambda robot: 1.0 / robot.speed,
    handling=Times.of,
    per_trip=lambda times: times.per_trip,
)
"""Working time of all robots together: driving, collecting every item, set-up of every trip."""

NOTHING = Objective("nothing", "", rate=lambda _: 0.0)
MAKESPAN = replace(NOTHING, name="makespan", unit="s", makespan=1.0)
"""Until the last robot is back."""

LATENESS = replace(NOTHING, name="lateness", unit="s", lateness=1.0)
"""Of all orders after their due times, each times its priority."""

TRIPS = replace(NOTHING, name="trips", unit="", per_trip=lambda _: 1.0)
"""How many trips are made."""

ROBOTS = replace(NOTHING, name="robots", unit="", per_robot=1.0)
"""How many robots leave the depot."""

OBJECTIVES = {
    objective.name: objective for objective in (DISTANCE, TIME, MAKESPAN, LATENESS, TRIPS, ROBOTS)
}
"""By name; another one is one more entry."""

MEASURES = tuple(OBJECTIVES)
"""What weighted sums are made of, beside entries of others."""

MAX_WEIGHT = 1e9
WEIGHT = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def objective_named(name: str, *, field: str = "objective") -> Objective:
    """Return an objective by name, or a weighted sum of several.

    Parameters
    ----------
    name
        A key of `OBJECTIVES`, or such as ``distance=1,makespan=2.5``: metres and seconds are added
        as they are, so a weight says what one of them is worth.
    field
        What errors call it.

    Raises
    ------
    InputError
        When no objective has that name, or a weight is not a number above zero.
    """
    if "=" not in name:
        return _one(name, field)
    parts: dict[str, float] = {}
    for part in name.split(","):
        known, _, text = (word.strip() for word in part.partition("="))
        weight = float(text) if WEIGHT.fullmatch(text) else math.nan
        if not 0 < weight <= MAX_WEIGHT or known in parts:
            twice = known in parts
            raise InputError(
                f"{known!r} stands twice" if twice else f"{text!r} is not a weight above 0",
                field=field,
                advice="give each once, such as distance=1,makespan=2",
            )
        parts[_one(known, field).name] = weight
    return _sum(parts)


def _one(name: str, field: str) -> Objective:
    if name in OBJECTIVES:
        return OBJECTIVES[name]
    meant = near(str(name), OBJECTIVES)
    advice = (
        f"{meant} use one of: {', '.join(OBJECTIVES)}; or a sum such as distance=1,makespan=2"
    ).lstrip()
    raise InputError(f"{name!r} is not an objective", field=field, advice=advice)


def _sum(parts: Mapping[str, float]) -> Objective:
    """Return the sum of objectives, each times its weight."""
    terms = [(OBJECTIVES[name], weight) for name, weight in parts.items()]
    return Objective(
        ",".join(f"{name}={weight:.12g}" for name, weight in parts.items()),
        "",
        rate=lambda robot: math.fsum(w * one.rate(robot) for one, w in terms),
        handling=lambda times, item: math.fsum(w * one.handling(times, item) for one, w in terms),
        per_trip=lambda times: math.fsum(w * one.per_trip(times) for one, w in terms),
        per_robot=math.fsum(w * one.per_robot for one, w in terms),
        makespan=math.fsum(w * one.makespan for one, w in terms),
        lateness=math.fsum(w * one.lateness for one, w in terms),
    )
