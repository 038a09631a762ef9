"""The batching search: which orders share a trip, and in which sequence they are collected."""

from __future__ import annotations

import math
from collections.abc import Callable

from qrobot.backends.base import Capabilities, OnBest, Routes, Search, Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.backends.classical.batching.ruin import Batches, SearchData
from qrobot.problem import Instance

__all__ = ["BatchingPlanner", "batches_of", "ruin_and_recreate"]

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
        if takes(instance) and compiled_soon(stop):
            from qrobot.backends.classical.batching.aisles import search_aisles

            return search_aisles(instance, stop, seed, start, on_best)
        data = SearchData(instance, seed, stop)
        counter = _Counter(stop)

        def tell(tours: list[list[int]]) -> None:
            if on_best is not None:
                routes = data.routes(tours)
                on_best(routes, instance.length(routes))

        routes = ruin_and_recreate(data, batches_of(data, start), counter, tell)
        return Search(routes=routes, work=counter.rounds)


class _Counter(Stop):
    """A stop that remembers how many rounds it was asked for."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(None, stop.max_work, parent=stop)
        self.rounds = 0

    def __call__(self, work: int = 0) -> bool:
        self.rounds = max(self.rounds, work)
        return super().__call__(work)


def ruin_and_recreate(
    data: SearchData,
    now: Batches,
    stop: Stop,
    tell: Callable[[list[list[int]]], None] | None = None,
) -> Routes | None:
    """Ruin and recreate until `stop`; return the best routes, or None without a full plan.

    Parameters
    ----------
    data
        The instance.
    now
        Where to start; changed.
    stop
        Asked every round.
    tell
        Told the tours of every better full plan.
    """
    best = now.copy()
    if not best.absent and stop.remaining <= 0:
        return data.routes(best.tours)
    told = math.inf
    scale = data.driven(now.tours) / max(1, sum(1 for tour in now.tours if tour))
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
        limit = now.cost - heat * math.log(max(data.rng.random(), 1e-300))
        if trial.cost < limit * 1.01 + heat:
            trial.polish({t for t in changed if trial.tours[t]})
        if trial.cost < limit:
            now = trial
            if now.cost < best.cost * (1 - 1e-12):
                best = now.copy()
    return None if best.absent else data.routes(best.tours)


def batches_of(data: SearchData, routes: Routes | None) -> Batches:
    """Return the state of given routes, completed by insertion of what they leave out.

    Parameters
    ----------
    data
        The instance.
    routes
        Routes of nodes; orders that are split, repeated or too heavy for their trip are
        taken out and inserted anew.
    """
    state = Batches.empty(data)
    if routes is None and len(data.weights) * len(data.capacities) > MANY:
        routes = data.instance.first_routes()  # one by one would take seconds
    if routes:
        _place(state, data.tours(routes))
    state.recreate()
    state.polish({t for t, tour in enumerate(state.tours) if tour})
    return state


def _place(state: Batches, tours: list[list[int]]) -> None:
    """Lay tours onto the trips, the heaviest onto the largest, as far as they are valid."""
    data = state.data
    placed: set[int] = set()
    batches = []
    for tour in tours:
        here = set(tour)
        whole = {
            order
            for order in {data.order_of[s] for s in tour}
            if order not in placed and here.issuperset(data.order_stops[order])
        }
        placed |= whole
        kept = [s for s in tour if data.order_of[s] in whole]
        batches.append((sum(data.weights[o] for o in whole), kept))
    batches.sort(key=lambda b: -b[0])
    for trip, ((_, tour), capacity) in enumerate(zip(batches, data.capacities, strict=False)):
        load, kept_orders = 0, set()
        for order in dict.fromkeys(data.order_of[s] for s in tour):
            if load + data.weights[order] <= capacity:
                load += data.weights[order]
                kept_orders.add(order)
        state.put(trip, [s for s in tour if data.order_of[s] in kept_orders])
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
