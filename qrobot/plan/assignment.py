"""Which robot makes which trip, where an objective charges robots differently."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from qrobot._arrays import Floats
from qrobot.plan.objective import Objective
from qrobot.problem.instance import Instance

__all__ = ["assign", "cost"]


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
