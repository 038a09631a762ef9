"""Column generation over batches of whole orders in aisles: plans with proof, and bounds."""

from __future__ import annotations

import sys

from qrobot._extras import is_installed
from qrobot.backends.base import OnBest, Routes, Search, Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.problem import Instance

__all__ = ["MOST_ORDERS", "bound_of_batches", "can_generate", "generate"]

MOST_ORDERS = 150
"""More orders have too many batches for a bound to be of use."""

FIRST_SHARE, FIRST_SECONDS = 0.1, 1.0
"""Of the time, at most, for a plan to begin with."""

SEEK_WORK = 400
"""Work of each search for a better plan between the parts of a proof."""

EASY_BATCHES, EASY_WORK, FIRST_WORK = 30_000, 0.5, 300
"""Where so few batches fit, they are proven in no time: the first search gets so much work for each
order; otherwise so much in all."""


def can_generate(instance: Instance) -> bool:
    """Return whether column generation takes an instance."""
    return takes(instance) and len(instance.orders) <= MOST_ORDERS and is_installed("ortools")


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
    from qrobot.backends.classical.orders import Batch, Trips, orders_of, tie_of
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

    def seek(until: Stop) -> list[Batch]:
        nonlocal seed
        seed += 1
        short = until.within(max_work=SEEK_WORK)
        found = search_aisles(instance, short, seed, partition=False)
        return trips.batches(found.routes or [])

    proof = programme.prove(trips.batches(start or []), stop, seek)
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


def bound_of_batches(instance: Instance, routes: Routes, stop: Stop) -> float:
    """Return a lower bound of the distance of every plan, given a plan to compare with.

    0 where column generation does not take the instance, or numba is not loaded yet: that and
    compiling take longer than what is kept for a bound at the end of a run.
    """
    if "numba" not in sys.modules or not (can_generate(instance) and compiled_soon(stop)):
        return 0.0
    return generate(instance, stop, start=routes).bound
