"""Which robot makes which trip and when, and what that costs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.plan.objective import DISTANCE, Objective
from qrobot.plan.timing import TimedRoute, lateness, overdue, spans, timed
from qrobot.problem import Instance

__all__ = ["Seats", "assign", "cost", "cost_of_robot", "deal", "price_of_end"]

Seats = list[tuple[int, int]]
"""For each route the robot (its index) and which of its trips it is, from 0."""

MISSED = 1e9
"""What a second after a deadline counts where a robot must be chosen."""


def cost(
    instance: Instance,
    routes: Sequence[Sequence[int]],
    objective: Objective,
    seats: Seats | None = None,
) -> float:
    """Return what routes cost, ``inf`` when one is back after a deadline.

    Parameters
    ----------
    instance
        The question.
    routes
        Nodes of each trip.
    objective
        What is counted.
    seats
        Who makes them; by default as `assign` says.
    """
    if (rate := objective.common_rate(instance)) is not None:
        return rate * instance.length(routes) + objective.fixed(instance)
    if seats is None:
        seats = assign(instance, routes, objective)
    if objective.form(instance) == "sum":
        ways = math.fsum(
            objective.rate(instance.robots[r]) * instance.route_length(route)
            for (r, _), route in zip(seats, routes, strict=True)
        )
        return ways + objective.fixed(instance)
    own: dict[int, list[tuple[int, TimedRoute]]] = {}
    for (r, turn), route in zip(seats, routes, strict=True):
        own.setdefault(r, []).append((turn, timed(instance, route)))
    parts = [
        cost_of_robot(instance, objective, r, [trip for _, trip in sorted(trips)])
        for r, trips in own.items()
    ]
    last = objective.makespan * max((ends for _, ends in parts), default=0.0)
    return math.fsum(value for value, _ in parts) + last + objective.fixed(instance)


def cost_of_robot(
    instance: Instance,
    objective: Objective,
    r: int,
    trips: Sequence[TimedRoute],
    missed: float = math.inf,
) -> tuple[float, float]:
    """Return what the trips of a robot cost one after the other, and when it is back from the last.

    Without the cost of its items and of the makespan. `missed` is what a second after a deadline
    costs.
    """
    if not trips:
        return 0.0, 0.0
    robot = instance.robots[r]
    spent = spans(trips, robot)
    value = objective.per_robot + len(trips) * objective.per_trip(instance.times)
    value += objective.rate(robot) * sum(trip.length for trip in trips)
    for trip, (_, ends) in zip(trips, spent, strict=True):
        value += price_of_end(instance, objective, trip, ends, missed)
    return value, spent[-1][1]


def price_of_end(
    instance: Instance, objective: Objective, trip: TimedRoute, ends: float, missed: float
) -> float:
    """Return what it costs that a trip ends at a time: its lateness, and missed deadlines."""
    price = objective.lateness * lateness(instance, trip, ends) if objective.lateness else 0.0
    if instance.has_deadlines and (late := overdue(instance, trip, ends)):
        price += missed * late
    return price


def assign(instance: Instance, routes: Sequence[Sequence[int]], objective: Objective) -> Seats:
    """Return for each route the robot and turn, at a cost as small as is known.

    Where each trip costs what its robot pays for it, the least of all (an assignment); otherwise
    as `deal` deals them.

    Raises
    ------
    ValueError
        When the robots cannot carry the routes.
    """
    if objective.form(instance) != "sum":
        return deal(instance, routes, objective)
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


def deal(
    instance: Instance, routes: Sequence[Sequence[int]], objective: Objective = DISTANCE
) -> Seats:
    """Return for each route the robot and turn, one trip after the other.

    Trips of urgent orders are dealt first, otherwise those that take longest, each to the robot to
    which it adds the least cost, and among those to the one that is back from it first (Graham
    1969, longest processing time), as long as the heavier ones that are left find room. Where the
    robots cannot carry the trips, loads are not looked at.

    Parameters
    ----------
    instance
        The question; times are those of its robots' speeds, of set-ups and of each pick.
    routes
        Nodes of each trip.
    objective
        What is counted.

    Raises
    ------
    ValueError
        When there are more routes than turns of robots.
    """
    if not routes:
        return []
    trips = [timed(instance, route) for route in routes]
    loads = np.array([trip.load for trip in trips])
    speeds = np.array([robot.speed for robot in instance.robots])
    seconds = np.array([trip.standing + trip.length / speeds for trip in trips])
    left = _Left(instance, loads)
    if not left.fits:  # a wrong plan, which the checker refuses: any robot takes any trip
        loads = np.zeros_like(loads)
        left = _Left(instance, loads)
    if not left.fits:
        raise ValueError(f"{len(routes)} trips for {left.turns.sum()} turns of the robots")
    rates = np.array([objective.rate(robot) for robot in instance.robots])
    back = np.array([robot.available for robot in instance.robots])
    last = 0.0
    turns = [0] * len(instance.robots)
    chosen = [(0, 0)] * len(routes)

    def urgency(i: int) -> tuple[float, float, float, list[int]]:
        orders = [instance.orders[o] for o in trips[i].orders]
        deadline = min(order.deadline for order in orders)
        # Equal times are told apart by the stops: the sequence of the routes does not matter.
        return deadline, min(o.due for o in orders), -float(seconds[i].max()), list(routes[i])

    for i in sorted(range(len(routes)), key=urgency):
        able = left.robots_for(int(loads[i]))
        ends = np.maximum(back[able], trips[i].release) + seconds[i, able]
        # Along a forbidden way, which the checker refuses, every robot is as good.
        added = rates[able] * (trips[i].length if math.isfinite(trips[i].length) else 0.0)
        added += objective.per_robot * np.array([turns[r] == 0 for r in able])
        if objective.makespan:
            added += objective.makespan * np.maximum(ends - last, 0.0)
        if objective.lateness or instance.has_deadlines:
            added += [
                price_of_end(instance, objective, trips[i], float(end), MISSED) for end in ends
            ]
        # Sums that differ by rounding are equal, and the first of the robots takes the trip.
        best = np.lexsort((np.round(ends, 9), np.round(added, 9)))[0]
        robot = int(able[best])
        left.take(int(loads[i]), robot)
        chosen[i] = robot, turns[robot]
        turns[robot] += 1
        back[robot] = ends[best]
        last = max(last, float(ends[best]))
    return chosen


class _Left:
    """The trips that are not dealt yet, and the turns that robots have left.

    The trips fit when, for every capacity, no more of them are heavier than all smaller robots
    can carry than larger robots have turns.
    """

    def __init__(self, instance: Instance, loads: npt.NDArray[np.int64]) -> None:
        self.turns = np.array([min(robot.trips, len(loads)) for robot in instance.robots])
        self.levels, self.level = np.unique(instance.capacities, return_inverse=True)
        # Of each level the trips that want at least that much room, and the turns that give it.
        wanted = np.searchsorted(self.levels, loads)
        self.trips = np.array([(wanted >= k).sum() for k in range(len(self.levels))])
        self.seats = np.array([self.turns[self.level >= k].sum() for k in range(len(self.levels))])
        self.fits = bool((wanted < len(self.levels)).all() and (self.trips <= self.seats).all())

    def robots_for(self, load: int) -> npt.NDArray[np.intp]:
        """Return the robots that may take a trip of a load without leaving a heavier one behind.

        Of the levels above the trip's own that such a robot serves, each has a turn to spare.
        """
        wanted = int(np.searchsorted(self.levels, load))
        scarce = np.flatnonzero(self.seats[wanted + 1 :] <= self.trips[wanted + 1 :])
        end = wanted + 1 + int(scarce[0]) if len(scarce) else len(self.levels)
        return np.flatnonzero((self.turns > 0) & (wanted <= self.level) & (self.level < end))

    def take(self, load: int, robot: int) -> None:
        """Deal a trip of a load to a robot."""
        self.turns[robot] -= 1
        self.trips[: int(np.searchsorted(self.levels, load)) + 1] -= 1
        self.seats[: self.level[robot] + 1] -= 1


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
