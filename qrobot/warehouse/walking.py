"""A picker on the way through a warehouse, who picks whatever is passed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist

from qrobot.problem import AisleWarehouse, Slot

__all__ = ["XY", "Route", "Walk", "corners", "length"]

XY = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Route:
    """A way from the depot past some slots and back.

    Parameters
    ----------
    length
        Metres, as walked by the rule; ``inf`` when a slot cannot be reached.
    sequence
        Indices of the slots as they are picked; empty when one cannot be reached.
    legs
        Corner points from the depot to the first pick, from each pick to the next, and from the
        last to the depot, metres.
    """

    length: float
    sequence: tuple[int, ...]
    legs: tuple[tuple[XY, ...], ...]


class Walk:
    """A picker on the way: seen from the depot's side of the warehouse, which is the front.

    Parameters
    ----------
    warehouse
        Open everywhere, the depot at its first or last cross aisle.
    slots
        What is to be picked.
    """

    def __init__(self, warehouse: AisleWarehouse, slots: Sequence[Slot]) -> None:
        self._house = warehouse
        self._flipped = warehouse.depot_cross_aisle > 0
        heights = warehouse.cross_aisle_heights
        self._depth = heights[-1]
        self.heights = [self._height(y) for y in heights]
        if self._flipped:
            self.heights.reverse()
        self._left: dict[tuple[int, int], list[tuple[float, int]]] = {}
        for i, slot in enumerate(slots):
            block = warehouse.blocks - 1 - slot.block if self._flipped else slot.block
            y = self._height(warehouse.position(slot)[1])
            self._left.setdefault((slot.aisle, block), []).append((y, i))
        self.picked = range(warehouse.blocks)
        """Blocks whose slots are picked when they are passed: one may lie on a cross aisle."""
        self.depot = self.aisle = warehouse.depot_aisle
        self.y = 0.0
        self._sequence: list[int] = []
        self._legs: list[list[XY]] = [[warehouse.depot]]
        self._mark()

    def picks(self, block: int) -> dict[int, list[float]]:
        """Return what is left to pick in a block: aisles from left to right, heights upwards."""
        left = sorted((a, spots) for (a, b), spots in self._left.items() if b == block and spots)
        return {aisle: sorted(y for y, _ in spots) for aisle, spots in left}

    def go(self, aisle: int, *heights: float) -> None:
        """Walk along the cross aisle to an aisle, then there to one height after the other."""
        self.aisle = aisle
        self._mark()
        for y in heights:
            self._pick(y)
            self.y = y
            self._mark()

    def home(self) -> Route:
        """Return to the depot: the way is done."""
        self.go(self.depot)
        self._legs[-1].append(self._house.depot)
        assert not any(self._left.values())
        legs = tuple(corners(leg) for leg in self._legs)
        return Route(length(legs), tuple(self._sequence), legs)

    def _height(self, y: float) -> float:
        return self._depth - y if self._flipped else y

    def _mark(self, y: float | None = None) -> None:
        height = self._height(self.y if y is None else y)
        self._legs[-1].append((self.aisle * self._house.aisle_pitch, height))

    def _pick(self, y: float) -> None:
        """Pick what lies between here and a height of the same aisle."""
        low, high = min(self.y, y), max(self.y, y)
        found = []
        for (aisle, block), spots in self._left.items():
            if aisle == self.aisle and block in self.picked:
                found += [spot for spot in spots if low <= spot[0] <= high]
                self._left[aisle, block] = [s for s in spots if not low <= s[0] <= high]
        for height, i in sorted(found, key=lambda spot: (abs(spot[0] - self.y), spot[1])):
            self._sequence.append(i)
            self._mark(height)
            self._legs.append([self._legs[-1][-1]])


def corners(points: Sequence[XY]) -> tuple[XY, ...]:
    """Return points without repetitions of their neighbours."""
    return tuple(p for p, after in pairwise([*points, None]) if p is not None and p != after)


def length(legs: Sequence[Sequence[XY]]) -> float:
    """Return the length of a way, metres."""
    return sum(dist(a, b) for leg in legs for a, b in pairwise(leg))
