"""Plans where it counts how many trips there are, who makes them, and when.

A few orders are proven by `exact`. Otherwise a plan of short trips comes first, by the usual
search; then orders and whole trips are moved between trips, robots and turns (simulated
annealing, Kirkpatrick et al. 1983), with the tour of each new trip looked up or found once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from qrobot._arrays import Ints
from qrobot.backends import Routes, Stop
from qrobot.backends.classical.batching.batch_tours import Batch, BatchTours
from qrobot.backends.classical.exact import ExactPlanner
from qrobot.plan.dealing import Seats, assign, cost_of_robot
from qrobot.plan.objective import DISTANCE
from qrobot.planning.bounding import share_of
from qrobot.planning.bounds import schedule_bound
from qrobot.planning.run import Run
from qrobot.planning.strategy import Strategy
from qrobot.problem import Instance

__all__ = ["dispatch", "improve"]

SHORT_SHARE = 0.4
"""Of the time, for a plan of short trips."""

KEPT_SECONDS, KEPT_SHARE = 0.3, 0.05
"""Time kept back for the routes and the check of the plan, at most."""

WARM, COLD = 0.3, 1e-4
"""Share of a trip's usual cost that a move may lose, at first and at last."""

MOVES = 200
"""Moves between two looks at the clock, and to a unit of work."""

SPREAD = 0.2
"""Of the makespan's weight, for the mean of all robots: moves that free another robot's time are
of use too, though the last one is not back sooner."""

METRE = 0.01
"""Of a plan's cost, for all its metres: of moves that cost the same, those count that shorten."""

ROUNDING = 1e-9
"""Share of a trip's usual cost below which a gain is rounding."""

NEIGHBOURS = 12
"""Orders that lie nearest, beside which an order is tried."""

Rounds = list[list[Batch]]
"""For each robot its trips in sequence, as orders."""


def dispatch(run: Run, short: Strategy) -> None:
    """Find a plan, proven where there are few orders.

    Parameters
    ----------
    run
        Its objective is of the form ``schedule``.
    short
        What finds a plan of short trips.
    """
    exact = ExactPlanner()
    if exact.schedules(run.instance):
        run.plan(exact, run.stop)
        if run.finished:
            return
    # Without deadlines a plan of the least distance is looked for; whether it keeps them, and who
    # makes its trips, comes after.
    orders = tuple(replace(order, deadline=math.inf) for order in run.instance.orders)
    relaxed = replace(run.instance, orders=orders)
    stop = share_of(run.stop, SHORT_SHARE, math.inf)
    inner = Run(
        relaxed, stop, run.seed, objective=DISTANCE, on_best=lambda found, _: run.best.offer(found)
    )
    inner.record = run.record  # its steps, notes and times are those of this run
    short.plan(inner)
    if inner.infeasible is not None:
        run.infeasible = inner.infeasible
        return
    if inner.best.routes is None:
        return
    least = inner.best.length if inner.finished else inner.best.bound
    run.best.bound = max(run.best.bound, schedule_bound(run.instance, run.best.objective, least))
    run.tell()
    if run.finished:
        return
    improve(run, inner.best.routes)
    if run.best.routes is None:
        run.record.notes.append("no plan was found that keeps all deadlines")


def improve(
    run: Run,
    routes: Routes,
    seats: Seats | None = None,
    *,
    keep: Mapping[Batch, int] | None = None,
    stability: float = 0.0,
) -> None:
    """Move orders and trips about until time is up, from the best plan of a run or from routes.

    Parameters
    ----------
    run
        It keeps what is better.
    routes, seats
        Where to begin when the run has no plan that keeps all deadlines, and who makes them: by
        default as `dealing.assign` says.
    keep
        Trips that should stay with their robots.
    stability
        What it costs to change one of them, in usual costs of a trip.
    """
    run.begin("dispatching")
    left = run.stop.remaining
    kept = min(KEPT_SHARE * left, KEPT_SECONDS) if math.isfinite(left) else 0.0
    stop = run.stop.within(max(left - kept, 0.0)) if kept else run.stop
    with run.timed("run"):
        search = _Search(run, routes, seats, keep or {}, stability)
        search.anneal(stop)
    run.out_of_time = stop.remaining <= 0
    work = run.record.work
    work["dispatching"] = work.get("dispatching", 0) + search.moves // MOVES


class _Part(NamedTuple):
    """What the trips of one robot come to: their cost, when it is back, and their metres."""

    cost: float
    ends: float
    length: float


