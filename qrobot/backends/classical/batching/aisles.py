"""Batches of whole orders in aisles: simulated annealing with exact tours.

Importing this module imports numba. Each cycle anneals from the best plan so far; then a set
partition over the batches that were met in good plans puts together the best of them.
"""

from __future__ import annotations

import math

import numpy as np

from qrobot._arrays import Ints
from qrobot._extras import is_installed
from qrobot.backends.base import OnBest, Routes, Search, Stop
from qrobot.backends.classical.batching.annealing import anneal, place
from qrobot.backends.classical.batching.lots import Lots
from qrobot.backends.classical.batching.rules import join_by_savings
from qrobot.backends.classical.batching.state import State, new_state
from qrobot.backends.classical.exact.packing import pack
from qrobot.backends.classical.orders import Batch, Orders, Trips, orders_of, tie_of
from qrobot.problem import AisleWarehouse, Instance

__all__ = ["first_fit", "search_aisles"]

MOVES = 2_000
"""Moves between two looks at the clock: a few milliseconds, and one unit of work."""

WARM, COLD = 0.015, 0.4
"""First temperature, as a share of a mean trip, and the last one as a share of the first."""

PATIENT, PATIENCE = 80_000, 0.6
"""Moves for each order from which on a search begins so warm; with fewer, it begins colder, by
this power of their share."""

DEARER, CHEAPER = 1.15, 0.93
"""How the price of overload changes where a plan has some, and where it has none."""

DEAREST, CHEAPEST = 20.0, 0.02
"""Its limits, as multiples of a mean trip by capacity."""

POOL, GOOD = 40_000, 1.01
"""Batches kept for the set partition, from plans this near to the best."""

CYCLE = 1_000
"""Units of work of the first cycle where neither time nor work is limited; then twice as many."""

CYCLES = 3
"""Cycles where time or work is limited."""

PARTITION_SHARE = 0.15
"""Of a cycle, for the set partition."""

PARTITION_WORK = 60
"""Linear programmes for it where work is limited."""

FIRST_WORK, PACKING_SHARE = 40, 0.3
"""Work to find any plan by moves, even when time is up: hundredths of a second; then a packing
gets this share of the time."""

MANY, BEGIN_SHARE = 200, 0.35
"""More orders begin from savings, for which they get this share of the time at most."""

SPARE_TRIPS = 3
"""Trips more than a first packing needs."""


def search_aisles(
    instance: Instance,
    stop: Stop,
    seed: int,
    start: Routes | None = None,
    on_best: OnBest | None = None,
    *,
    partition: bool = True,
) -> Search:
    """Search for batches until `stop`; see `Planner.search`.

    `partition` says whether a set partition puts the best batches together after each cycle.
    """
    search = _Search(instance, stop, seed, start, on_best)
    search.partition = partition and is_installed("ortools")
    return search.run(stop)


