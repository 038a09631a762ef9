"""Lower bounds that hold for any plan, for instances too large to prove exactly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot.problem import Instance

__all__ = ["quick_bound", "route_bound"]

Floats = npt.NDArray[np.float64]

MAX_LOAD_STEPS = 400
"""Loads are rounded down to at most this many steps; fewer steps, weaker bound."""


def fewest_trips(instance: Instance) -> int:
    """Return a number of trips that no plan can stay below: the largest robots, filled."""
    total = int(instance.weights.sum())
    if not instance.orders:
        return 0
    reach = np.cumsum(instance.vehicle_capacities)
    return min(int(np.searchsorted(reach, total)) + 1, len(reach))


def quick_bound(instance: Instance) -> float:
    """Return a bound that costs nothing: every stop is entered, every trip comes home.

    Valid for any matrix. Each place must be entered from somewhere else and each trip must
    return to the depot; the farthest item must be fetched.
    """
    if not instance.items:
        return 0.0
    d = instance.stop_distances
    apart = d + np.where(np.eye(len(d), dtype=bool), np.inf, 0.0)
    entered = float(apart[:, 1:].min(axis=0).sum()) + fewest_trips(instance) * float(d[1:, 0].min())
    if _metric(instance):
        return max(entered, float((d[0] + d[:, 0]).max()))
    return entered


def route_bound(
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
        The question. Distances must obey the triangle inequality if some weight is zero;
        otherwise only `quick_bound` is returned.
    upper
        Distance of a known plan.
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
    weights = instance.stop_weights
    d = instance.stop_distances
    if not weights.any():
        return best
    capacity = int(min(instance.vehicle_capacities.max(), weights.sum()))
    step = -(-capacity // MAX_LOAD_STEPS)
    loads = weights // step
    kept = loads > 0
    if not kept.all() and not _metric(instance):
        return best
    rows = np.concatenate([[0], np.flatnonzero(kept) + 1])
    d, loads = d[np.ix_(rows, rows)], loads[kept]
    if len(loads) < 2 or len(loads) > 250:
        return best
    fewest, most = fewest_trips(instance), _most_trips(instance, d)
    # Start where every walk out to its farthest stop pays for itself.
    prices = (d[0, 1:] + d[1:, 0]) * loads / max(capacity // step, 1)
    width, stale = 1.0, 0
    for _ in range(rounds):
        if stop():
            break
        cost, visits = _cheapest_walk(d, loads, capacity // step, prices)
        trips = most if cost < 0 else fewest
        bound = float(prices.sum()) + trips * cost
        if bound > best * (1 + 1e-9):
            best, stale = bound, 0
        elif (stale := stale + 1) == 8:
            width, stale = width / 2, 0
        slope = 1.0 - trips * visits
        length = float(slope @ slope)
        if length < 1e-12 or width < 1e-3:
            break
        prices = prices + width * max(upper - bound, 1e-3 * upper) / length * slope
    # Prices were summed in floating point; a relative 1e-9 covers every rounding.
    return best * (1 - 1e-9)


def _most_trips(instance: Instance, d: Floats) -> int:
    """Return a number of trips that some shortest plan does not exceed.

    Two trips that fit on one robot together can be joined, unless the way between two
    stops is longer than over the depot; so at most one trip is half empty or less.
    """
    capacities = instance.vehicle_capacities
    joinable = bool((d[1:, 0, None] + d[None, 0, 1:] >= d[1:, 1:] - 1e-9).all())
    if not joinable or instance.whole_orders or capacities[0] != capacities[-1]:
        return len(capacities)
    total = int(instance.weights.sum())
    return min(len(capacities), max(1, 2 * total // int(capacities[0]) + 1))


def _cheapest_walk(
    d: Floats, loads: npt.NDArray[np.int64], capacity: int, prices: Floats
) -> tuple[float, Floats]:
    """Return the least reduced cost of a walk, and how often it visits each stop."""
    n = len(loads)
    cost = d[1:, 1:].T - prices[:, None]  # (to, from)
    np.fill_diagonal(cost, np.inf)
    leave = d[0, 1:] - prices
    first = np.full((capacity + 1, n), np.inf)
    second = np.full((capacity + 1, n), np.inf)
    first_from = np.full((capacity + 1, n), -1, dtype=np.intp)
    second_from = np.full((capacity + 1, n), -1, dtype=np.intp)
    for carried in range(int(loads.min()), capacity + 1):
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


def _metric(instance: Instance) -> bool:
    """Whether leaving a stop out never makes a way longer."""
    d = instance.stop_distances
    if len(d) > 300:
        return False
    over = min(
        (float((d[:, k, None] + d[None, k, :] - d).min()) for k in range(len(d))), default=0.0
    )
    return over >= -1e-9 * float(d.max(initial=1.0))
