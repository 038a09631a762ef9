"""How long a way may be before no good plan takes it, and what lies far from everything.

A table may mark ways that nobody may take with a large number. One such number would set the
scale of everything that is measured by the largest distance: the resolution of integer
solvers, penalties, temperatures. So a plan is made quickly, and what is longer than that whole
plan costs as much as it: no better plan takes such a way, whatever its number is.

The quick plan puts every order where it costs least, one after the other (Rosenkrantz, Stearns
and Lewis 1977 for one tour; here for all trips at once, each with its room).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.problem.spanning import spanning_tree

__all__ = ["first_trips", "insert_orders", "outlying", "useful_limit"]

Rows = npt.NDArray[np.intp]

PASSES = 3
"""How often every order is taken out and put back where it costs least."""

FAR = 10.0
"""A place is far off when it is this many times farther from the depot than the next."""


def useful_limit(
    d: Floats,
    lots: Sequence[Sequence[int]],
    weights: Sequence[int],
    capacities: npt.NDArray[np.int64],
    spread: float = 1.0,
) -> float:
    """Return a price that no way of a shortest plan reaches, ``inf`` when all ways are useful.

    It is more than the length of some plan without a forbidden way; where none was found
    quickly, ``inf`` when no way is forbidden, else `_price_above`. The arguments are those of
    `insert_orders`, but `d` is ``inf`` where no way leads. `spread` is by how much a metre of one
    robot may cost more than that of another: a long way of a fast one may cost less time than a
    short plan of slow ones, so the price is so many times as large.
    """
    if len(d) < 2:
        return math.inf
    ways = np.isfinite(d)
    longest = float(d.max(where=ways, initial=0.0))
    entered = np.where(np.eye(len(d), dtype=bool), np.inf, d)[:, 1:].min(axis=0)
    if ways.all() and (longest <= float(entered.sum()) or longest <= _spanning(d)):
        return math.inf  # every plan is longer than every way
    price = float(math.ceil(spread * _price_above(d, min(len(lots), len(capacities)))))
    priced = np.where(ways, d, price)
    most = longest if ways.all() else price
    known = math.inf
    for sequence, first_fit in _ways_to_insert(priced, lots, weights):
        trips = insert_orders(
            priced, lots, weights, capacities, sequence, first_fit=first_fit, passes=PASSES
        )
        known = math.inf if trips is None else float(priced[trips[:-1], trips[1:]].sum())
        if known < most:
            break
    else:
        return math.inf if ways.all() else price
    if known == 0.0:
        return float(d[d > 0].min())
    kept = d[d <= known]
    limit = 1.01 * known * spread
    # Whole distances stay whole.
    return float(math.ceil(limit)) if bool((kept == np.rint(kept)).all()) else limit


def first_trips(
    d: Floats,
    lots: Sequence[Sequence[int]],
    weights: Sequence[int],
    capacities: npt.NDArray[np.int64],
) -> list[list[int]] | None:
    """Return the rows of each trip of a plan made in no time, or None where it fails.

    The arguments are those of `insert_orders`.
    """
    heaviest_first = sorted(range(len(weights)), key=lambda o: -weights[o])
    for first_fit in (False, True):
        row = insert_orders(d, lots, weights, capacities, heaviest_first, first_fit=first_fit)
        if row is not None:
            trips = np.split(row, np.flatnonzero(row == 0)[1:])
            return [[s for s in trip.tolist() if s] for trip in trips if len(trip) > 1]
    return None


def _spanning(d: Floats) -> float:
    """Return the length of a shortest tree over all rows: no plan is shorter."""
    tree = spanning_tree(np.minimum(d, d.T))
    assert tree is not None  # nothing stopped it
    return float(tree[1].sum())


def _price_above(d: Floats, trips: int) -> float:
    """Return a price that is above every plan of at most `trips` trips along finite ways."""
    # Every stop is left once, the depot once a trip, each by its longest way at most.
    longest = d.max(axis=1, where=np.isfinite(d), initial=0.0)
    return math.ceil(1.01 * float(longest[1:].sum() + trips * longest[0])) + 1.0


def _ways_to_insert(
    d: Floats, lots: Sequence[Sequence[int]], weights: Sequence[int]
) -> Iterator[tuple[list[int], bool]]:
    """Return sequences of the orders, and whether each goes onto the first trip with room."""
    heaviest_first = sorted(range(len(lots)), key=lambda o: -weights[o])
    yield heaviest_first, False
    yield heaviest_first, True
    # By rank, so that it does not matter how large a marker is.
    ranks = np.unique(d, return_inverse=True)[1].reshape(d.shape)
    badness = ranks.sum(axis=0) + ranks.sum(axis=1)
    worst = [int(badness[list(lot)].max()) for lot in lots]
    yield sorted(range(len(lots)), key=lambda o: (-worst[o], -weights[o])), False
    yield sorted(range(len(lots)), key=lambda o: (-weights[o], -worst[o])), False


def outlying(d: Floats, names: Sequence[str], limit: float) -> tuple[str, ...]:
    """Return a sentence for ways that mark something, and one for places that are far off.

    `names` are what the rows of `d` stand for; no useful way reaches `limit`.
    """
    found = []
    marked = np.isfinite(d) & (d > limit)
    if marked.any():
        i, j = divmod(int(np.where(marked, d, -1.0).argmax()), len(d))
        found.append(
            f"the way from {names[i]} to {names[j]} ({d[i, j]:g}) is longer than a whole plan"
            f"{_more(int(marked.sum()), 'ways are')}: no good plan takes it; if it stands for "
            "'no way', write null"
        )
    rows, usual = _far_off(d)
    if len(rows):
        far = int(rows[-1])
        found.append(
            f"{names[far]} lies {min(d[0, far], d[far, 0]):g} from the depot"
            f"{_more(len(rows), 'places are far off')}, all others within {usual:g}: is it in "
            "its right place?"
        )
    return tuple(found)


def _more(count: int, what: str) -> str:
    return f" (and {count - 1} more {what})" if count > 1 else ""


def _far_off(d: Floats) -> tuple[Rows, float]:
    """Return the rows that lie far off the depot, and how far the others reach.

    Far off is what lies beyond the first gap of `FAR` times, if that is the smaller part.
    """
    away = np.minimum(d[0], d[:, 0])
    order = np.argsort(away, kind="stable")
    reach = away[order]
    gaps = np.flatnonzero((reach[1:] > FAR * reach[:-1]) & (reach[:-1] > 0)) + 1
    gaps = gaps[(2 * gaps > len(d)) & np.isfinite(reach[gaps])]
    if not len(gaps):
        return order[:0], 0.0
    return order[gaps[0] :], float(reach[gaps[0] - 1])


def insert_orders(
    d: Floats,
    lots: Sequence[Sequence[int]],
    weights: Sequence[int],
    capacities: npt.NDArray[np.int64],
    orders: Sequence[int],
    *,
    first_fit: bool = False,
    passes: int = 0,
) -> Rows | None:
    """Return all trips in one row, zeros between them, or None when an order finds no room.

    Parameters
    ----------
    d
        Distances between depot (row 0) and stops, all finite.
    lots
        For each order its rows in `d`.
    weights, capacities
        Of the orders, and of each possible trip, largest first, in units.
    orders
        The sequence in which they are inserted.
    first_fit
        Onto the first trip with room, instead of the one where it costs least.
    passes
        How often at most every order is taken out and put back where it costs least.
    """
    sequence = np.zeros(len(capacities) + 1, dtype=np.intp)
    room = capacities.copy()
    for o in orders:
        longer = _inserted(d, sequence, room, lots[o], weights[o], first_fit=first_fit)
        if longer is None:
            return None
        sequence = longer
    best, least = sequence, float(d[sequence[:-1], sequence[1:]].sum())
    for _ in range(passes):
        before = least
        for o in orders:
            out = np.isin(sequence, lots[o])
            room[np.count_nonzero(sequence[: int(out.argmax())] == 0) - 1] += weights[o]
            again = _inserted(d, sequence[~out], room, lots[o], weights[o], first_fit=False)
            assert again is not None  # there is room where it was
            sequence = again
        length = float(d[sequence[:-1], sequence[1:]].sum())
        if length < least:
            best, least = sequence, length
        if least >= before:
            break
    return best


def _inserted(
    d: Floats,
    sequence: Rows,
    room: npt.NDArray[np.int64],
    lot: Sequence[int],
    weight: int,
    *,
    first_fit: bool,
) -> Rows | None:
    """Return the sequence with an order's stops where they cost least, None without room."""
    trip = np.cumsum(sequence == 0)[:-1] - 1
    fits = room[trip] >= weight
    if not fits.any():
        return None
    if first_fit:
        fits &= trip == trip[fits.argmax()]
    chosen = -1
    for stop in lot:
        a, b = sequence[:-1], sequence[1:]
        extra = np.where(fits, d[a, stop] + d[stop, b] - d[a, b], np.inf)
        at = int(extra.argmin())
        if chosen < 0:
            chosen = int(trip[at])
            room[chosen] -= weight
        sequence = np.insert(sequence, at + 1, stop)
        fits = np.cumsum(sequence == 0)[:-1] - 1 == chosen
    return sequence
