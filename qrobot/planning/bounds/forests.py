"""A bound that is strong for long trips: trips without the depot are a forest of paths.

In the spirit of Held and Karp's 1-trees (1971) and Fisher's K-trees (1994): k trips past n
stops leave k paths between stops, which are n - k edges without a cycle, and 2k ways to the
depot. The cheapest such edges, with prices that push every stop towards two edges, cost no
more than any plan.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.planning.bounds.quick import fewest_trips, most_trips, quick_bound
from qrobot.planning.bounds.subgradient import climb
from qrobot.problem import Instance

__all__ = ["forest_bound"]

Rows = npt.NDArray[np.intp]

BETWEEN_LOOKS = 50
"""Edges of a tree between looks at the clock."""

MAX_STOPS = 2_500
"""Beyond it the spanning trees take longer than the bound is worth."""


def forest_bound(
    instance: Instance, upper: float, stop: Callable[[], bool], rounds: int = 300
) -> float:
    """Return a Lagrangian bound from spanning forests.

    Parameters
    ----------
    instance
        The question; of an asymmetric matrix each way counts in its shorter direction.
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
    d = np.minimum(instance.stop_distances, instance.stop_distances.T)
    n = len(d) - 1
    if n < 2 or n > MAX_STOPS:
        return best
    trips = np.arange(fewest_trips(instance), min(most_trips(instance), n) + 1)

    def relaxed(prices: Floats) -> tuple[float, Floats] | None:
        tree = _spanning_tree(d[1:, 1:] + prices[:, None] + prices[None, :], stop)
        if tree is None:
            return None
        bound, degrees = _cheapest_forest(d, prices, trips, *tree)
        return bound, degrees - 2.0

    return climb(
        relaxed,
        np.zeros(n),
        best=best,
        upper=upper,
        stop=stop,
        rounds=rounds,
        stale_rounds=10,
        narrowest=1e-4,
    )


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


def _spanning_tree(weights: Floats, stop: Callable[[], bool]) -> tuple[Rows, Floats] | None:
    """Return the edges (n - 1, 2) and lengths of a minimum spanning tree (Prim 1957).

    None when stopped: the trees of large instances take long.
    """
    n = len(weights)
    reach = weights[0].copy()
    via = np.zeros(n, dtype=np.intp)
    outside = np.ones(n, dtype=bool)
    outside[0] = False
    ends = np.empty((n - 1, 2), dtype=np.intp)
    lengths = np.empty(n - 1)
    for edge in range(n - 1):
        if edge % BETWEEN_LOOKS == 0 and stop():
            return None
        v = int(np.where(outside, reach, np.inf).argmin())
        ends[edge] = via[v], v
        lengths[edge] = reach[v]
        outside[v] = False
        nearer = weights[v] < reach
        reach = np.where(nearer, weights[v], reach)
        via = np.where(nearer, v, via)
    return ends, lengths
