"""All sets that fit on one robot, and the shortest tour of each.

Held and Karp (1962) over the subsets whose load a robot can carry: with tight capacity
these are a tiny part of all subsets (25,000 of a million for QOBLIB's n = 20).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Ints

__all__ = ["Tours", "count_subsets", "fitting_subsets", "shortest_tours"]


def count_subsets(weights: Sequence[int], capacity: int, limit: int) -> int:
    """Return how many non-empty subsets weigh at most `capacity`, or `limit` if more.

    Parameters
    ----------
    weights
        Whole weights, shape (n,).
    capacity
        Largest load.
    limit
        Counting ends here.
    """
    counts: dict[int, int] = {0: 1}
    total = 1
    for w in sorted(weights, reverse=True):
        grown = dict(counts)
        for load, many in counts.items():
            if load + w <= capacity:
                grown[load + w] = grown.get(load + w, 0) + many
        counts = grown
        total = sum(counts.values())
        if total > limit:
            return limit
    return total - 1


def fitting_subsets(weights: Sequence[int], capacity: int) -> tuple[Ints, Ints]:
    """Return every non-empty subset of weight at most `capacity`, smallest sets first.

    Parameters
    ----------
    weights
        Whole weights, shape (n,), n <= 56.
    capacity
        Largest load.

    Returns
    -------
    tuple
        Bit masks (bit i is element i) and loads, both of shape (N,); sorted by the number
        of elements, then by mask.
    """
    masks = np.zeros(1, dtype=np.int64)
    loads = np.zeros(1, dtype=np.int64)
    for i, w in enumerate(weights):
        fits = loads + w <= capacity
        masks = np.concatenate([masks, masks[fits] | (1 << i)])
        loads = np.concatenate([loads, loads[fits] + w])
    order = np.lexsort((masks, np.bitwise_count(masks)))[1:]
    return masks[order], loads[order]


@dataclass(frozen=True, slots=True)
class Tours:
    """The shortest tour of every subset.

    Parameters
    ----------
    masks
        Subsets of n elements, shape (N,).
    lengths
        Length of the shortest tour from the depot past all elements and back, shape (N,).
    """

    masks: Ints
    lengths: npt.NDArray[np.float64]
    _keys: Ints
    _paths: npt.NDArray[np.float64]
    _distances: npt.NDArray[np.float64]

    def stops(self, row: int) -> list[int]:
        """Return the elements of a subset in the sequence of its shortest tour."""
        d, mask = self._distances, int(self.masks[row])
        last = int(np.argmin(self._paths[row] + d[1:, 0]))
        found = [last]
        while mask := mask ^ (1 << last):
            row = self.row(mask)
            last = int(np.argmin(self._paths[row] + d[1:, last + 1]))
            found.append(last)
        return found[::-1]

    def row(self, mask: int) -> int:
        """Return the row of a subset."""
        return int(self.rows(np.array([mask], dtype=np.int64))[0])

    def rows(self, masks: Ints) -> npt.NDArray[np.intp]:
        """Return the rows of subsets, shape as `masks`."""
        return np.searchsorted(self._keys, _key(masks))


def shortest_tours(
    masks: Ints,
    distances: npt.NDArray[np.float64],
    stop: Callable[[], bool] | None = None,
) -> Tours | None:
    """Run the dynamic programme of Held and Karp over a family of subsets.

    Parameters
    ----------
    masks
        Subsets, sorted as `fitting_subsets` gives them; closed under taking parts.
    distances
        Shape (n + 1, n + 1), the depot first; may be asymmetric.
    stop
        Asked once a layer and element.

    Returns
    -------
    Tours or None
        ``None`` when stopped before the end. Memory: N * n * 8 bytes.
    """
    n = len(distances) - 1
    paths = np.full((len(masks), n), np.inf)
    keys = _key(masks)
    sizes = np.bitwise_count(masks)
    starts = np.searchsorted(sizes, np.arange(1, (sizes[-1] if len(sizes) else 0) + 2))
    for size in range(1, len(starts)):
        low, high = int(starts[size - 1]), int(starts[size])
        layer = masks[low:high]
        for j in range(n):
            if stop is not None and stop():
                return None
            here = np.flatnonzero(layer & (1 << j))
            if size == 1:
                paths[low + here, j] = distances[0, j + 1]
                continue
            before = np.searchsorted(keys, _key(layer[here] ^ (1 << j)))
            paths[low + here, j] = (paths[before] + distances[1:, j + 1]).min(axis=1)
    lengths = (paths + distances[1:, 0]).min(axis=1) if n else np.zeros(len(masks))
    return Tours(masks, lengths, keys, paths, distances)


def _key(masks: Ints) -> npt.NDArray[np.int64]:
    # Size in the top bits keeps the family's order; so families have at most 56 elements.
    return (np.bitwise_count(masks).astype(np.int64) << 56) | masks
