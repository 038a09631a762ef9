"""A floor without aisles, where the way is the metric."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.checks import check_coordinate
from qrobot.problem.warehouse import Place, Point

__all__ = ["OpenFloor", "coarse"]


SMALL = 10.0
"""Largest distances below this lose a twentieth or more to whole numbers."""


@dataclass(frozen=True, slots=True)
class OpenFloor:
    """A floor without aisles: places are coordinates.

    Parameters
    ----------
    depot_x, depot_y
        The depot, metres.
    metric
        ``euclidean`` (as the crow flies) or ``manhattan``.
    rounding
        ``nearest`` rounds every distance to the nearest integer, halves up, as TSPLIB's
        EUC_2D demands; ``none`` keeps it.
    """

    depot_x: float = 0.0
    depot_y: float = 0.0
    metric: Literal["euclidean", "manhattan"] = "euclidean"
    rounding: Literal["none", "nearest"] = "none"
    kind: Literal["floor"] = "floor"

    has_given_distances: ClassVar = False
    way_out: ClassVar = ""

    def __post_init__(self) -> None:
        check_coordinate(self.depot_x, "depot.x")
        check_coordinate(self.depot_y, "depot.y")

    @property
    def is_metric(self) -> bool:
        """Whether the triangle inequality holds: rounding may break it."""
        return self.rounding == "none"

    @property
    def unit(self) -> str:
        """Unit of its distances: rounded ones are a benchmark's, which has none."""
        return "m" if self.rounding == "none" else ""

    @property
    def depot(self) -> tuple[float, float]:
        """Where the depot is drawn, metres."""
        return self.depot_x, self.depot_y

    def position(self, place: Place) -> tuple[float, float]:
        """Return the coordinates of a place, metres."""
        assert isinstance(place, Point)
        return place.x, place.y

    def check(self, place: Place) -> None:
        """Raise `InputError` when a place is not a coordinate."""
        if not isinstance(place, Point):
            raise InputError(f"{place} is not a coordinate", advice="an open floor needs x and y")
        check_coordinate(place.x, "x")
        check_coordinate(place.y, "y")

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return the distances between depot (row 0) and places, metres."""
        xy = np.array([self.depot, *(self.position(p) for p in places)], dtype=np.float64)
        steps = np.abs(xy[:, None, :] - xy[None, :, :])
        if self.metric == "manhattan":
            matrix = steps.sum(axis=2)
        else:
            matrix = np.hypot(steps[..., 0], steps[..., 1])
        if self.rounding == "nearest":
            matrix = np.floor(matrix + 0.5)
        return np.asarray(matrix, dtype=np.float64)

    def way(self, start: Place | None, end: Place | None) -> list[tuple[float, float]]:
        """Return the corner points of a way; ``None`` stands for the depot."""
        a = self.depot if start is None else self.position(start)
        b = self.depot if end is None else self.position(end)
        if self.metric == "manhattan" and a[0] != b[0] and a[1] != b[1]:
            return [a, (b[0], a[1]), b]
        return [a, b]

    def notes(
        self, distances: Floats, places: Sequence[Place], _names: Sequence[str]
    ) -> tuple[str, ...]:
        """Return what is unusual about the distances: rounding may leave them coarse."""
        if self.rounding == "none":
            return ()
        exact = replace(self, rounding="none")
        rule = "EUC_2D" if self.metric == "euclidean" else "MAN_2D"
        return coarse(distances, lambda: exact.distance_matrix(places), rule)


def coarse(rounded: Floats, lengths: Callable[[], Floats], rule: str) -> tuple[str, ...]:
    """Return a note when distances are so small that whole numbers hide most of them.

    `lengths` gives them without rounding, `rule` is the one of TSPLIB's that rounded them.
    """
    largest = float(rounded.max(initial=0.0))
    if largest >= SMALL or np.array_equal(rounded, lengths()):
        return ()
    return (
        f"distances are rounded to whole numbers as {rule} demands; the largest is {largest:g} "
        "(rounding none leaves them as they are)",
    )
