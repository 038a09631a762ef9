"""Two Lagrangian bounds: prices on the stops that are raised where a relaxed plan passes too often.

Each relaxes the plan to something that is quickly made at least cost, which no plan is below.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.planning.bounds.quick import fewest_trips, most_trips, quick_bound, shortest_ways
from qrobot.problem import Instance
from qrobot.problem.spanning import spanning_tree

__all__ = ["forest_bound", "load_steps", "walk_bound"]

Rows = npt.NDArray[np.intp]

MAX_STOPS = 2_500
"""Beyond it the spanning trees take longer than the bound is worth."""

MIN_LOAD_STEPS, MAX_LOAD_STEPS = 8, 250
"""Loads are rounded down to at most this many steps; fewer steps, weaker bound."""

MAX_CELLS = 20_000_000
"""Load steps times pairs of stops: the more stops, the fewer steps."""

Relaxation = Callable[[Floats], tuple[float, Floats] | None]
"""From prices, shape (n,), to a valid bound and its slope; ``None`` when stopped."""


def forest_bound(
    instance: Instance, upper: float, stop: Callable[[], bool], rounds: int = 300
) -> float:
    """Return a bound that is strong for long trips: without the depot they are a forest of paths.

    In the spirit of Held and Karp's 1-trees (1971) and Fisher's K-trees (1994): k trips past n
    stops leave k paths between stops, which are n - k edges without a cycle, and 2k ways to the
    depot. The cheapest such edges, with prices that push every stop towards two edges, cost no
    more than any plan.

    Parameters
    ----------
    instance
        The question; of an asymmetric matrix each way counts in its shorter direction.
    upper
        Distance of a known plan, ``inf`` without one: sets the length of the steps.
    stop, rounds
        Asked every round; most rounds.

    Returns
    -------
    float
        Metres; never below `quick_bound`.
    """
    best = quick_bound(instance)
    upper = min(upper, 2.0 * best)
    d = np.minimum(instance.stop_distances, instance.stop_distances.T)
    n = len(d) - 1
    if n < 2 or n > MAX_STOPS:
        return best
    trips = np.arange(fewest_trips(instance), min(most_trips(instance), n) + 1)

    def relaxed(prices: Floats) -> tuple[float, Floats] | None:
        tree = spanning_tree(d[1:, 1:] + prices[:, None] + prices[None, :], stop)
        if tree is None:
            return None
        bound, degrees = _cheapest_forest(d, prices, trips, *tree)
        return bound, degrees - 2.0

    return _climb(relaxed, np.zeros(n), best, upper, stop, rounds, stale_rounds=10, narrowest=1e-4)


def _cheapest_forest(
    d: Floats, prices: Floats, trips: npt.NDArray[np.intp], ends: Rows, lengths: Floats
) -> tuple[float, Floats]:
    """Return the least priced cost of forest and depot ways, and the stops' degrees.

    The forest is a part of the spanning tree with the edges `ends` of priced `lengths`.
    """
    n = len(prices)
    order = np.argsort(lengths, kind="stable")
    # Kruskal's greedy choice: the cheapest forest of m edges is the m shortest tree edges.
    forest = np.concatenate([[0.0], np.cumsum(lengths[order])])
    home = d[0, 1:] + prices
    nearest = np.argsort(home, kind="stable")
    # A trip of one stop uses its way to the depot twice, so the nearest serve both ways.
    ways = np.concatenate([[0.0], 2 * np.cumsum(home[nearest])])
    totals = forest[n - trips] + ways[trips]
    k = int(trips[int(np.argmin(totals))])
    degrees = np.zeros(n)
    kept = ends[order[: n - k]]
    np.add.at(degrees, kept.ravel(), 1.0)
    degrees[nearest[:k]] += 2.0
    return float(totals.min() - 2 * prices.sum()), degrees


def walk_bound(
    instance: Instance, upper: float, stop: Callable[[], bool], rounds: int = 150
) -> float:
    """Return a bound that is strong for tight capacity: from loaded walks without two-step cycles.

    Each trip is relaxed to a walk of at most one robot's load that may visit a stop again,
    though not right after its neighbour (Christofides, Mingozzi and Toth 1981); prices on
    the stops make up for repeats and are improved by subgradient steps. Splitting orders
    is allowed in the relaxation, so the bound holds for whole orders too.

    Parameters
    ----------
    instance
        The question. Where some rounded load is zero, the stop is left out, which needs the
        triangle inequality: then the walks run on `shortest_ways` over the stops left out.
    upper
        Distance of a known plan, ``inf`` without one: sets the length of the steps.
    stop, rounds
        Asked every round; most rounds.

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
    steps = load_steps(instance)
    if steps < min(MIN_LOAD_STEPS, capacity):
        return best  # above 1,581 stops: so coarse that the ways out and back say as much
    # Rounded up, but never to fewer steps than that.
    step = max(1, min(-(-capacity // steps), capacity // MIN_LOAD_STEPS))
    loads = weights // step
    kept = loads > 0
    if np.count_nonzero(kept) < 2:
        return best
    if not kept.all():
        shorter = shortest_ways(instance, stop, (np.flatnonzero(~kept) + 1).tolist())
        if shorter is None:
            return best
        d = shorter
    rows = np.concatenate([[0], np.flatnonzero(kept) + 1])
    d, loads = d[np.ix_(rows, rows)], loads[kept]
    fewest, most = fewest_trips(instance), most_trips(instance)
    # Start where every walk out to its farthest stop pays for itself.
    prices = (d[0, 1:] + d[1:, 0]) * loads / max(capacity // step, 1)
    possible = _loads_of_walks(loads, capacity // step)

    def relaxed(prices: Floats) -> tuple[float, Floats] | None:
        found = _cheapest_walk(d, loads, possible, prices, stop)
        if found is None:
            return None
        cost, visits = found
        trips = most if cost < 0 else fewest
        return float(prices.sum()) + trips * cost, 1.0 - trips * visits

    return _climb(relaxed, prices, best, upper, stop, rounds, stale_rounds=8, narrowest=1e-3)


def load_steps(instance: Instance) -> int:
    """Return into how many steps the largest load is cut."""
    capacity = int(min(instance.vehicle_capacities.max(), instance.weights.sum()))
    fine = MAX_CELLS // max(len(instance.stops), 1) ** 2
    return max(1, min(capacity, MAX_LOAD_STEPS, fine))


def _loads_of_walks(loads: npt.NDArray[np.int64], capacity: int) -> npt.NDArray[np.bool_]:
    """Return for each load whether stops add up to it, each as often as one likes."""
    possible = np.zeros(capacity + 1, dtype=bool)
    possible[0] = True
    for load in range(1, capacity + 1):
        possible[load] = possible[load - loads[loads <= load]].any()
    return possible


def _cheapest_walk(
    d: Floats,
    loads: npt.NDArray[np.int64],
    possible: npt.NDArray[np.bool_],
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
    first = np.full((len(possible), n), np.inf)
    second = np.full((len(possible), n), np.inf)
    first_from = np.full((len(possible), n), -1, dtype=np.intp)
    second_from = np.full((len(possible), n), -1, dtype=np.intp)
    for carried in (np.flatnonzero(possible[1:]) + 1).tolist():
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


def _climb(
    relaxation: Relaxation,
    prices: Floats,
    best: float,
    upper: float,
    stop: Callable[[], bool],
    rounds: int,
    *,
    stale_rounds: int,
    narrowest: float,
) -> float:
    """Return the best bound that subgradient steps on the prices of stops lead to.

    B. T. Polyak, USSR Computational Mathematics and Mathematical Physics 9 (1969) 14; the step is
    halved where the bound stops rising, as M. Held, P. Wolfe and H. P. Crowder, Mathematical
    Programming 6 (1974) 62, do.

    Parameters
    ----------
    relaxation
        The relaxed question under prices.
    prices
        The first prices.
    best
        A bound that is known already.
    upper
        Cost of a known plan: sets the length of the steps.
    stop, rounds
        Asked every round; most rounds.
    stale_rounds
        Rounds without a better bound before the steps are halved.
    narrowest
        Part of the first step's length that ends the search.

    Returns
    -------
    float
        At least `best`, less a relative 1e-9 that covers the rounding of summed prices.
    """
    width, stale = 1.0, 0
    for _ in range(rounds):
        found = None if stop() else relaxation(prices)
        if found is None:
            break
        bound, slope = found
        if bound > best * (1 + 1e-9):
            best, stale = bound, 0
        elif (stale := stale + 1) == stale_rounds:
            width, stale = width / 2, 0
        length = float(slope @ slope)
        if length < 1e-12 or width < narrowest:
            break
        prices = prices + width * max(upper - bound, 1e-3 * upper) / length * slope
    return best * (1 - 1e-9)
