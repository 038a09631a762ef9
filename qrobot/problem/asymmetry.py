"""What is unusual about a table of distances: allowed, but said in every result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

__all__ = ["unusual"]


def unusual(d: npt.NDArray[np.float64], names: Sequence[str]) -> tuple[str, ...]:
    """Return one sentence for asymmetry and one for a broken triangle inequality.

    Parameters
    ----------
    d
        Distances, shape (n, n).
    names
        What row and column i stand for.
    """
    found = []
    if not np.allclose(d, d.T, rtol=0, atol=1e-9):
        i, j = divmod(int(np.argmax(np.abs(d - d.T))), len(d))
        found.append(
            f"the distances are asymmetric: {names[i]} to {names[j]} is {d[i, j]:g}, "
            f"back {d[j, i]:g}"
        )
    if (gap := _triangle_gap(d)) is not None:
        i, k, j = gap
        found.append(
            "the distances violate the triangle inequality: "
            f"{names[i]} to {names[j]} is {d[i, j]:g}, but "
            f"{d[i, k] + d[k, j]:g} over {names[k]}"
        )
    return tuple(found)


def _triangle_gap(d: npt.NDArray[np.float64]) -> tuple[int, int, int] | None:
    """Return the worst (i, k, j) with d[i,k] + d[k,j] < d[i,j], or None."""
    worst, where = 1e-9 * max(float(d.max(initial=0.0)), 1.0), None
    # Every pivot of a large matrix would take minutes; a few hundred find any common fault.
    for k in range(0, len(d), 1 + len(d) // 400):
        gap = d - (d[:, k, None] + d[None, k, :])
        if (top := float(gap.max())) > worst:
            i, j = divmod(int(gap.argmax()), len(d))
            worst, where = top, (i, k, j)
    return where
