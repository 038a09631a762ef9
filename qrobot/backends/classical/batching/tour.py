"""Shorten one tour: 2-opt and or-opt moves, all evaluated at once with numpy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats

__all__ = ["improve_tour", "tour_length"]


MIN_GAIN = 1e-12
"""Relative to the tour: smaller gains are rounding."""

WINDOW = 120
"""Nodes that are looked at together."""


def tour_length(distances: Floats, tour: list[int]) -> float:
    """Return the length of the way from node 0 past the tour's nodes and back."""
    if not tour:
        return 0.0
    nodes = np.array([0, *tour, 0], dtype=np.intp)
    return float(distances[nodes[:-1], nodes[1:]].sum())


def improve_tour(
    distances: Floats, tour: list[int], stop: Callable[[], bool] = lambda: False
) -> list[int]:
    """Apply 2-opt and or-opt moves, the best first, until none shortens the tour.

    Parameters
    ----------
    distances
        Shape (n + 1, n + 1), node 0 is the depot; may be asymmetric.
    tour
        Nodes in sequence, without the depot.
    stop
        Asked before every move.

    Returns
    -------
    list
        The same nodes, never longer (Croes 1958; Or 1976: segments of 1 to 3 stops, both
        ways round). Tours of more than `WINDOW` stops are improved in overlapping windows,
        because every move looks at all pairs.
    """
    nodes = np.array([0, *tour, 0], dtype=np.intp)
    for first in range(0, max(1, len(nodes) - WINDOW // 2), WINDOW // 2):
        window = slice(first, first + WINDOW)
        nodes[window] = _improve_path(distances, nodes[window], stop)
    return [int(v) for v in nodes[1:-1]]


def _improve_path(
    distances: Floats, nodes: npt.NDArray[np.intp], stop: Callable[[], bool]
) -> npt.NDArray[np.intp]:
    """Shorten the way along some nodes; the first and the last stay where they are."""
    if len(nodes) < 4:
        return nodes
    least = MIN_GAIN * max(float(distances[nodes[:-1], nodes[1:]].sum()), 1e-300)
    while not stop():
        d = distances[np.ix_(nodes, nodes)]
        gain, moved = _best_reversal(d)
        for length in range(1, min(3, len(nodes) - 3) + 1):
            shift_gain, shifted = _best_shift(d, length)
            if shift_gain < gain - least:
                gain, moved = shift_gain, shifted
        if gain >= -least:
            break
        nodes = nodes[moved]
    return nodes


def _best_reversal(d: Floats) -> tuple[float, npt.NDArray[np.intp]]:
    """Return the best change by reversing positions i..j, and the new sequence."""
    last = len(d) - 1
    forward = np.concatenate([[0.0], np.cumsum(np.diagonal(d, 1))])
    backward = np.concatenate([[0.0], np.cumsum(np.diagonal(d, -1))])
    i = np.arange(1, last)[:, None]
    j = np.arange(1, last)[None, :]
    change = (
        d[:-2, 1:-1]  # i - 1 to j
        + d[1:-1, 2:]  # i to j + 1
        + (backward[1:-1][None, :] - backward[1:-1][:, None])
        - (forward[2:][None, :] - forward[:-2][:, None])
    )
    change = np.where(i < j, change, np.inf)
    best = int(np.argmin(change))
    a, b = best // (last - 1) + 1, best % (last - 1) + 1
    sequence = np.arange(last + 1)
    sequence[a : b + 1] = sequence[a : b + 1][::-1]
    return float(change.flat[best]), sequence


def _best_shift(d: Floats, length: int) -> tuple[float, npt.NDArray[np.intp]]:
    """Return the best change by moving `length` stops elsewhere, and the new sequence."""
    last = len(d) - 1
    starts = np.arange(1, last - length + 1)
    ends = starts + length - 1
    edges = np.arange(last)  # the edge k runs from position k to k + 1
    removed = d[starts - 1, ends + 1] - d[starts - 1, starts] - d[ends, ends + 1]
    gap = np.diagonal(d, 1)[None, :]
    ahead = d[edges][:, starts].T + d[ends][:, edges + 1] - gap
    forward = np.concatenate([[0.0], np.cumsum(np.diagonal(d, 1))])
    backward = np.concatenate([[0.0], np.cumsum(np.diagonal(d, -1))])
    turn = (backward[ends] - backward[starts]) - (forward[ends] - forward[starts])
    turned = d[edges][:, ends].T + d[starts][:, edges + 1] - gap + turn[:, None]
    inside = (edges[None, :] >= starts[:, None] - 1) & (edges[None, :] <= ends[:, None])
    change = np.where(inside, np.inf, np.minimum(ahead, turned) + removed[:, None])
    best = int(np.argmin(change))
    s, k = best // last, best % last
    piece = np.arange(starts[s], ends[s] + 1)
    if turned[s, k] < ahead[s, k]:
        piece = piece[::-1]
    rest = np.concatenate([np.arange(starts[s]), np.arange(ends[s] + 1, last + 1)])
    at = int(np.searchsorted(rest, k)) + 1
    return float(change.flat[best]), np.concatenate([rest[:at], piece, rest[at:]])
