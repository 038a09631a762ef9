"""Proven schedules of a few orders: labels over sets of orders, for every objective.

For each robot and each set of orders, the labels say what its trips past them may cost and when
it is back; a label that is dearer and later than another one leads nowhere, since every objective
only grows with both (Held and Karp's recursion over sets, with Pareto labels). The sets of all
robots are then joined in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from qrobot.backends.base import Routes
from qrobot.backends.classical.exact.columns import Columns
from qrobot.plan.dealing import Seats, price_of_end
from qrobot.plan.objective import Objective
from qrobot.plan.timing import TimedRoute, seconds_of, timed
from qrobot.problem import Instance
from qrobot.problem.entities import Robot

__all__ = ["MOST_STEPS", "Schedule", "best_schedule", "steps_of"]

MOST_STEPS = 300_000
"""Pairs of a set and a part of it that are looked at, over all robots: some seconds."""

TIE = 1e-9
"""Of plans of one cost the shorter is wanted: a share of the cost that all metres make."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """Trips in sequence.

    Parameters
    ----------
    routes
        Nodes of each trip.
    seats
        For each its robot and which of its trips it is.
    """

    routes: Routes
    seats: Seats


@dataclass(frozen=True, slots=True)
class _Label:
    """What the trips of a robot, or of the robots so far, may come to.

    Parameters
    ----------
    cost
        Without the makespan.
    ends
        When the (last) robot is back.
    trips
        How many the robot has made; 0 where that is not limited.
    row
        Of the columns, of the trip that was added last.
    robot
        Who was added last, with the label of its own trips.
    before
        The label without them.
    """

    cost: float
    ends: float
    trips: int
    row: int = -1
    robot: tuple[int, _Label] | None = None
    before: _Label | None = None


def steps_of(instance: Instance) -> int:
    """Return how many pairs of a set and a part of it `best_schedule` looks at."""
    kinds = len({(r.capacity, r.speed, r.trips, r.available) for r in instance.robots})
    return int(3 ** min(len(instance.orders), 40)) * (kinds + len(instance.robots))


def best_schedule(
    instance: Instance, columns: Columns, objective: Objective, stop: Callable[[], bool]
) -> tuple[Schedule | None, bool]:
    """Return a schedule of least cost, and whether it (or that there is none) is proven.

    Parameters
    ----------
    instance
        The question.
    columns
        All sets of orders that some robot can carry.
    objective
        What is made small.
    stop
        Asked now and then.
    """
    for row in range(len(columns.masks)):
        while not columns.known[row]:
            if stop() or not columns.improve(row, stop):
                return None, False
    trips = {
        int(mask): (row, timed(instance, columns.route(row), float(columns.lengths[row])))
        for row, mask in enumerate(columns.masks.tolist())
        if math.isfinite(columns.lengths[row])
    }
    search = _Search(instance, objective, trips)
    known: dict[tuple[object, ...], list[list[_Label]]] = {}
    joined = [[_Label(0.0, 0.0, 0)], *([] for _ in range(search.all))]
    for r, robot in enumerate(instance.robots):
        kind = (robot.capacity, robot.speed, robot.trips, robot.available)
        if kind not in known:
            own = search.of_robot(r, stop)
            if own is None:
                return None, False
            known[kind] = own
        last = r + 1 == len(instance.robots)
        found = search.join(joined, known[kind], r, last, stop)
        if found is None:
            return None, False
        joined = found
    ends = joined[search.all]
    if not ends:
        return None, True
    best = min(ends, key=lambda label: label.cost + objective.makespan * label.ends)
    return _schedule(columns, best), True


class _Search:
    """The labels of one instance and objective."""

    def __init__(
        self, instance: Instance, objective: Objective, trips: dict[int, tuple[int, TimedRoute]]
    ) -> None:
        self.instance, self.objective, self.trips = instance, objective, trips
        self.all = (1 << len(instance.orders)) - 1
        self.timely = bool(objective.lateness) or instance.has_deadlines
        self.clocked = self.timely or objective.makespan > 0
        # Where all begin when they may, the sequence of a robot's trips changes nothing.
        released = any(order.release > 0 for order in instance.orders)
        self.in_sequence = self.timely or (released and objective.makespan > 0)
        longest = math.fsum(trip.length for _, trip in trips.values()) or 1.0
        usual = max(
            (objective.trip(t.length, instance.robots[0], [], instance.times)
             + objective.makespan * t.standing for _, t in trips.values()),
            default=1.0,
        )  # fmt: skip
        self.tie = TIE * max(usual, 1e-3) / longest

    def of_robot(self, r: int, stop: Callable[[], bool]) -> list[list[_Label]] | None:
        """Return for each set of orders the labels of a robot that collects just them."""
        robot, room = self.instance.robots[r], int(self.instance.capacities[r])
        limited = robot.trips < len(self.instance.orders)
        able = {mask: (row, trip) for mask, (row, trip) in self.trips.items() if trip.load <= room}
        begins = robot.available if self.clocked else 0.0
        found = [[_Label(self.objective.per_robot, begins, 0)], *([] for _ in range(self.all))]
        for whole in range(1, self.all + 1):
            if not whole & 255 and stop():
                return None
            labels = []
            for part in _parts(whole, fixed=not self.in_sequence):
                if part not in able:
                    continue
                row, trip = able[part]
                seconds = seconds_of(trip, robot.speed)
                price = self._price(trip, robot)
                for before in found[whole ^ part]:
                    if limited and before.trips == robot.trips:
                        continue
                    ends = max(before.ends, trip.release) + seconds
                    cost = before.cost + price
                    if self.timely:
                        cost += price_of_end(self.instance, self.objective, trip, ends, math.inf)
                    if math.isinf(cost):
                        continue
                    clock = ends if self.clocked else 0.0
                    labels.append(_Label(cost, clock, before.trips + limited, row, before=before))
            found[whole] = _best(labels)
        found[0] = [_Label(0.0, 0.0, 0)]  # a robot that stays home costs nothing
        return found

    def _price(self, trip: TimedRoute, robot: Robot) -> float:
        objective = self.objective
        return (
            (objective.rate(robot) + self.tie) * trip.length
            + objective.per_trip(self.instance.times)
        )  # fmt: skip

    def join(
        self,
        joined: Sequence[list[_Label]],
        own: Sequence[list[_Label]],
        r: int,
        last: bool,
        stop: Callable[[], bool],
    ) -> list[list[_Label]] | None:
        """Return the labels of the robots so far and one more."""
        found: list[list[_Label]] = [[] for _ in range(self.all + 1)]
        for whole in [self.all] if last else range(self.all + 1):
            if not whole & 255 and stop():
                return None
            labels = []
            for part in (*_parts(whole, fixed=False), 0):
                for mine in own[part]:
                    for others in joined[whole ^ part]:
                        cost, ends = others.cost + mine.cost, max(others.ends, mine.ends)
                        labels.append(_Label(cost, ends, 0, robot=(r, mine), before=others))
            found[whole] = _best(labels)
        return found


def _parts(whole: int, *, fixed: bool) -> Iterable[int]:
    """Yield the parts of a set that are not empty; `fixed`: only those with its last element."""
    keep = whole & -whole if fixed else 0
    rest = whole ^ keep
    part = rest
    while True:
        if part | keep:
            yield part | keep
        if not part:
            return
        part = (part - 1) & rest


def _best(labels: list[_Label]) -> list[_Label]:
    """Return the labels that no other one is at least as good as."""
    labels.sort(key=lambda one: (one.cost, one.ends, one.trips))
    kept: list[_Label] = []
    for one in labels:
        if not any(other.ends <= one.ends and other.trips <= one.trips for other in kept):
            kept.append(one)
    return kept


def _schedule(columns: Columns, label: _Label | None) -> Schedule:
    """Return the trips that lead to a label of all robots."""
    routes: Routes = []
    seats: Seats = []
    while label is not None and label.robot is not None:
        r, own = label.robot
        rows = []
        while own.before is not None:
            rows.append(own.row)
            own = own.before
        for turn, row in enumerate(reversed(rows)):
            routes.append(columns.route(row))
            seats.append((r, turn))
        label = label.before
    return Schedule(routes, seats)
