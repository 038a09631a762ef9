"""Changes of an instance that published values exist for, by the name that an index gives them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, Place, Slot

__all__ = ["VARIANTS", "variant_of"]

MIDDLE_WIDTH = 1.0
"""Of the cross aisle that cuts a block in two, metres."""


def variant_of(instance: Instance, name: str) -> Instance:
    """Return an instance changed as a variant demands.

    Raises
    ------
    InputError
        When its warehouse is not one block of aisles, or cannot be changed so.
    """
    house = instance.warehouse
    if not isinstance(house, AisleWarehouse) or house.blocks != 1:
        raise InputError(
            f"the variant {name} is one of a single block of aisles",
            advice="leave the variant out, or choose other files by --match",
        )
    return VARIANTS[name](instance, house)


def _end_gap_1_5(instance: Instance, house: AisleWarehouse) -> Instance:
    """Let both end gaps be 1.5."""
    changed = dataclasses.replace(house, end_gap=1.5, block_gaps=())
    return dataclasses.replace(instance, warehouse=changed)


def _two_blocks(instance: Instance, house: AisleWarehouse) -> Instance:
    """Cut the block in two by a cross aisle between its two middle slots."""
    if house.slots % 2:
        raise InputError(
            f"an aisle of {house.slots} slots has no middle between two of them",
            advice="leave the variant out, or choose other files by --match",
        )
    half = house.slots // 2
    ((front, back),) = house.gaps
    middle = (house.slot_pitch + MIDDLE_WIDTH) / 2
    changed = dataclasses.replace(
        house,
        blocks=2,
        slots=half,
        block_gaps=((front, middle), (middle, back)),
        depot_cross_aisle=2 * house.depot_cross_aisle,
        closed_aisles=frozenset((a, b) for a, _ in house.closed_aisles for b in (0, 1)),
        closed_crossings=frozenset((2 * c, a) for c, a in house.closed_crossings),
        one_way_aisles=frozenset((a, b, t) for a, _, t in house.one_way_aisles for b in (0, 1)),
        one_way_crossings=frozenset((2 * c, a, t) for c, a, t in house.one_way_crossings),
    )

    def moved(place: Place) -> Place:
        assert isinstance(place, Slot)
        return dataclasses.replace(place, block=place.slot // half, slot=place.slot % half)

    items = tuple(dataclasses.replace(i, place=moved(i.place)) for i in instance.items)
    stock = tuple(dataclasses.replace(s, place=moved(s.place)) for s in instance.stock)
    return dataclasses.replace(instance, warehouse=changed, items=items, stock=stock)


VARIANTS: dict[str, Callable[[Instance, AisleWarehouse], Instance]] = {
    "two_blocks": _two_blocks,
    "end_gap_1_5": _end_gap_1_5,
}
