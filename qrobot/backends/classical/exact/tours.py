"""The shortest tour past a few stops: proven, also where their subsets are too many to list.

Held and Karp's dynamic programme (1962) up to `MAX_LISTED` stops. Beyond it, symmetric
distances are searched by branch and bound on 1-trees (Held and Karp 1971; Volgenant and Jonker
1982). Asymmetric ones get the dynamic programme again, with only those partial tours that can
still be part of a tour shorter than a known one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot.backends.classical.batching.tour import improve_tour, tour_length
from qrobot.backends.classical.exact.subsets import fitting_subsets, shortest_tours

__all__ = [
    "MAX_LISTED",
    "MAX_STOPS",
    "best_sequence",
    "nearest_tour",
    "shortest_tour",
    "tour_bound",
]


MAX_LISTED = 12
"""Stops whose subsets are all listed: 4,096."""

MAX_STOPS = 40
"""More stops in one trip are not tried."""

MAX_STATES = 400_000
"""Partial tours of one length; more are given up."""

MAX_BRANCHES = 3_000
"""Branches of one tour; more are given up."""

ROUNDS, BRANCH_ROUNDS = 80, 20
"""Rounds of the node prices at first, and in every branch."""

SLACK = 1e-9
"""Relative: what rounding may do to a sum of distances, many times over."""


@dataclass(frozen=True, slots=True)
class _Tree:
    """A 1-tree that bounds all tours from below.

    Parameters
    ----------
    bound
        No tour is shorter; infinite when there is none.
    prices
        Of the nodes.
    degrees, via
        Of each node, and the node that it was joined to.
    """

    bound: float
    prices: Floats
    degrees: Floats
    via: npt.NDArray[np.intp]


def tour_bound(d: Floats, upper: float) -> float:
    """Return a lower bound of every tour.

    Parameters
    ----------
    d
        Distances between depot (row 0) and stops; may be asymmetric: then each way counts in
        its shorter direction.
    upper
        Length of a known tour.
    """
    if len(d) < 4:
        return 0.0
    return _rounded(d, _priced_tree(np.minimum(d, d.T), upper, np.zeros(len(d)), ROUNDS).bound)


def _rounded(d: Floats, bound: float) -> float:
    """Return a bound of tours that is safe from rounding; whole distances have whole tours."""
    if bool((d == np.rint(d)).all()):
        return float(np.ceil(bound - 1e-6))
    return max(0.0, bound * (1 - SLACK))


def _priced_tree(weights: Floats, upper: float, prices: Floats, rounds: int) -> _Tree:
    """Return the best 1-tree that subgradient steps of the node prices find."""
    best: _Tree | None = None
    width, stale = 1.0, 0
    for _ in range(rounds):
        length, degrees, via = _one_tree(weights + prices[:, None] + prices[None, :])
        bound = length - 2.0 * float(prices.sum())
        if best is None or bound > best.bound + 1e-6 * abs(best.bound):
            best, stale = _Tree(bound, prices, degrees, via), 0
        elif (stale := stale + 1) == 4:
            width, stale = width / 2, 0
        slope = degrees - 2.0
        size = float(slope @ slope)
        if size == 0.0 or width < 1e-2 or best.bound >= upper:
            break
        prices = prices + width * max(upper - bound, 1e-3 * upper) / size * slope
    assert best is not None
    return best


def _one_tree(weights: Floats) -> tuple[float, Floats, npt.NDArray[np.intp]]:
    """Return length, degrees and joins of a least 1-tree (the depot is joined twice)."""
    n = len(weights)
    degrees = np.zeros(n)
    reach, via = weights[1].copy(), np.ones(n, dtype=np.intp)
    reach[:2] = np.inf
    outside = np.ones(n, dtype=bool)
    outside[:2] = False
    total = 0.0
    for _ in range(n - 2):
        at = int(reach.argmin())
        total += float(reach[at])
        degrees[at] += 1
        degrees[via[at]] += 1
        outside[at] = False
        nearer = (weights[at] < reach) & outside
        reach[nearer], via[nearer] = weights[at][nearer], at
        reach[at] = np.inf
    home = weights[0, 1:]
    near = np.argpartition(home, 1)[:2]
    degrees[0] = 2
    degrees[near + 1] += 1
    return total + float(home[near].sum()), degrees, via


def shortest_tour(d: Floats, stop: Callable[[], bool]) -> tuple[float, list[int]] | None:
    """Return the length and the sequence of the shortest tour from row 0 past all others.

    Parameters
    ----------
    d
        Distances; may be asymmetric.
    stop
        Asked now and then.

    Returns
    -------
    tuple or None
        ``None`` when stopped, or when too many partial tours remain.
    """
    n = len(d) - 1
    if n <= MAX_LISTED:
        masks, _ = fitting_subsets([1] * n, n)
        tours = shortest_tours(masks, d, stop)
        if tours is None:
            return None
        row = tours.row((1 << n) - 1)
        return float(tours.lengths[row]), [s + 1 for s in tours.stops(row)]
    known = improve_tour(d, nearest_tour(d))
    if bool((d == d.T).all()):
        return _branch(d, known, stop)
    length = tour_length(d, known)
    priced = d + np.diag(np.full(n + 1, np.inf))
    priced = priced - priced.min(axis=0)[None, :]
    priced = priced - priced.min(axis=1)[:, None]
    # Every tour is changed by the same amount: by as much as the known one.
    better = _below(priced, tour_length(priced, known) + SLACK * length, stop)
    if better is None:
        return None
    found = tour_length(d, better)
    return (found, better) if found < length else (length, known)


def _branch(
    d: Floats, known: list[int], stop: Callable[[], bool]
) -> tuple[float, list[int]] | None:
    """Return the shortest tour of symmetric distances, None when stopped or given up."""
    length = tour_length(d, known)
    must = 4.0 * float(d.max()) * len(d)  # taken off a way that a branch demands
    prices = _priced_tree(d, length, np.zeros(len(d)), ROUNDS).prices
    open_: list[tuple[Floats, Floats, int]] = [(d, prices, 0)]
    for _ in range(MAX_BRANCHES):
        if not open_:
            return length, known
        if stop():
            return None
        weights, prices, demanded = open_.pop()
        tree = _priced_tree(weights, length - demanded * must, prices, BRANCH_ROUNDS)
        if not _rounded(d, tree.bound + demanded * must) < length * (1 - SLACK):
            continue
        busy = int(tree.degrees[1:].argmax()) + 1
        if tree.degrees[busy] == 2:
            tour = improve_tour(d, _walked(tree, weights))
            if tour_length(d, tour) < length:
                length, known = tour_length(d, tour), tour
            continue
        open_ += _parted(weights, tree, busy, must, demanded)
    return None


def _parted(
    weights: Floats, tree: _Tree, busy: int, must: float, demanded: int
) -> list[tuple[Floats, Floats, int]]:
    """Return the branches at a stop with too many ways in a 1-tree, the likeliest last.

    Of its ways a and b, either a is not taken, or a is and b is not, or both are and no others.
    """
    joined = [v for v in range(1, len(weights)) if tree.via[v] == busy and v not in (busy, 1)]
    if busy != 1:
        joined.append(int(tree.via[busy]))
    # Ways that are demanded already come first: they cannot be left out.
    joined.sort(key=lambda v: float(weights[busy, v]))
    free = [v for v in joined if weights[busy, v] >= 0]
    taken = [v for v in range(len(weights)) if weights[busy, v] < 0]
    branches = []
    now, count = weights, demanded
    for v in free[: 2 - len(taken)]:
        branches.append((_with(now, busy, [v], np.inf), tree.prices, count))
        now, count = _with(now, busy, [v], -must), count + 1
        taken.append(v)
    others = [v for v in range(len(weights)) if v not in (*taken, busy)]
    branches.append((_with(now, busy, others, np.inf), tree.prices, count))
    return branches


def _with(weights: Floats, a: int, ends: list[int], change: float) -> Floats:
    """Return the weights with some ways at a stop changed by an amount, both ways."""
    changed = weights.copy()
    changed[a, ends] += change
    changed[ends, a] = changed[a, ends]
    return changed


def _walked(tree: _Tree, weights: Floats) -> list[int]:
    """Return the sequence of the stops of a 1-tree that is a tour."""
    n = len(weights)
    near: list[set[int]] = [set() for _ in range(n)]
    home = weights[0, 1:] + tree.prices[1:]
    for v in (np.argpartition(home, 1)[:2] + 1).tolist():
        near[0].add(v)
        near[v].add(0)
    for v in range(2, n):
        near[v].add(int(tree.via[v]))
        near[int(tree.via[v])].add(v)
    tour, at, before = [], min(near[0]), 0
    while at:
        tour.append(at)
        at, before = next(v for v in near[at] if v != before), at
    return tour


def best_sequence(ways: Floats, stop: Callable[[], bool]) -> tuple[list[int], bool]:
    """Return a sequence of the stops of a short way, and whether none is proven to be shorter.

    Parameters
    ----------
    ways
        Row 0 stands for both ends: ways leave it from the start, and enter it at the end. ``inf``
        where no way leads.
    stop
        When the proof of many stops leaves off.
    """
    open_ = np.isfinite(ways)
    # A plan without a forbidden way is shorter than one of these.
    forbidden = 1.0 + float(ways[open_].max(initial=0.0)) * (len(ways) + 1)
    finite = np.where(open_, ways, forbidden)
    np.fill_diagonal(finite, 0.0)
    if len(ways) <= MAX_LISTED + 1:
        stop = _never
    if len(ways) <= MAX_STOPS + 1 and (found := shortest_tour(finite, stop)) is not None:
        return found[1], True
    return improve_tour(finite, nearest_tour(finite)), False


def _never() -> bool:
    return False


def nearest_tour(d: Floats) -> list[int]:
    """Return the tour that always goes to the nearest stop that is left."""
    left, at, tour = set(range(1, len(d))), 0, []
    while left:
        at = min(left, key=lambda v: float(d[at, v]))
        left.remove(at)
        tour.append(at)
    return tour


def _below(c: Floats, room: float, stop: Callable[[], bool]) -> list[int] | None:
    """Return the cheapest tour of cost at most `room`, by layers of partial tours.

    No cost is negative, so a partial tour above `room` is dropped.
    """
    n = len(c) - 1
    start = np.flatnonzero(c[0, 1:] <= room)
    masks: Ints = np.left_shift(np.int64(1), start)
    last, cost = start, c[0, 1:][start]
    layers = [(masks, last, np.zeros(len(start), dtype=np.intp))]
    for _ in range(n - 1):
        if stop():
            return None
        parts = []
        for j in range(n):
            bit = np.int64(1 << j)
            total = cost + c[last + 1, j + 1]
            rows = np.flatnonzero(((masks & bit) == 0) & (total <= room))
            parts.append((masks[rows] | bit, np.full(len(rows), j), total[rows], rows))
        masks, last, cost, before = (np.concatenate(column) for column in zip(*parts, strict=True))
        # The cheapest of those that have been to the same stops and end at the same one.
        order = np.lexsort((cost, last, masks))
        masks, last, cost, before = masks[order], last[order], cost[order], before[order]
        first = np.ones(len(masks), dtype=bool)
        first[1:] = (masks[1:] != masks[:-1]) | (last[1:] != last[:-1])
        masks, last, cost, before = masks[first], last[first], cost[first], before[first]
        if not len(masks) or len(masks) > MAX_STATES:
            return None
        layers.append((masks, last, before))
    at = int((cost + c[last + 1, 0]).argmin())
    tour = []
    for _, ends, parents in reversed(layers):
        tour.append(int(ends[at]) + 1)
        at = int(parents[at])
    return tour[::-1]
