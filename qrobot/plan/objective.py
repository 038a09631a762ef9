"""What a plan costs: the objective that `solve` makes small, and which robot makes which trip."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from qrobot._arrays import Floats
from qrobot._parameters import near
from qrobot.errors import InputError
from qrobot.problem.entities import Item, Robot
from qrobot.problem.instance import Instance

__all__ = ["DISTANCE", "OBJECTIVES", "TIME", "Objective", "assign", "cost", "objective_named"]


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

    def __reduce__(self) -> tuple[Any, ...]:
        # Functions cannot be pickled: another process finds the objective by its name.
        return objective_named, (self.name,)

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


def cost(instance: Instance, routes: Sequence[Sequence[int]], objective: Objective) -> float:
    """Return what routes cost when each is made by the robot that `assign` gives it."""
    if (rate := objective.common_rate(instance)) is not None:
        return rate * instance.length(routes) + objective.fixed(instance)
    ways = math.fsum(
        objective.rate(instance.robots[r]) * instance.route_length(route)
        for (r, _), route in zip(assign(instance, routes, objective), routes, strict=True)
    )
    return ways + objective.fixed(instance)


def assign(
    instance: Instance, routes: Sequence[Sequence[int]], objective: Objective
) -> list[tuple[int, int]]:
    """Return for each route the robot (its index) and turn at which all together cost least.

    Raises
    ------
    ValueError
        When the robots cannot carry the routes.
    """
    loads = [sum(int(instance.weights[v - 1]) for v in route) for route in routes]
    seats = [
        (r, turn)
        for r, robot in enumerate(instance.robots)
        for turn in range(min(robot.trips, len(routes)))
    ]
    robots = [r for r, _ in seats]
    rates = np.array([objective.rate(instance.robots[r]) for r in robots])
    rooms = instance.capacities[robots]
    costs = np.array(
        [
            np.where(rooms >= load, rates * instance.route_length(route), np.inf)
            for load, route in zip(loads, routes, strict=True)
        ]
    ).reshape(len(routes), len(seats))
    return [seats[column] for column in _cheapest(costs)]


def _cheapest(costs: Floats) -> list[int]:
    """Return a column for each row, all different, of the least sum (Kuhn 1955).

    Rows are added one at a time, each along a shortest path of changes under prices of rows
    and columns, which keep all reduced costs at zero or above.
    """
    rows, columns = costs.shape
    row_of = np.full(columns, -1)
    row_price, column_price = np.zeros(rows), np.zeros(columns)
    for row in range(rows):
        length = np.full(columns, np.inf)
        before = np.full(columns, -1)
        done = np.zeros(columns, dtype=bool)
        at, last, so_far = row, -1, 0.0
        while True:
            step = so_far + costs[at] - row_price[at] - column_price
            better = ~done & (step < length)
            length[better], before[better] = step[better], last
            open_ = np.where(done, np.inf, length)
            if not columns or not np.isfinite(open_).any():
                raise ValueError(f"{rows} trips do not fit the robots")
            last = int(open_.argmin())
            so_far = float(open_[last])
            done[last] = True
            if row_of[last] < 0:
                break
            at = int(row_of[last])
        row_price[row] += so_far
        for column in np.flatnonzero(done):
            change = so_far - length[column]
            column_price[column] -= change
            if row_of[column] >= 0:
                row_price[row_of[column]] += change
        while last >= 0:  # change the path's columns, from its end
            earlier = int(before[last])
            row_of[last] = row_of[earlier] if earlier >= 0 else row
            last = earlier
    column_of = {int(r): column for column, r in enumerate(row_of) if r >= 0}
    return [column_of[row] for row in range(rows)]
