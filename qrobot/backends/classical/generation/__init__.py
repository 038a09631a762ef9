"""Column generation over batches of whole orders in aisles: plans with proof, and bounds."""

from __future__ import annotations

import math
import sys
import time
from typing import TYPE_CHECKING

import numpy as np

from qrobot._extras import is_installed
from qrobot.backends.base import OnBest, Routes, Search, Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.problem import Instance

if TYPE_CHECKING:
    from qrobot.backends.classical.orders import Batch, Trips

__all__ = [
    "MOST_ORDERS",
    "bound_of_batches",
    "can_generate",
    "count_of_batches",
    "generate",
    "is_worth_proving",
]

MOST_ORDERS = 150
"""More orders have too many batches for a bound to be of use."""

FIRST_SHARE, FIRST_SECONDS = 0.1, 1.0
"""Of the time, at most, for a plan to begin with."""

SEEK_SHARE, SEEK_SECONDS, SEEK_WORK = 0.4, 0.3, 400
"""Of the time of a proof, for searches for better plans between its parts; the least time, or the
work, of each."""

BATCHES_A_SECOND = 1e7
"""More batches than that for each second that is left are hardly ever bounded in time."""

EASY_BATCHES, EASY_WORK, FIRST_WORK = 30_000, 0.5, 300
"""Where so few batches fit, they are proven in no time: the first search gets so much work for each
order; otherwise so much in all."""


def can_generate(instance: Instance) -> bool:
    """Return whether column generation takes an instance."""
    return takes(instance) and len(instance.orders) <= MOST_ORDERS and is_installed("ortools")


def count_of_batches(instance: Instance) -> float:
    """Return how many batches can be in a plan with as few trips as can be."""
    from qrobot.backends.classical.generation.batches import count_batches

    capacities = instance.vehicle_capacities
    total = int(instance.order_weights.sum())
    fewest = int(np.searchsorted(np.cumsum(capacities), total)) + 1
    lightest = max(0, total - int(capacities[: fewest - 1].sum()))
    return count_batches(instance.order_weights, int(capacities[0]), lightest)


def is_worth_proving(instance: Instance, stop: Stop) -> bool:
    """Return whether a proof, or a bound, is likely to come about in the time until `stop`."""
    return count_of_batches(instance) <= BATCHES_A_SECOND * stop.remaining


def generate(
    instance: Instance,
    stop: Stop,
    seed: int = 0,
    start: Routes | None = None,
    on_best: OnBest | None = None,
) -> Search:
    """Search for the best batches, and prove them; see `Planner.search`."""
    # These import numba, which takes a second.
    from qrobot.backends.classical.batching.aisles import search_aisles
    from qrobot.backends.classical.generation.batches import count_batches
    from qrobot.backends.classical.generation.search import Generation
    from qrobot.backends.classical.orders import Trips, orders_of, tie_of
    from qrobot.problem import AisleWarehouse

    assert isinstance(instance.warehouse, AisleWarehouse)
    orders, trips = orders_of(instance), Trips(instance)
    if start is None:
        left, work = stop.remaining, FIRST_WORK
        if count_batches(orders.weights, int(orders.capacities[0])) <= EASY_BATCHES:
            work = 1 + int(EASY_WORK * len(orders.weights))
        if stop.max_work is not None:
            work = min(work, max(1, stop.max_work // 5))
        seconds = min(FIRST_SHARE * left, FIRST_SECONDS) if left < float("inf") else None
        quick = stop.within(seconds, max_work=work)
        start = search_aisles(instance, quick, seed, None, on_best).routes
    tie = tie_of(instance.warehouse, orders)
    programme = Generation(orders, tie)

    seeker = _Seeker(instance, trips, seed)
    proof = programme.prove(trips.batches(start or []), stop, seeker)
    routes = start
    if proof.plan is not None:
        routes = trips.routes(proof.plan)
        if on_best is not None:
            on_best(routes, instance.length(routes))
    bound = max(0.0, proof.bound - tie * min(len(orders.weights), len(orders.capacities)))
    if proof.complete and routes is None:
        from qrobot.backends.classical.exact.packing import no_packing

        return Search(infeasible=no_packing(instance), work=proof.work)
    if proof.complete and routes is not None:
        bound = instance.length(routes)
    return Search(routes=routes, bound=bound, optimal=proof.complete, work=proof.work)


class _Seeker:
    """Searches for better plans between the parts of a proof, each from another seed."""

    def __init__(self, instance: Instance, trips: Trips, seed: int) -> None:
        self._instance, self._trips, self._seed = instance, trips, seed
        self._began, self._spent = time.perf_counter(), 0.0
        self._asked, self._due = 0, 1

    def __call__(self, stop: Stop) -> list[Batch]:
        """Return the batches of another plan, or none when it is not time for one."""
        from qrobot.backends.classical.batching.aisles import search_aisles

        begun = time.perf_counter()
        elapsed = begun - self._began
        self._asked += 1
        if stop.max_work is None and math.isfinite(stop.remaining):
            if elapsed < SEEK_SECONDS or self._spent > SEEK_SHARE * elapsed:
                return []
            short = stop.within(max(SEEK_SECONDS, SEEK_SHARE / 2 * elapsed))
        elif self._asked < self._due:
            return []
        else:
            self._due = 2 * self._asked + 2
            short = stop.within(max_work=SEEK_WORK)
        self._seed += 1
        found = search_aisles(self._instance, short, self._seed, partition=False)
        self._spent += time.perf_counter() - begun
        return self._trips.batches(found.routes or [])


def bound_of_batches(instance: Instance, routes: Routes, stop: Stop) -> float:
    """Return a lower bound of the distance of every plan, given a plan to compare with.

    0 where column generation does not take the instance, or numba is not loaded yet: that and
    compiling take longer than what is kept for a bound at the end of a run.
    """
    if "numba" not in sys.modules or not (can_generate(instance) and compiled_soon(stop)):
        return 0.0
    return generate(instance, stop, start=routes).bound
