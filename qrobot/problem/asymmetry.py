"""What is unusual about a table of distances: allowed, but said in every result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from qrobot.problem.checks import MAX_LENGTH

__all__ = ["unreachable", "unusual"]


def unreachable(ways: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return the rows that no sequence of ways leads to from row 0, or from there back to it.

    Parameters
    ----------
    ways
        Whether a way leads directly from row i to row j, shape (n, n).
    """
    cut_off = np.zeros(len(ways), dtype=bool)
    for direct in (ways, ways.T):
        known = np.zeros(len(ways), dtype=bool)
        latest = np.zeros(len(ways), dtype=bool)
        latest[0] = True
        while latest.any():
            known |= latest
            latest = direct[latest].any(axis=0) & ~known
        cut_off |= ~known
    return np.flatnonzero(cut_off)


def unusual(
    d: npt.NDArray[np.float64], given: npt.NDArray[np.float64], names: Sequence[str]
) -> tuple[str, ...]:
    """Return a sentence each for forbidden ways, asymmetry and a broken triangle inequality.

    Parameters
    ----------
    d
        Distances, shape (n, n); ``inf`` where no way leads directly.
    given
        The same as the file has them: a number so large that it marks a missing way is in it.
    names
        What row and column i stand for.
    """
    found = []
    forbidden = np.isinf(d)
    if forbidden.any():
        i, j = divmod(int(np.argmax(forbidden)), len(d))
        count = int(forbidden.sum())
        found.append(
            f"no way leads directly from {names[i]} to {names[j]}"
            + (f", and {count - 1} more are missing" if count > 1 else "")
        )
        markers = given[forbidden & np.isfinite(given)]
        if markers.size:
            found.append(
                f"distances above {MAX_LENGTH:g}, such as {markers.max():g}, are taken as missing "
                f"ways ({markers.size} of them)"
            )
        d = np.where(forbidden, np.nan, d)
    apart = np.nan_to_num(np.abs(d - d.T))
    if (apart > 1e-9).any():
        i, j = divmod(int(np.argmax(apart)), len(d))
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
    # A way that is missing is neither too long nor a short cut.
    missing = np.isnan(d)
    ways, legs = np.where(missing, -np.inf, d), np.where(missing, np.inf, d)
    worst, where = 1e-9 * max(float(ways.max(initial=0.0)), 1.0), None
    # Every pivot of a large matrix would take minutes; a few hundred find any common fault.
    for k in range(0, len(d), 1 + len(d) // 400):
        gap = ways - (legs[:, k, None] + legs[None, k, :])
        if (top := float(gap.max())) > worst:
            i, j = divmod(int(gap.argmax()), len(d))
            worst, where = top, (i, k, j)
    return where