class _Search:
    """One search."""

    def __init__(
        self,
        instance: Instance,
        stop: Stop,
        seed: int,
        start: Routes | None,
        on_best: OnBest | None,
    ) -> None:
        assert isinstance(instance.warehouse, AisleWarehouse)
        self.instance, self.on_best = instance, on_best
        self.trips = Trips(instance)
        orders = orders_of(instance)
        if len(orders.weights) > MANY:
            start = _begun(instance, start, stop)
        first = first_fit(orders)
        # More trips than a packing needs only make the search larger.
        packed = max(len(np.unique(first)) + SPARE_TRIPS, len(list(filter(None, start or []))))
        if (orders.capacities == orders.capacities[0]).all() or packed >= len(orders.capacities):
            orders = orders._replace(capacities=orders.capacities[:packed])
        self.orders: Orders = orders
        self.tie = tie_of(instance.warehouse, orders)
        if start:
            batches = self.trips.batches(start)
            batches.sort(key=lambda b: -int(orders.weights[list(b)].sum()))
            if len(batches) <= len(orders.capacities):
                first = np.zeros(len(orders.weights), dtype=np.int64)
                for trip, batch in enumerate(batches):
                    first[list(batch)] = trip
        self.state: State = new_state(orders, self.tie, seed, POOL)
        place(orders, self.state, first)
        self.partition = True
        self.told = math.inf
        self.work = 0
        used = max(1, int((self.state.size > 0).sum()))
        self.scale = float(self.state.length.sum()) / used
        self.usual_price = self.scale / max(1, int(orders.capacities[0]))
        self.state.figures[0] = self.usual_price
        anneal(orders, self.state, 0, 1.0, 0.0)  # notes the first plan, if it has no overload

    def run(self, stop: Stop) -> Search:
        """Anneal in cycles until `stop`."""
        cycle, length, hot = 0, CYCLE, self._warmth(stop)
        if self.state.best[0] < 0:
            self._first_plan(stop)
        while not stop(self.work):
            part = self._cycle(stop, cycle, length)
            self._anneal(part, hot=hot if cycle == 0 else hot / 2)
            if stop(self.work):
                break
            self._partition(stop, part)
            place(self.orders, self.state, self._best_trips())
            cycle, length = cycle + 1, 2 * length
        self._tell()
        return Search(routes=self.trips.routes(self._best()) or None, work=self.work)

    def _first_plan(self, stop: Stop) -> None:
        """Look for a plan where first fit overloads a trip: by moves, or else by packing."""
        self._anneal(Stop(max_work=self.work + FIRST_WORK), hot=WARM)
        if self.state.best[0] >= 0 or stop(self.work):
            return
        part = stop if math.isinf(stop.remaining) else stop.within(PACKING_SHARE * stop.remaining)
        routes, _ = pack(self.instance, part)
        if routes is not None:
            self._take(self.trips.batches(routes))

    def _warmth(self, stop: Stop) -> float:
        """Return the first temperature: as warm as a search of this length cools down from."""
        units = math.inf
        if stop.max_work is not None:
            units = float(stop.max_work)
        elif math.isfinite(stop.remaining):
            begun = stop.elapsed
            anneal(self.orders, self.state, MOVES, COLD * WARM * self.scale, 0.0)
            units = stop.remaining / max(1e-6, stop.elapsed - begun)
        share = units * MOVES / (PATIENT * len(self.orders.weights))
        return float(WARM * min(1.0, share) ** PATIENCE)

    def _cycle(self, stop: Stop, cycle: int, length: int) -> Stop:
        """Return a stop for the annealing of a cycle."""
        share = (1 - PARTITION_SHARE) / max(1, CYCLES - cycle)
        if stop.max_work is not None:
            left = max(1, int(share * (stop.max_work - self.work)))
            return stop.within(max_work=self.work + left)
        if math.isfinite(stop.remaining):
            return stop.within(share * stop.remaining)
        return stop.within(max_work=self.work + length)

    def _anneal(self, stop: Stop, hot: float) -> None:
        begun, state = self.work, self.state
        limit = stop.max_work
        while not stop(self.work):
            passed = stop.elapsed / max(stop.elapsed + stop.remaining, 1e-9)
            if limit is not None:
                passed = max(passed, (self.work - begun) / max(1, limit - begun))
            heat = self.scale * hot * COLD ** min(1.0, passed)
            _, over = anneal(self.orders, state, MOVES, heat, GOOD * state.figures[1])
            self.work += 1
            price = state.figures[0] * (DEARER if over else CHEAPER)
            state.figures[0] = min(
                max(price, CHEAPEST * self.usual_price), DEAREST * self.usual_price
            )
            if self.work % 64 == 0:
                self._tell()
        self._tell()

    def _partition(self, stop: Stop, part: Stop) -> None:
        """Put the best of the kept batches together anew."""
        if not (self.partition and self.state.pool_size[0] and math.isfinite(self.told)):
            return
        from qrobot.backends.classical.generation.search import Generation

        limit = stop.within(PARTITION_SHARE * max(part.elapsed, 0.2))
        if stop.max_work is not None:  # a clock would make the plan depend on the machine
            limit = stop.within(max_work=PARTITION_WORK)
        rows = int(self.state.pool_size[0])
        found = Generation(self.orders, self.tie).improve(
            self.state.pool[:rows], self._best(), limit
        )
        if found is not None:
            self._take(found)
            self._tell()

    def _take(self, plan: list[Batch]) -> None:
        trips = np.zeros(len(self.orders.weights), dtype=np.int64)
        loads = [int(self.orders.weights[list(batch)].sum()) for batch in plan]
        for trip, at in enumerate(sorted(range(len(plan)), key=lambda b: -loads[b])):
            trips[list(plan[at])] = trip
        place(self.orders, self.state, trips)
        self.state.best[:] = trips
        self.state.figures[1] = float(self.state.length.sum()) + self.tie * len(plan)

    def _best_trips(self) -> Ints:
        found = self.state.best[0] >= 0
        return (self.state.best if found else self.state.trip).copy()

    def _best(self) -> list[Batch]:
        if self.state.best[0] < 0:
            return []
        batches: dict[int, list[int]] = {}
        for order, trip in enumerate(self.state.best.tolist()):
            batches.setdefault(trip, []).append(order)
        return [tuple(batch) for batch in batches.values()]

    def _tell(self) -> None:
        if self.state.figures[1] < self.told and self.on_best is not None:
            routes = self.trips.routes(self._best())
            self.on_best(routes, self.instance.length(routes))
        self.told = min(self.told, float(self.state.figures[1]))


def _begun(instance: Instance, start: Routes | None, stop: Stop) -> Routes | None:
    """Return a plan by savings, or the one to start from where that is shorter."""
    # Where work is limited, a clock would make the plan depend on the machine.
    timed = stop.max_work is None and math.isfinite(stop.remaining)
    part = Stop(BEGIN_SHARE * stop.remaining if timed else None, parent=stop)
    lots = Lots(instance, part)
    if not lots.possible:
        return start
    join_by_savings(lots, part)
    routes = lots.routes()
    if start and instance.length(start) <= instance.length(routes):
        return start
    return routes


def first_fit(orders: Orders) -> Ints:
    """Return trips by first fit of the heaviest; what fits nowhere overloads the emptiest trip."""
    room = orders.capacities.copy()
    trips = np.zeros(len(orders.weights), dtype=np.int64)
    for order in np.argsort(-orders.weights, kind="stable").tolist():
        fits = np.flatnonzero(room >= orders.weights[order])
        trip = int(fits[0]) if len(fits) else int(np.argmax(room))
        trips[order] = trip
        room[trip] -= orders.weights[order]
    return trips
