"""The batching search: which orders share a trip, and in which sequence they are collected."""

from __future__ import annotations

import math
from collections.abc import Callable

from qrobot.backends.base import Capabilities, OnBest, Routes, Search, Stop
from qrobot.backends.classical.batching.ruin import Batches, Yard
from qrobot.problem import Instance

__all__ = ["BatchingPlanner", "begin", "polished"]

WARM, COLD = 0.1, 0.001
"""First and last temperature of the acceptance, as shares of the mean trip length."""


MANY = 10_000
"""Orders times trips: more are not tried one by one for a first plan."""


class BatchingPlanner:
    """Good plans for orders that stay whole, without any extra software.

    Ruin and recreate with simulated-annealing acceptance; tours are shortened by 2-opt and
    or-opt. Work units: ruin-and-recreate rounds.
    """

    name = "batching"
    capabilities = Capabilities(kind="planner")

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,
        on_best: OnBest | None = None,
    ) -> Search:
        """Search until `stop`; see `Planner.search`. `start` may leave orders out."""
        if not instance.orders:
            return Search(routes=[])
        yard = Yard(instance, seed, stop)
        counter = _Counter(stop)

        def tell(tours: list[list[int]]) -> None:
            if on_best is not None:
                routes = yard.routes(tours)
                on_best(routes, instance.length(routes))

        routes = polished(yard, begin(yard, start), counter, tell)
        return Search(routes=routes, work=counter.rounds)


class _Counter(Stop):
    """A stop that remembers how many rounds it was asked for."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(None, stop.max_work, parent=stop)
        self.rounds = 0

    def __call__(self, work: int = 0) -> bool:
        self.rounds = max(self.rounds, work)
        return super().__call__(work)


def polished(
    yard: Yard,
    now: Batches,
    stop: Stop,
    tell: Callable[[list[list[int]]], None] | None = None,
) -> Routes | None:
    """Ruin and recreate until `stop`; return the best routes, or None without a full plan.

    Parameters
    ----------
    yard
        The instance.
    now
        Where to start; changed.
    stop
        Asked every round.
    tell
        Told the tours of every better full plan.
    """
    best = now.copy()
    told = math.inf
    scale = yard.driven(now.tours) / max(1, sum(1 for tour in now.tours if tour))
    rounds = 0
    while True:
        if not best.absent and best.cost < told:
            told = best.cost
            if tell is not None:
                tell(best.tours)
        if stop(rounds):
            break
        rounds += 1
        heat = scale * WARM * (COLD / WARM) ** _progress(stop, rounds)
        trial = now.copy()
        changed = trial.ruin() | trial.recreate()
        limit = now.cost - heat * math.log(max(yard.rng.random(), 1e-300))
        if trial.cost < limit * 1.01 + heat:
            trial.polish({t for t in changed if trial.tours[t]})
        if trial.cost < limit:
            now = trial
            if now.cost < best.cost * (1 - 1e-12):
                best = now.copy()
    return None if best.absent else yard.routes(best.tours)


def begin(yard: Yard, routes: Routes | None) -> Batches:
    """Return the state of given routes, completed by insertion of what they leave out.

    Parameters
    ----------
    yard
        The instance.
    routes
        Routes of nodes; orders that are split, repeated or too heavy for their trip are
        taken out and inserted anew.
    """
    state = Batches.empty(yard)
    if routes is None and len(yard.weights) * len(yard.capacities) > MANY:
        routes = yard.instance.first_routes()  # one by one would take seconds
    if routes:
        _place(state, yard.tours(routes))
    state.recreate()
    state.polish({t for t, tour in enumerate(state.tours) if tour})
    return state


def _place(state: Batches, tours: list[list[int]]) -> None:
    """Lay tours onto the trips, the heaviest onto the largest, as far as they are valid."""
    yard = state.yard
    placed: set[int] = set()
    batches = []
    for tour in tours:
        here = set(tour)
        whole = {
            order
            for order in {yard.order_of[s] for s in tour}
            if order not in placed and here.issuperset(yard.order_stops[order])
        }
        placed |= whole
        kept = [s for s in tour if yard.order_of[s] in whole]
        batches.append((sum(yard.weights[o] for o in whole), kept))
    batches.sort(key=lambda b: -b[0])
    for trip, ((_, tour), capacity) in enumerate(zip(batches, yard.capacities, strict=False)):
        load, kept_orders = 0, set()
        for order in dict.fromkeys(yard.order_of[s] for s in tour):
            if load + yard.weights[order] <= capacity:
                load += yard.weights[order]
                kept_orders.add(order)
        state.put(trip, [s for s in tour if yard.order_of[s] in kept_orders])
        state.loads[trip] = load
        state.absent = [o for o in state.absent if o not in kept_orders]


def _progress(stop: Stop, rounds: int) -> float:
    """Return how much of the time or work is used, 0 to 1."""
    shares = [0.0]
    if stop.max_work:
        shares.append(rounds / stop.max_work)
    left = stop.remaining
    if math.isfinite(left):
        shares.append(stop.elapsed / max(stop.elapsed + left, 1e-9))
    return min(1.0, max(shares))
