"""What is walked inside a sub-aisle, from point to point."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from qrobot._arrays import Floats
from qrobot.warehouse.states import VERTICAL, Vertical

__all__ = ["InAisle", "prices_inside", "walks_inside"]

InAisle = tuple[int, int, float]
"""(column, block, metres from the block's front)"""


def walks_inside(
    kind: Vertical, points: Sequence[float], ends: Collection[float] = ()
) -> list[int] | None:
    """Return how often each part of a sub-aisle is walked at least.

    Parameters
    ----------
    kind
        What the sub-aisle is.
    points
        Metres from its front of all places that must be passed, rising, each once.
    ends
        The points at which the tour starts or ends.

    Returns
    -------
    list of int or None
        From the front to the first point, from point to point, from the last to the back. None
        where the sub-aisle cannot be that.
    """
    odd = kind.front == 1
    walks = [2 - odd]
    for point in points:
        odd ^= sum(end == point for end in ends) % 2 == 1
        walks.append(2 - odd)
    if odd != (kind.back == 1):
        return None
    if kind.joined and (kind.front or kind.back):
        return walks
    if not points:
        return [0] if kind == (0, 0, False) else None
    if not kind.front and not kind.back and not (kind.joined and len(ends) == 2):
        return None
    if kind.front and kind.back:
        # The widest part that would be walked there and back is left out.
        inner = [i for i in range(1, len(points)) if walks[i] == 2]
        if not inner:
            return None
        walks[max(inner, key=lambda i: points[i] - points[i - 1])] = 0
    if not kind.front:
        walks[0] = 0
    if not kind.back:
        walks[-1] = 0
    return walks


def prices_inside(points: Sequence[float], length: float, ends: Collection[float]) -> Floats:
    """Return the metres of each of `VERTICAL` for a sub-aisle in which a tour starts or ends."""
    prices = np.full(len(VERTICAL), np.inf)
    if length == np.inf:
        return prices
    parts = np.diff([0.0, *points, length])
    for choice, kind in enumerate(VERTICAL):
        walks = walks_inside(kind, points, ends)
        if walks is not None:
            prices[choice] = parts @ walks
    return prices
