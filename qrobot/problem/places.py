"""Where an item can lie: in a slot, at a coordinate, or at a row of a distance table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["Node", "Place", "Point", "Slot"]


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


Place = Slot | Point | Node
