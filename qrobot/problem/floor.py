"""A floor without aisles, where the way is the metric."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.checks import check_coordinate
from qrobot.problem.places import Place, Point

__all__ = ["OpenFloor"]


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

    def __post_init__(self) -> None:
        """Check the depot."""
        check_coordinate(self.depot_x, "depot.x")
        check_coordinate(self.depot_y, "depot.y")

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
            raise InputError(f"{place} is not a coordinate", mend="an open floor needs x and y")
        check_coordinate(place.x, "x")
        check_coordinate(place.y, "y")

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return distances between depot and places.

        Returns
        -------
        numpy.ndarray
            Shape (n + 1, n + 1), metres; row 0 is the depot.
        """
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
