"""A plan in no time: every order where it costs least, one after the other.

Rosenkrantz, Stearns and Lewis (1977) for one tour; here for all trips at once, each with its
room. Searches improve on it; its length already says which ways are too long to be useful.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats

__all__ = ["insert_orders"]

Rows = npt.NDArray[np.intp]


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
        Of the orders, and of each possible trip, in units.
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
