"""Shortest tours through aisles: exact for any number of picks.

A tour is found by the sweep as a choice for each sub-aisle and each segment of a cross aisle;
together they are a graph in which every crossing has an even number of walks, and walking all of
them once (Hierholzer) gives the sequence.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from qrobot import _jit
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.grid import Grid, grid_of, part_costs, positions_of
from qrobot.warehouse.states import MAX_CROSS_AISLES, VERTICAL
from qrobot.warehouse.sweep import sweep

__all__ = ["Router", "Tour"]

Crossing = tuple[int, int]
"""(column, cross aisle)"""
InAisle = tuple[int, int, float]
"""(column, block, metres from the block's front)"""
Spot = Crossing | InAisle


@dataclass(frozen=True, slots=True)
class Tour:
    """A tour from the depot past some slots and back.

    Parameters
    ----------
    length
        Metres; ``inf`` when a slot cannot be reached.
    sequence
        Indices of the slots as they are passed first; empty when none can be reached.
    """

    length: float
    sequence: tuple[int, ...]


class Router:
    """Shortest tours through one layout.

    Parameters
    ----------
    warehouse
        At most six cross aisles.
    compiled
        Whether numba finds the lengths; by default where it is installed.

    Raises
    ------
    InputError
        When the layout has more cross aisles.
    """

    def __init__(self, warehouse: AisleWarehouse, *, compiled: bool | None = None) -> None:
        if warehouse.blocks + 1 > MAX_CROSS_AISLES:
            raise InputError(
                f"{warehouse.blocks + 1} cross aisles are more than {MAX_CROSS_AISLES}",
                field="blocks",
                advice="let a search find the sequence",
            )
        self.warehouse = warehouse
        self.grid: Grid = grid_of(warehouse)
        self._compiled = _jit.available() if compiled is None else compiled
        self._open = self.grid.is_open

    def length(self, slots: Sequence[Slot]) -> float:
        """Return the length of a shortest tour from the depot past all slots, metres."""
        if not slots:
            return 0.0
        if self._compiled:
            from qrobot.warehouse.kernels import masks_of, tour_length  # takes a second to load

            layout, masks = masks_of(self.warehouse, [slots])
            return float(tour_length(masks[0], layout))
        parts, offsets = positions_of(self.warehouse, slots)
        costs = part_costs(self.grid, parts, offsets)
        columns = self._columns(parts.min(), parts.max())
        length, _ = sweep(costs, self.grid.across, self.grid.depot, columns)
        return length + 2 * self.grid.lead

    def tour(self, slots: Sequence[Slot]) -> Tour:
        """Return a shortest tour from the depot past all slots and back."""
        if not slots:
            return Tour(0.0, ())
        parts, offsets = positions_of(self.warehouse, slots)
        costs = part_costs(self.grid, parts, offsets)
        columns = self._columns(parts.min(), parts.max())
        length, choices = sweep(costs, self.grid.across, self.grid.depot, columns, choices=True)
        if not np.isfinite(length):
            return Tour(np.inf, ())
        at: dict[InAisle, list[int]] = defaultdict(list)
        for i, (part, offset) in enumerate(zip(parts.tolist(), offsets.tolist(), strict=True)):
            column, block = divmod(part, self.grid.cross_aisles - 1)
            at[column, block, offset].append(i)
        walks = self._walks(columns, choices, sorted(at))
        walked = _walk(walks, self.grid.depot)
        sequence = [i for spot in walked if len(spot) == 3 for i in at.pop(spot, ())]
        return Tour(length + 2 * self.grid.lead, tuple(sequence))

    def _columns(self, first_part: int, last_part: int) -> tuple[int, int]:
        """Return the columns that a shortest tour may use."""
        if not self._open:
            return 0, len(self.grid.along) - 1
        blocks = self.grid.cross_aisles - 1
        depot = self.grid.depot[0]
        return min(int(first_part) // blocks, depot), max(int(last_part) // blocks, depot)

    def _walks(
        self, columns: tuple[int, int], choices: list[int], places: list[InAisle]
    ) -> Iterator[tuple[Spot, Spot]]:
        """Yield every straight walk of a tour, as often as it is walked."""
        following = iter(choices)
        for column in range(columns[0], columns[1] + 1):
            if column == self.grid.depot[0]:
                next(following)
            for block in range(self.grid.cross_aisles - 1):
                inside = [p for p in places if p[:2] == (column, block)]
                yield from _inside((column, block), VERTICAL[next(following)], inside)
            for cross in range(self.grid.cross_aisles):
                for _ in range(next(following)):
                    yield (column, cross), (column + 1, cross)


def _inside(part: Crossing, kind: str, places: list[InAisle]) -> Iterator[tuple[Spot, Spot]]:
    """Yield the walks inside a sub-aisle."""
    spots: list[Spot] = [*places]
    front: Spot = part
    back: Spot = (part[0], part[1] + 1)
    if kind == "none":
        return
    if kind in ("pass", "twice"):
        for step in pairwise([front, *spots, back]):
            yield from [step] * (1 if kind == "pass" else 2)
        return
    near = len(spots) if kind == "front" else 0
    if kind == "both":
        near = 1 + int(np.argmax([b[2] - a[2] for a, b in pairwise(places)]))
    for step in (*pairwise([front, *spots[:near]]), *pairwise([*spots[near:], back])):
        yield from [step] * 2


def _walk(walks: Iterator[tuple[Spot, Spot]], start: Spot) -> list[Spot]:
    """Return the spots of a closed walk that takes every given walk once (Hierholzer 1873)."""
    left: dict[Spot, list[tuple[Spot, int]]] = defaultdict(list)
    used: list[bool] = []
    for a, b in walks:
        left[a].append((b, len(used)))
        left[b].append((a, len(used)))
        used.append(False)
    stack, found = [start], []
    while stack:
        steps = left[stack[-1]]
        while steps and used[steps[-1][1]]:
            steps.pop()
        if not steps:
            found.append(stack.pop())
            continue
        spot, walk = steps.pop()
        used[walk] = True
        stack.append(spot)
    return found
