"""An aisle warehouse in numbers: columns of crossings, and where its slots hang.

The sweep goes over columns: each aisle is one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.one_way import refuse_one_way
from qrobot.warehouse.states import PLAIN
from qrobot.warehouse.sweep import Door, Ends

__all__ = ["Grid", "grid_of", "part_costs", "positions_of"]


@dataclass(frozen=True, slots=True)
class Grid:
    """Columns of crossings.

    Parameters
    ----------
    across
        Shape (columns - 1, cross aisles): metres from a crossing to that of the next column;
        ``inf`` where the segment is closed.
    along
        Shape (columns, blocks): length of each sub-aisle; ``inf`` where it is closed.
    doors
        The crossings that ways lead to from the depot.
    """

    across: Floats
    along: Floats
    doors: tuple[Door, ...]

    @property
    def cross_aisles(self) -> int:
        """Number of cross aisles."""
        return int(self.along.shape[1]) + 1

    @property
    def ends(self) -> Ends:
        """How tours leave the depot."""
        return Ends.DOOR if len(self.doors) == 1 else Ends.DOORS

    @property
    def is_open(self) -> bool:
        """Whether nothing is closed, so that a tour never leaves the columns between its ends."""
        return bool(np.isfinite(self.across).all() and np.isfinite(self.along).all())


def grid_of(warehouse: AisleWarehouse) -> Grid:
    """Return the columns of a layout without one-way aisles."""
    refuse_one_way(warehouse, "the sweep over aisles")
    across = np.full((warehouse.aisles - 1, warehouse.blocks + 1), float(warehouse.aisle_pitch))
    along = np.tile(np.array(warehouse.block_lengths), (warehouse.aisles, 1))
    for cross, aisle in warehouse.closed_crossings:
        across[aisle, cross] = np.inf
    for aisle, block in warehouse.closed_aisles:
        along[aisle, block] = np.inf
    return Grid(
        across=across,
        along=along,
        doors=tuple(Door(*crossing, float(length)) for crossing, length in warehouse.doors),
    )


def part_costs(grid: Grid, parts: npt.NDArray[np.intp], offsets: Floats) -> Floats:
    """Return what each choice for each sub-aisle costs, given what is picked there.

    Parameters
    ----------
    grid
        The columns.
    parts
        Shape (n,): of each pick its sub-aisle, column times blocks plus block.
    offsets
        Shape (n,): metres from the front of the block.

    Returns
    -------
    numpy.ndarray
        Shape (columns, blocks, 6), metres, by `states.VERTICAL`; ``inf`` where a choice leaves
        a pick out or the sub-aisle is closed.
    """
    length = grid.along.ravel()
    costs = np.full((length.size, PLAIN), np.inf)
    costs[:, 0] = 0.0
    costs[:, 1] = length
    costs[:, 2] = 2 * length
    if len(parts):
        order = np.lexsort((offsets, parts))
        part, y = parts[order], offsets[order]
        first = np.flatnonzero(np.diff(part, prepend=-1))
        last = np.append(first[1:], len(part)) - 1
        filled = part[first]
        costs[filled, 0] = np.inf
        costs[filled, 3] = 2 * y[last]
        costs[filled, 4] = 2 * (length[filled] - y[first])
        gaps = np.diff(y, append=0.0)
        gaps[last] = 0.0
        widest = np.maximum.reduceat(gaps, first)
        costs[filled, 5] = np.where(last > first, 2 * (length[filled] - widest), np.inf)
        costs[filled[~np.isfinite(length[filled])]] = np.inf
    return costs.reshape(*grid.along.shape, PLAIN)


def positions_of(
    warehouse: AisleWarehouse, slots: Sequence[Slot]
) -> tuple[npt.NDArray[np.intp], Floats]:
    """Return the sub-aisle of each slot, and its distance from the front of its block."""
    parts = np.array([s.aisle * warehouse.blocks + s.block for s in slots], dtype=np.intp)
    offsets = np.array([warehouse.offset(s) for s in slots], dtype=np.float64)
    return parts, offsets
