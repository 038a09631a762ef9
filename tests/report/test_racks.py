"""Where racks stand: every slot inside its block, whatever the gaps at the ends of the blocks."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import question
from strategies import aisle_warehouses

from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Slot
from qrobot.report.racks import Racks
from qrobot.report.scene import scene_of

SMALL = 1e-9


@st.composite
def houses(draw: st.DrawFn) -> AisleWarehouse:
    """Draw a layout, sometimes with gaps of their own for each block."""
    house = draw(aisle_warehouses(closed=True))
    gaps = st.tuples(*[st.sampled_from([0.5, 1.0, 2.5])] * 2)
    pairs = draw(st.lists(gaps, min_size=house.blocks, max_size=house.blocks))
    return AisleWarehouse(
        aisles=house.aisles, slots=house.slots, blocks=house.blocks,
        aisle_pitch=house.aisle_pitch, slot_pitch=house.slot_pitch, end_gap=house.end_gap,
        closed_aisles=house.closed_aisles, closed_crossings=house.closed_crossings,
        block_gaps=draw(st.sampled_from([(), tuple(pairs)])),
    )  # fmt: skip


@given(houses())
def test_every_slot_lies_in_its_block_and_on_the_floor(house: AisleWarehouse) -> None:
    racks = Racks(house)
    left, low, width, height = racks.floor
    heights = [0.0]
    for front, back in house.block_gaps or [(house.end_gap, house.end_gap)] * house.blocks:
        heights.append(heights[-1] + front + (house.slots - 1) * house.slot_pitch + back)
    assert racks.depth == pytest.approx(heights[-1])
    for block, (start, end) in enumerate(pairwise(heights)):
        for slot in (0, house.slots - 1):
            for side in ("left", "right"):
                x, y, w, h = racks.slot_box(Slot(house.aisles - 1, slot, block, side))  # type: ignore[arg-type]
                assert start - SMALL <= y
                assert y + h <= end + SMALL
                assert left - SMALL <= x
                assert x + w <= left + width + SMALL
                assert w > 0 < h
    boxes = [*racks.slots(), *racks.racks(), *racks.closed()]
    assert len(boxes) == 2 * house.aisles * house.blocks * (house.slots + 1) + len(
        house.closed_aisles
    ) + len(house.closed_crossings)
    assert all(low - SMALL <= y and y + h <= low + height + SMALL for _, y, _, h in boxes)


def test_a_way_to_another_aisle_of_the_depot_is_drawn_along_aisles() -> None:
    house = AisleWarehouse(aisles=3, slots=4, depot_distance=2.0, depot_ways=((2, 7.0),))
    one = question(house, [Slot(2, 1)], robots=1)
    (journey,) = scene_of(Plan.from_routes(one, [[1]]), one).journeys
    out, back = journey.legs
    assert out[:2] == ((0.0, -2.0), (6.0, -2.0))
    assert out[-1] == (6.0, 2.0)
    assert back == out[::-1]
    assert all(a[0] == b[0] or a[1] == b[1] for a, b in pairwise(out))
