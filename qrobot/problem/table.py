"""A table of measured distances, for any building; what is unusual about one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.checks import MAX_LENGTH, check_coordinate, check_index
from qrobot.problem.warehouse import Node, Place

__all__ = ["DistanceTable", "unreachable", "unusual"]

PIVOTED = 2e8
"""Ways that are compared with one over another place: tenths of a second."""

BLOCK = 2**16
"""Of them at a time, so that they stay in the processor's cache."""


@dataclass(frozen=True, slots=True)
class DistanceTable:
    """An explicit distance matrix, for any building whose ways were measured.

    Parameters
    ----------
    matrix
        Square rows of distances; asymmetric ones are allowed, ``inf`` where no way leads
        directly. A larger one than `MAX_LENGTH` marks a missing way, too. The diagonal is not used,
        whatever it holds.
    depot_node
        The row of the depot.
    positions
        Coordinates to draw each row at, when they are known.
    """

    matrix: tuple[tuple[float, ...], ...]
    depot_node: int = 0
    positions: tuple[tuple[float, float], ...] | None = None
    kind: Literal["matrix"] = "matrix"

    is_metric: ClassVar = False
    has_given_distances: ClassVar = True
    unit: ClassVar = ""
    way_out: ClassVar = "fill in their distances"

    def __repr__(self) -> str:
        return f"<DistanceTable of {len(self.matrix)} rows, depot {self.depot_node}>"

    def __post_init__(self) -> None:
        size = len(self.matrix)
        if not size:
            raise InputError("is empty", field="matrix", advice="give at least the depot's row")
        for i, row in enumerate(self.matrix):
            if len(row) != size:
                raise InputError(
                    f"has {len(row)} entries where the matrix has {size} rows",
                    field=f"matrix[{i}]",
                    advice="make the matrix square",
                )
        values = np.asarray(self.matrix, dtype=np.float64)
        bad = ~(values >= 0)  # NaN too
        np.fill_diagonal(bad, False)
        for i, j in np.argwhere(bad)[:1].tolist():
            raise InputError(
                f"{values[i, j]:g} is not 0 or more",
                field=f"matrix[{i}][{j}]",
                advice="correct the distance",
            )
        check_index(self.depot_node, "depot_node", count=size)
        if self.positions is not None and len(self.positions) != size:
            raise InputError(
                f"{len(self.positions)} positions for {size} rows",
                field="positions",
                advice="give each row one position, or leave the positions out",
            )
        for i, (x, y) in enumerate(self.positions or ()):
            check_coordinate(x, f"positions[{i}].x")
            check_coordinate(y, f"positions[{i}].y")

    @property
    def depot(self) -> tuple[float, float]:
        """Where the depot is drawn."""
        return self.position(Node(self.depot_node))

    def position(self, place: Place) -> tuple[float, float]:
        """Return where a row is drawn: on a circle when no coordinates are known."""
        assert isinstance(place, Node)
        if self.positions is not None:
            return self.positions[place.index]
        if place.index == self.depot_node:
            return 0.0, 0.0
        angle = 2 * np.pi * place.index / len(self.matrix)
        return float(np.cos(angle)), float(np.sin(angle))

    def check(self, place: Place) -> None:
        """Raise `InputError` when a place is not a row of the matrix."""
        if not isinstance(place, Node):
            raise InputError(f"{place} is not a row", advice="a distance matrix needs node")
        if not 0 <= place.index < len(self.matrix):
            raise InputError(
                f"node {place.index} is outside the matrix",
                field="node",
                advice=f"use 0 to {len(self.matrix) - 1}, or add rows",
            )

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return the rows and columns of the places, the depot first; ``inf`` without a way."""
        matrix = self.given_distances(places)
        matrix[matrix > MAX_LENGTH] = np.inf
        return matrix

    def given_distances(self, places: Sequence[Place]) -> Floats:
        """Return the same as `distance_matrix`, with markers of missing ways as they were given."""
        rows = [self.depot_node, *(p.index for p in places if isinstance(p, Node))]
        matrix = np.array(self.matrix, dtype=np.float64)
        np.fill_diagonal(matrix, 0.0)
        return np.asarray(matrix[np.ix_(rows, rows)])

    def way(self, start: Place | None, end: Place | None) -> list[tuple[float, float]]:
        """Return the corner points of a way; ``None`` stands for the depot."""
        return [
            self.depot if start is None else self.position(start),
            self.depot if end is None else self.position(end),
        ]

    def notes(
        self, distances: Floats, places: Sequence[Place], names: Sequence[str]
    ) -> tuple[str, ...]:
        """Return what is unusual about the distances."""
        return unusual(distances, self.given_distances(places), names)


def unreachable(ways: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return the rows that no direct ways, one after the other, join with row 0, there and back."""
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

    `d` is ``inf`` where no way leads directly, `given` is what the file has there, which may be
    a number so large that it marks a missing way; `names` are what rows stand for.
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
    # Every pivot of a large matrix would take minutes; some find any common fault.
    pivots = range(0, len(d), -(-len(d) // max(1, int(PIVOTED / max(1, ways.size)))))
    rows = max(1, BLOCK // max(1, len(d)))
    for first in range(0, len(d), rows):
        part = slice(first, first + rows)
        gap = np.empty_like(ways[part])
        for k in pivots:
            np.add(legs[part, k, None], legs[k], out=gap)
            np.subtract(ways[part], gap, out=gap)
            if (top := float(gap.max())) > worst:
                i, j = divmod(int(gap.argmax()), len(d))
                worst, where = top, (first + i, k, j)
    return where
