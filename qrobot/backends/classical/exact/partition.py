"""The best way to split everything over the robots, by dynamic programming.

A (min, +) subset convolution: the best split of a set over robots 1..k is the best split
of a part over robots 1..k-1 and the rest as one trip of robot k. All 3^n pairs (set, part)
are enumerated once and reused for every robot.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats

__all__ = ["MAX_ELEMENTS", "best_split"]

MAX_ELEMENTS = 13
"""3^13 = 1.6 million pairs; beyond it the set partition takes over."""

Rows = npt.NDArray[np.intp]


@lru_cache(maxsize=2)
def _pairs(n: int) -> tuple[Rows, Rows, Rows]:
    """Return for all sets their parts and rests, and where each set's run of pairs starts."""
    sets = np.zeros(1, dtype=np.uint16)
    parts = np.zeros(1, dtype=np.uint16)
    for i in range(n):
        bit = np.uint16(1 << i)
        sets = np.concatenate([sets, sets | bit, sets | bit])
        parts = np.concatenate([parts, parts, parts | bit])
    order = np.argsort(sets, kind="stable")
    sets, parts = sets[order], parts[order]
    starts = np.searchsorted(sets, np.arange(1 << n, dtype=np.uint16))
    return parts.astype(np.intp), (sets ^ parts).astype(np.intp), starts.astype(np.intp)


def best_split(trip_costs: list[Floats]) -> tuple[float, list[int], Floats]:
    """Split all elements over trips at the least total cost.

    Parameters
    ----------
    trip_costs
        For each possible trip the cost of every subset as its load, shape (2^n,), indexed
        by bit mask; ``inf`` where it does not fit, 0 for the empty set.

    Returns
    -------
    tuple
        The least cost (``inf`` when no split fits), the mask of each trip, and what every
        subset costs without the last trip.
    """
    size = len(trip_costs[0])
    n = size.bit_length() - 1
    if n > MAX_ELEMENTS:
        raise ValueError(f"{n} elements are more than {MAX_ELEMENTS}")
    parts, rests, starts = _pairs(n)
    best = [trip_costs[0]]
    for costs in trip_costs[1:]:
        best.append(np.minimum.reduceat(best[-1][parts] + costs[rests], starts))
    left = size - 1
    total = float(best[-1][left])
    if not np.isfinite(total):
        return total, [], best[max(len(best) - 2, 0)]
    masks = []
    for k in range(len(trip_costs) - 1, 0, -1):
        run = slice(starts[left], starts[left + 1] if left + 1 < size else None)
        taken = int(np.argmin(best[k - 1][parts[run]] + trip_costs[k][rests[run]]))
        masks.append(int(rests[run][taken]))
        left = int(parts[run][taken])
    masks.append(left)
    return total, [m for m in masks if m], best[max(len(best) - 2, 0)]
