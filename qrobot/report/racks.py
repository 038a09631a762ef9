"""Where things stand in an aisle warehouse: racks, slots and what is closed, metres."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from qrobot.problem import AisleWarehouse, Slot

__all__ = ["Box", "Racks"]

Box = tuple[float, float, float, float]
"""Left, bottom, width and height."""

BESIDE = 0.6
"""Of half an aisle's width: where the arrow of a direction is."""


class Racks:
    """The floor of an aisle warehouse to scale.

    Parameters
    ----------
    house
        The layout.

    Attributes
    ----------
    aisle, cross
        Half widths of aisles and of cross aisles.
    slot
        Length of a slot along its aisle.
    depth
        Distance of the last cross aisle from the front one.
    """

    def __init__(self, house: AisleWarehouse) -> None:
        self.house = house
        pitch, slot = house.aisle_pitch, house.slot_pitch
        gap = min(min(pair) for pair in house.gaps)
        self.aisle = max(0.2 * pitch, pitch / 2 - 2 * max(slot, gap))
        self.cross = max(gap - slot / 2, min(0.5 * gap, 0.2 * pitch))
        self.slot = min(slot, 2 * gap) or slot
        self.depth = house.cross_aisle_heights[-1]

    @property
    def floor(self) -> Box:
        """The outline of the whole."""
        house = self.house
        return (
            -house.aisle_pitch / 2,
            -self.cross,
            house.aisles * house.aisle_pitch,
            self.depth + 2 * self.cross,
        )

    def slot_box(self, slot: Slot) -> Box:
        """Return the box of a slot."""
        x, y = self.house.position(slot)
        half = self.house.aisle_pitch / 2
        left = x - half if slot.side == "left" else x + self.aisle
        return left, y - self.slot / 2, half - self.aisle, self.slot

    def slots(self) -> Iterator[Box]:
        """Yield the boxes of all slots."""
        house = self.house
        for aisle, block, slot in product(
            range(house.aisles), range(house.blocks), range(house.slots)
        ):
            yield self.slot_box(Slot(aisle, slot, block, "left"))
            yield self.slot_box(Slot(aisle, slot, block, "right"))

    def racks(self) -> Iterator[Box]:
        """Yield each side of an aisle's block as one box."""
        for first, last in zip(self._slots(0), self._slots(self.house.slots - 1), strict=True):
            left, low, width, height = self.slot_box(first)
            yield left, low, width, self.slot_box(last)[1] + height - low

    def closed(self) -> Iterator[Box]:
        """Yield the parts of aisles and cross aisles that are closed."""
        house = self.house
        for aisle, block in sorted(house.closed_aisles):
            x, y = aisle * house.aisle_pitch, house.cross_aisle_heights[block]
            length = house.block_lengths[block] - 2 * self.cross
            yield x - self.aisle, y + self.cross, 2 * self.aisle, length
        for cross, aisle in sorted(house.closed_crossings):
            x, y = aisle * house.aisle_pitch, house.cross_aisle_heights[cross]
            length = house.aisle_pitch - 2 * self.aisle
            yield x + self.aisle, y - self.cross, length, 2 * self.cross

    def one_ways(self) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
        """Yield the ends of the arrows of one-way parts: where they begin and lead to.

        They are beside the middle, where the trips are drawn.
        """
        house = self.house
        for aisle, block, towards in sorted(house.one_way_aisles):
            x, ends = (
                aisle * house.aisle_pitch + BESIDE * self.aisle,
                house.cross_aisle_heights[block : block + 2],
            )
            low, high = ends[0] + self.cross, ends[1] - self.cross
            first, last = (low, high) if towards == "back" else (high, low)
            yield (x, first), (x, last)
        for cross, aisle, towards in sorted(house.one_way_crossings):
            y = house.cross_aisle_heights[cross] + BESIDE * self.cross
            left = aisle * house.aisle_pitch + self.aisle
            right = left + house.aisle_pitch - 2 * self.aisle
            first, last = (left, right) if towards == "right" else (right, left)
            yield (first, y), (last, y)

    def _slots(self, slot: int) -> Iterator[Slot]:
        """Yield the slots of one number in every block of every aisle, on both sides."""
        for aisle in range(self.house.aisles):
            for block in range(self.house.blocks):
                yield Slot(aisle, slot, block, "left")
                yield Slot(aisle, slot, block, "right")
