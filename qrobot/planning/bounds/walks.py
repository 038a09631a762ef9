"""A bound that is strong for tight capacity: every trip is relaxed to a loaded walk."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.planning.bounds.quick import fewest_trips, most_trips, quick_bound, shortest_ways
from qrobot.planning.bounds.subgradient import climb
from qrobot.problem import Instance

__all__ = ["walk_bound"]


MIN_LOAD_STEPS, MAX_LOAD_STEPS = 8, 250
"""Loads are rounded down to at most this many steps; fewer steps, weaker bound."""

MAX_CELLS = 20_000_000
"""Load steps times pairs of stops: the more stops, the fewer steps."""


def walk_bound(
    instance: Instance, upper: float, stop: Callable[[], bool], rounds: int = 150
) -> float:
    """Return a Lagrangian bound from loaded walks without two-step cycles.

    Each trip is relaxed to a walk of at most one robot's load that may visit a stop again,
    though not right after its neighbour (Christofides, Mingozzi and Toth 1981); prices on
    the stops make up for repeats and are improved by subgradient steps. Splitting orders
    is allowed in the relaxation, so the bound holds for whole orders too.

    Parameters
    ----------
    instance
        The question. Where some rounded load is zero, the stop is left out, which needs the
        triangle inequality: then the walks run on `shortest_ways`.
    upper
        Distance of a known plan, ``inf`` without one: sets the length of the steps.
    stop
        Asked every round.
    rounds
        Most rounds.

    Returns
    -------
    float
        Metres; never below `quick_bound`.
    """
    best = quick_bound(instance)
    upper = min(upper, 2.0 * best)
    weights = instance.stop_weights
    d = instance.stop_distances
    if not weights.any():
        return best
    capacity = int(min(instance.vehicle_capacities.max(), weights.sum()))
    step = -(-capacity // load_steps(instance))
    loads = weights // step
    kept = loads > 0
    if capacity // step < min(MIN_LOAD_STEPS, capacity) or np.count_nonzero(kept) < 2:
        return best
    if not kept.all():
        shorter = shortest_ways(instance, stop)
        if shorter is None:
            return best
        d = shorter
    rows = np.concatenate([[0], np.flatnonzero(kept) + 1])
    d, loads = d[np.ix_(rows, rows)], loads[kept]
    fewest, most = fewest_trips(instance), most_trips(instance)
    # Start where every walk out to its farthest stop pays for itself.
    prices = (d[0, 1:] + d[1:, 0]) * loads / max(capacity // step, 1)

    def relaxed(prices: Floats) -> tuple[float, Floats] | None:
        found = _cheapest_walk(d, loads, capacity // step, prices, stop)
        if found is None:
            return None
        cost, visits = found
        trips = most if cost < 0 else fewest
        return float(prices.sum()) + trips * cost, 1.0 - trips * visits

    return climb(
        relaxed,
        prices,
        best=best,
        upper=upper,
        stop=stop,
        rounds=rounds,
        stale_rounds=8,
        narrowest=1e-3,
    )


def load_steps(instance: Instance) -> int:
    """Return into how many steps the largest load is cut."""
    capacity = int(min(instance.vehicle_capacities.max(), instance.weights.sum()))
    fine = MAX_CELLS // max(len(instance.stops), 1) ** 2
    return max(1, min(capacity, MAX_LOAD_STEPS, fine))


def _cheapest_walk(
    d: Floats,
    loads: npt.NDArray[np.int64],
    capacity: int,
    prices: Floats,
    stop: Callable[[], bool],
) -> tuple[float, Floats] | None:
    """Return the least reduced cost of a walk, and how often it visits each stop.

    None when stopped: the last rounds of large instances take long.
    """
    n = len(loads)
    cost = d[1:, 1:].T - prices[:, None]  # (to, from)
    np.fill_diagonal(cost, np.inf)
    leave = d[0, 1:] - prices
    first = np.full((capacity + 1, n), np.inf)
    second = np.full((capacity + 1, n), np.inf)
    first_from = np.full((capacity + 1, n), -1, dtype=np.intp)
    second_from = np.full((capacity + 1, n), -1, dtype=np.intp)
    for carried in range(int(loads.min()), capacity + 1):
        if stop():
            return None
        to = np.flatnonzero(loads <= carried)
        before = carried - loads[to]
        reach = (
            np.where(first_from[before] == to[:, None], second[before], first[before]) + cost[to]
        )
        here = np.arange(len(to))
        via = reach.argmin(axis=1)
        least = reach[here, via]
        reach[here, via] = np.inf
        then = reach.argmin(axis=1)
        runner = reach[here, then]
        # Coming straight from the depot is one more way, with predecessor -1.
        start = np.where(before == 0, leave[to], np.inf)
        direct = start < least
        second[carried, to] = np.where(direct, least, np.minimum(runner, start))
        second_from[carried, to] = np.where(direct, via, np.where(start < runner, -1, then))
        first[carried, to] = np.where(direct, start, least)
        first_from[carried, to] = np.where(direct, -1, via)
    closed = first + d[1:, 0]
    load, at = divmod(int(closed.argmin()), n)
    total = float(closed[load, at])
    visits = np.zeros(n)
    use_second = False
    while at >= 0:
        visits[at] += 1
        came = int((second_from if use_second else first_from)[load, at])
        load -= int(loads[at])
        use_second = came >= 0 and int(first_from[load, came]) == at
        at = came
    return total, visits
