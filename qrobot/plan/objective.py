"""What a plan costs: the objective that `solve` makes small."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from typing import ClassVar

from qrobot._parameters import near
from qrobot.errors import InputError
from qrobot.problem.entities import Item, Robot
from qrobot.problem.instance import Instance

__all__ = ["DISTANCE", "OBJECTIVES", "TIME", "Objective", "objective_named"]


@dataclass(frozen=True, slots=True)
class Objective:
    """A sum over trips: what each metre costs its robot, and what each item costs anybody.

    Parameters
    ----------
    name
        What the value is called, such as ``time``.
    unit
        Its unit, such as ``s``; empty: that of the instance's distances.
    rate
        What a robot pays for a metre; above zero.
    handling
        What an item costs, whoever collects it; zero or more.

    Examples
    --------
    >>> from qrobot.problem import Robot
    >>> TIME.trip(30.0, Robot("R1", 10, speed=1.5), [])
    20.0
    """

    name: str
    unit: str
    rate: Callable[[Robot], float]
    handling: Callable[[Item], float] = lambda _: 0.0
    form: ClassVar[str] = "sum"

    def trip(self, length: float, robot: Robot, items: Iterable[Item]) -> float:
        """Return what a trip of a length costs when a robot collects the items."""
        return self.rate(robot) * length + math.fsum(map(self.handling, items))

    def optimised_by(self, objectives: Container[str]) -> bool:
        """Return whether a backend that declares these objectives can make this one small."""
        return self.name in objectives or self.form in objectives

    def fixed(self, instance: Instance) -> float:
        """Return what every plan of an instance costs beside its ways."""
        return math.fsum(map(self.handling, instance.items))

    def common_rate(self, instance: Instance) -> float | None:
        """Return what a metre costs when it costs all robots the same, else None.

        A shortest plan is a cheapest plan then, so any backend can optimise this objective.
        """
        rates = {self.rate(robot) for robot in instance.robots}
        return rates.pop() if len(rates) == 1 else None

    def bound(self, instance: Instance, distance: float) -> float:
        """Return a cost that no plan is below, when none is shorter than a distance."""
        return min(map(self.rate, instance.robots)) * distance + self.fixed(instance)


DISTANCE = Objective("distance", "", rate=lambda _: 1.0)
"""Total length of all trips."""

TIME = Objective(
    "time",
    "s",
    rate=lambda robot: 1.0 / robot.speed,
    handling=lambda item: item.pick_seconds,
)
"""Working time of all robots together: driving, and collecting every item."""

OBJECTIVES = {objective.name: objective for objective in (DISTANCE, TIME)}
"""By name; another one is one more entry."""


def objective_named(name: str, *, field: str = "objective") -> Objective:
    """Return an objective by name.

    Raises
    ------
    InputError
        When no objective has that name.
    """
    if name in OBJECTIVES:
        return OBJECTIVES[name]
    meant = near(str(name), OBJECTIVES)
    advice = f"{meant} use one of: {', '.join(OBJECTIVES)}".lstrip()
    raise InputError(f"{name!r} is not an objective", field=field, advice=advice)