class _Search:
    """Simulated annealing over who collects which orders, on which of its trips."""

    def __init__(
        self,
        run: Run,
        routes: Routes,
        seats: Seats | None,
        keep: Mapping[Batch, int],
        stability: float,
    ) -> None:
        self.run, self.instance, self.objective = run, run.instance, run.best.objective
        instance, best = self.instance, run.best
        self.draw = np.random.default_rng(run.seed).random
        self.tours = BatchTours(instance, run.stop)
        self.weights = [int(w) for w in instance.order_weights]
        self.rooms = [int(c) for c in instance.capacities]
        self.near = _nearest(instance)
        self.rounds: Rounds = [[] for _ in instance.robots]
        self.robot_of = [0] * len(instance.orders)
        owner = instance.order_of_node
        start = routes if best.routes is None else best.routes
        if best.routes is not None:
            seats = best.seats
        if seats is None:
            seats = assign(instance, start, self.objective)
        for (r, _), route in sorted(zip(seats, start, strict=True)):
            batch = tuple(sorted({int(owner[v]) for v in route}))
            self._put(r, [*self.rounds[r], batch])
            self.tours.keep(batch, list(route))
        self.keep = keep
        self.price_of_missing = self.price_of_change = 0.0
        whole = self._whole(self._parts())
        self.usual = whole.cost / max(len(start), 1)
        # Of plans of one cost the shorter is better; where the plan costs nothing, metres guide.
        self.price_of_metre = METRE * whole.cost / whole.length if whole.length else 0.0
        if self.usual <= 0.0:
            self.price_of_metre, self.usual = 1.0, max(whole.length, 1.0) / max(len(start), 1)
        # A second after a deadline costs more than a whole plan may.
        self.price_of_missing = 10.0 * max(whole.cost, whole.length, 1.0)
        self.price_of_change = stability * self.usual
        self.parts = self._parts()
        self.energy = self._energy(self.parts)
        self.best = self._whole(self.parts)
        self.best_rounds = [list(trips) for trips in self.rounds]
        self.fresh = best.routes is None
        self.moves = 0

    def _put(self, r: int, trips: list[Batch]) -> None:
        """Let a robot make these trips."""
        self.rounds[r] = trips
        for batch in trips:
            for order in batch:
                self.robot_of[order] = r

    # -- what plans cost ----------------------------------------------------------------------

    def _of_robot(self, r: int, trips: list[Batch]) -> _Part:
        timed = [self.tours.timed(batch) for batch in trips]
        missed = self.price_of_missing
        value, ends = cost_of_robot(self.instance, self.objective, r, timed, missed)
        if self.price_of_change:  # what is kept is cheaper
            value -= self.price_of_change * sum(self.keep.get(batch) == r for batch in trips)
        return _Part(value, ends, sum(trip.length for trip in timed))

    def _parts(self) -> list[_Part]:
        return [self._of_robot(r, trips) for r, trips in enumerate(self.rounds)]

    def _whole(self, parts: list[_Part]) -> _Part:
        """Return what all robots together come to."""
        last = max(part.ends for part in parts)
        value = sum(part.cost for part in parts) + self.objective.makespan * last
        return _Part(value, last, sum(part.length for part in parts))

    def _energy(self, parts: list[_Part]) -> float:
        """Return the cost that the annealing makes small: with what guides it beside the plan's."""
        whole = self._whole(parts)
        mean = sum(part.ends for part in parts) / len(parts)
        guided = SPREAD * self.objective.makespan * mean + self.price_of_metre * whole.length
        return whole.cost + guided

    def _is_best(self, whole: _Part) -> bool:
        """Return whether a plan is cheaper than the best one, or as cheap and shorter."""
        slack = ROUNDING * self.usual
        if abs(whole.cost - self.best.cost) > slack:
            return whole.cost < self.best.cost
        return whole.length < self.best.length * (1.0 - ROUNDING)

    # -- moves --------------------------------------------------------------------------------

    def anneal(self, stop: Stop) -> None:
        """Move until `stop`, ever more careful."""
        begun, whole = stop.elapsed, stop.remaining
        while not stop(self.moves // MOVES):
            if stop.max_work is not None:
                done = self.moves / MOVES / stop.max_work
            else:
                done = (stop.elapsed - begun) / whole
            warmth = self.usual * WARM * (COLD / WARM) ** min(done, 1.0)
            for _ in range(MOVES):
                self._move(warmth)
            self.moves += MOVES
            self._offer()
        self._offer()

    def _move(self, warmth: float) -> None:
        """Try one change; keep it when it is better, or by chance."""
        draw = self.draw()
        if draw < 0.5:
            changed = self._relocate()
        elif draw < 0.75:
            changed = self._exchange()
        else:
            changed = self._shift_trip()
        if changed is None:
            return
        parts = list(self.parts)
        for r, trips in changed.items():
            if len(trips) > self.instance.robots[r].trips:
                return
            parts[r] = self._of_robot(r, trips)
        energy = self._energy(parts)
        worse = energy - self.energy
        if worse > 0 and self.draw() >= math.exp(-worse / warmth):
            return
        for r, trips in changed.items():
            self._put(r, trips)
        self.parts, self.energy = parts, energy
        if self._is_best(whole := self._whole(parts)):
            self.best = whole
            self.best_rounds = [list(trips) for trips in self.rounds]
            self.fresh = True

    def _below(self, count: int) -> int:
        """Return a random number from 0 to below a count."""
        return int(self.draw() * count)

    def _pick(self) -> tuple[int, int]:
        """Return a robot and one of its trips; often the robot that is back last."""
        used = [r for r, trips in enumerate(self.rounds) if trips]
        if self.objective.makespan and self.draw() < 0.5:
            r = max(used, key=lambda r: self.parts[r].ends)
        else:
            r = used[self._below(len(used))]
        return r, self._below(len(self.rounds[r]))

    def _beside(self, order: int, source: tuple[int, int]) -> tuple[int, int] | None:
        """Return another trip, of a neighbour of an order or any."""
        if self.near.shape[1] and self.draw() < 0.8:
            other = int(self.near[order, self._below(self.near.shape[1])])
            r = self.robot_of[other]
            target = r, next(t for t, batch in enumerate(self.rounds[r]) if other in batch)
        else:
            target = self._pick()
        return None if target == source else target

    def _changed(self, changes: dict[tuple[int, int], Batch]) -> dict[int, list[Batch]]:
        """Return the trips of the robots whose trips change; empty trips go."""
        found: dict[int, list[Batch]] = {}
        for (r, t), batch in changes.items():
            found.setdefault(r, list(self.rounds[r]))[t] = batch
        return {r: [batch for batch in trips if batch] for r, trips in found.items()}

    def _load(self, batch: Batch) -> int:
        return sum(self.weights[o] for o in batch)

    def _relocate(self) -> dict[int, list[Batch]] | None:
        """Move an order to another trip, or to one of its own."""
        source = self._pick()
        r, t = source
        batch = self.rounds[r][t]
        order = batch[self._below(len(batch))]
        rest = tuple(o for o in batch if o != order)
        if rest and self.draw() < 0.1:
            to = self._below(len(self.rounds))
            if self.weights[order] > self.rooms[to]:
                return None
            found = self._changed({source: rest})
            trips = found.setdefault(to, list(self.rounds[to]))
            trips.insert(self._below(len(trips) + 1), (order,))
            return found
        target = self._beside(order, source)
        if target is None:
            return None
        joined = tuple(sorted((*self.rounds[target[0]][target[1]], order)))
        if self._load(joined) > self.rooms[target[0]]:
            return None
        return self._changed({source: rest, target: joined})

    def _exchange(self) -> dict[int, list[Batch]] | None:
        """Exchange two orders of two trips."""
        source = self._pick()
        batch = self.rounds[source[0]][source[1]]
        order = batch[self._below(len(batch))]
        target = self._beside(order, source)
        if target is None:
            return None
        others = self.rounds[target[0]][target[1]]
        other = others[self._below(len(others))]
        mine = tuple(sorted((*(o for o in batch if o != order), other)))
        theirs = tuple(sorted((*(o for o in others if o != other), order)))
        if self._load(mine) > self.rooms[source[0]] or self._load(theirs) > self.rooms[target[0]]:
            return None
        return self._changed({source: mine, target: theirs})

    def _shift_trip(self) -> dict[int, list[Batch]] | None:
        """Give a trip to another turn or robot, or exchange two trips."""
        source = self._pick()
        r, t = source
        batch = self.rounds[r][t]
        if self.draw() < 0.5:
            target = self._pick()
            if target == source:
                return None
            other = self.rounds[target[0]][target[1]]
            if self._load(batch) > self.rooms[target[0]] or self._load(other) > self.rooms[r]:
                return None
            return self._changed({source: other, target: batch})
        to = self._below(len(self.rounds))
        if self._load(batch) > self.rooms[to]:
            return None
        found = self._changed({source: ()})
        trips = found.setdefault(to, list(self.rounds[to]))
        trips.insert(self._below(len(trips) + 1), batch)
        return found

    def _offer(self) -> None:
        """Give the best plan to the run when it is new."""
        if not self.fresh:
            return
        self.fresh = False
        routes: Routes = []
        seats: Seats = []
        for r, trips in enumerate(self.best_rounds):
            for turn, batch in enumerate(trips):
                routes.append(self.tours.route(batch))
                seats.append((r, turn))
        self.run.best.offer(routes, seats=seats)


def _nearest(instance: Instance) -> Ints:
    """Return for each order those whose stops lie nearest to its own, the nearest first."""
    owner = instance.order_of_node[[nodes[0] for nodes in instance.stops]]
    by_order = np.argsort(owner, kind="stable")
    first = np.searchsorted(owner[by_order], np.arange(len(instance.orders)))
    d = instance.stop_distances[1:, 1:][np.ix_(by_order, by_order)]
    to_order = np.minimum.reduceat(d, first, axis=1)
    apart = np.add.reduceat(to_order, first, axis=0)
    np.fill_diagonal(apart, np.inf)
    most = min(NEIGHBOURS, len(instance.orders) - 1)
    return np.argsort(apart, axis=1, kind="stable")[:, :most].astype(np.int64)
