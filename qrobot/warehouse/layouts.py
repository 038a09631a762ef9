"""A layout, and the places that orders need, as the compiled kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.grid import grid_of
from qrobot.warehouse.sweep import Numbers, flatten

__all__ = [
    "AISLE_BY_AISLE",
    "CODES",
    "COMBINED",
    "EVEN",
    "LARGEST_GAP",
    "MIDPOINT",
    "RETURN",
    "SHORTEST",
    "S_SHAPE",
    "Layout",
    "Words",
    "masks_of",
]

Words = npt.NDArray[np.uint64]
"""Shape (sub-aisles, words of a sub-aisle)."""

SHORTEST, RETURN, S_SHAPE, MIDPOINT, LARGEST_GAP, COMBINED, AISLE_BY_AISLE = range(7)

CODES = {
    "exact": SHORTEST,
    "return": RETURN,
    "s-shape": S_SHAPE,
    "midpoint": MIDPOINT,
    "largest-gap": LARGEST_GAP,
    "combined": COMBINED,
    "aisle-by-aisle": AISLE_BY_AISLE,
}
"""What tours are walked by."""

EVEN = 1e-9
"""Lengths that differ by less than this share of an aisle are the same: that is rounding."""


class Layout(NamedTuple):
    """A grid, and the places that orders need, as kernels take them.

    Parameters
    ----------
    along
        Shape (columns, blocks).
    across
        Shape (columns, cross aisles), the last row ``inf``.
    doors
        Shape (doors, 2): column and cross aisle of each crossing that the depot has a way to.
    ways
        Shape (doors,): metres of the way to it.
    is_open
        Whether nothing is closed.
    bases, pitch
        Metres from the front of each block to its first slot, and from slot to slot.
    ends, steps, starts, marks
        The states of the sweep: begin and done, and as in `sweep.Flat`.
    states
        Number of states.
    policy
        By which rule tours are walked; `SHORTEST` by none.
    grows
        Whether no tour gets shorter by another pick: not so for rules that go from block to block.
    """

    along: Floats
    across: Floats
    doors: Numbers
    ways: Floats
    is_open: bool
    bases: Floats
    pitch: float
    ends: tuple[int, int]
    steps: Numbers
    starts: Numbers
    marks: Numbers
    states: int
    policy: int
    grows: bool


def masks_of(
    warehouse: AisleWarehouse, picks: Sequence[Sequence[Slot]], policy: int = SHORTEST
) -> tuple[Layout, npt.NDArray[np.uint64]]:
    """Return a layout, and the words of several lists of picks.

    Parameters
    ----------
    warehouse
        At most six cross aisles.
    picks
        The slots of each order.
    policy
        By which rule tours are walked, one of `CODES`.

    Returns
    -------
    tuple
        The layout, and an array of shape (orders, sub-aisles, words).
    """
    grid = grid_of(warehouse)
    flat = flatten(grid.cross_aisles, grid.ends)
    words = -(-warehouse.slots // 64)
    masks = np.zeros((len(picks), grid.along.size, words), dtype=np.uint64)
    for order, slots in enumerate(picks):
        for slot in slots:
            part = slot.aisle * warehouse.blocks + slot.block
            masks[order, part, slot.slot // 64] |= np.uint64(1 << slot.slot % 64)
    across = np.full((len(grid.along), grid.cross_aisles), np.inf)
    across[:-1] = grid.across
    return Layout(
        along=grid.along,
        across=across,
        doors=np.array([(door.column, door.cross) for door in grid.doors], dtype=np.int64),
        ways=np.array([door.length for door in grid.doors]),
        is_open=grid.is_open,
        bases=np.array([front for front, _ in warehouse.gaps]),
        pitch=float(warehouse.slot_pitch),
        ends=(flat.begin, flat.done),
        steps=flat.steps,
        starts=flat.starts,
        marks=flat.marks,
        states=flat.count,
        policy=policy,
        grows=warehouse.blocks == 1 or policy in (SHORTEST, AISLE_BY_AISLE),
    ), masks
