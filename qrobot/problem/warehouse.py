"""What a warehouse is, and where an item can lie in one.

The kinds stand in files of their own: `AisleWarehouse` (`aisles`), `OpenFloor` (`floor`),
`DistanceTable` (`table`), `FloorMap` (`floor_map`) and `LaneNetwork` (`lane_network`). All
lengths of one warehouse are in one unit, metres by convention.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from qrobot._arrays import Floats
from qrobot.problem.checks import canonical

__all__ = ["Node", "Place", "Point", "Pose", "Slot", "Warehouse"]


@dataclass(frozen=True, slots=True)
class Slot:
    """A storage slot of an aisle warehouse; all numbers count from 0.

    Parameters
    ----------
    aisle
        Aisle, from the left.
    slot
        Slot inside the sub-aisle, from the front (the side of cross aisle 0).
    block
        Block, from the front.
    side
        Side of the aisle, for pictures: the picker reaches both sides from the middle.
    """

    aisle: int
    slot: int
    block: int = 0
    side: Literal["left", "right"] = "left"

    def __str__(self) -> str:
        """Name the place as errors do."""
        return f"slot {self.slot} of aisle {self.aisle}, block {self.block}"


@dataclass(frozen=True, slots=True)
class Point:
    """A free coordinate in metres."""

    x: float
    y: float

    def __str__(self) -> str:
        """Name the place as errors do."""
        return f"coordinate ({self.x:g}, {self.y:g})"


@dataclass(frozen=True, slots=True)
class Node:
    """A row of a distance table, from 0."""

    index: int

    def __str__(self) -> str:
        """Name the place as errors do."""
        return f"node {self.index}"


@dataclass(frozen=True, slots=True)
class Pose:
    """A place that a map has a name for."""

    name: str

    def __post_init__(self) -> None:
        """Keep the name's composed form."""
        object.__setattr__(self, "name", canonical(self.name))

    def __str__(self) -> str:
        """Name the place as errors do."""
        return f"pose {self.name!r}"


Place = Slot | Point | Node | Pose


class Warehouse(Protocol):
    """What the rest of the package asks a warehouse: nothing there asks which kind it is."""

    @property
    def kind(self) -> str:
        """The name of its kind, as in files."""

    @property
    def depot(self) -> tuple[float, float]:
        """Where the depot is drawn."""

    @property
    def is_metric(self) -> bool:
        """Whether the layout itself makes every way at most as long as one with a detour."""

    @property
    def has_given_distances(self) -> bool:
        """Whether people typed its distances in: some may be missing, or mark a missing way."""

    @property
    def unit(self) -> str:
        """Unit of its distances, empty when it is not known."""

    @property
    def way_out(self) -> str:
        """What to do beside moving the items when nothing leads to them; may be empty."""

    def check(self, place: Place) -> None:
        """Raise `InputError` when a place is not one of this warehouse."""

    def position(self, place: Place) -> tuple[float, float]:
        """Return where a place is drawn."""

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return the distances between depot (row 0) and n places, shape (n + 1, n + 1).

        ``inf`` where no way leads directly.
        """

    def way(self, start: Place | None, end: Place | None) -> list[tuple[float, float]]:
        """Return the corner points of a way; ``None`` stands for the depot."""

    def notes(
        self, distances: Floats, places: Sequence[Place], names: Sequence[str], /
    ) -> tuple[str, ...]:
        """Return what is unusual about these distances, a sentence each.

        Parameters
        ----------
        distances
            The `distance_matrix` of the places.
        places
            n places.
        names
            What its n + 1 rows stand for.
        """
