"""Shortest trees over the rows of a matrix of distances."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats

__all__ = ["spanning_tree"]

BETWEEN_LOOKS = 50
"""Edges of a tree between looks at the clock."""


def spanning_tree(
    weights: Floats, stop: Callable[[], bool] | None = None
) -> tuple[npt.NDArray[np.intp], Floats] | None:
    """Return the edges (n - 1, 2) and lengths of a minimum spanning tree (Prim 1957).

    Parameters
    ----------
    weights
        Symmetric, shape (n, n), n at least 1.
    stop
        Asked now and then, for the trees of large matrices take long; then there is None.
    """
    n = len(weights)
    reach = weights[0].copy()
    via = np.zeros(n, dtype=np.intp)
    outside = np.ones(n, dtype=bool)
    outside[0] = False
    ends = np.empty((n - 1, 2), dtype=np.intp)
    lengths = np.empty(n - 1)
    for edge in range(n - 1):
        if stop is not None and edge % BETWEEN_LOOKS == 0 and stop():
            return None
        v = int(np.where(outside, reach, np.inf).argmin())
        ends[edge] = via[v], v
        lengths[edge] = reach[v]
        outside[v] = False
        nearer = weights[v] < reach
        reach = np.where(nearer, weights[v], reach)
        via = np.where(nearer, v, via)
    return ends, lengths
