"""Shortest tours through aisles: exact for any number of picks.

A tour is found by the sweep as a choice for each sub-aisle and each segment of a cross aisle;
together they are a graph in which every crossing has an even number of walks, and walking all of
them once (Hierholzer) gives the sequence.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from qrobot import _jit
from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, Slot
from qrobot.warehouse.ends import OnCrossAisle, ends_of
from qrobot.warehouse.grid import Grid, grid_of, part_costs, positions_of
from qrobot.warehouse.inside import InAisle, prices_inside, walks_inside
from qrobot.warehouse.one_way import one_way_tour
from qrobot.warehouse.states import MAX_CROSS_AISLES, VERTICAL
from qrobot.warehouse.sweep import Door, Ends, Inside, sweep

__all__ = ["Router", "Tour"]

Crossing = tuple[int, int]
"""(column, cross aisle)"""
Spot = Crossing | InAisle

OFF: tuple[Crossing, Crossing] = (-1, 0), (-1, 1)
"""Start and end of a tour that doors lead to."""


@dataclass(frozen=True, slots=True)
class Tour:
    """A tour from its start past some slots to its end.

    Parameters
    ----------
    length
        Metres; ``inf`` when a place cannot be reached.
    sequence
        Indices of the slots as they are passed first; empty when none can be reached.
    is_shortest
        Whether no tour is shorter: always, but along one-way aisles only up to 15 stops.
    """

    length: float
    sequence: tuple[int, ...]
    is_shortest: bool = True


class Router:
    """Shortest tours through one layout.

    Parameters
    ----------
    warehouse
        At most six cross aisles, unless some are one-way.
    compiled
        Whether numba finds the lengths; by default where it is installed.

    Raises
    ------
    InputError
        When the layout has more cross aisles.
    """

    def __init__(self, warehouse: AisleWarehouse, *, compiled: bool | None = None) -> None:
        self.warehouse = warehouse
        if warehouse.is_one_way:
            return
        if warehouse.blocks + 1 > MAX_CROSS_AISLES:
            raise InputError(
                f"{warehouse.blocks + 1} cross aisles are more than {MAX_CROSS_AISLES}",
                field="blocks",
                advice="let a search find the sequence",
            )
        self.grid: Grid = grid_of(warehouse)
        self._compiled = _jit.available() if compiled is None else compiled
        self._open = self.grid.is_open

    def length(self, slots: Sequence[Slot]) -> float:
        """Return the length of a shortest tour from the depot past all slots, metres."""
        if not slots:
            return 0.0
        if self.warehouse.is_one_way:
            return one_way_tour(self.warehouse, slots)[0]
        if self._compiled:
            from qrobot.warehouse.kernels import masks_of, tour_length  # takes a second to load

            layout, masks = masks_of(self.warehouse, [slots])
            return float(tour_length(masks[0], layout))
        parts, offsets = positions_of(self.warehouse, slots)
        columns = self._columns(
            parts // self.warehouse.blocks, [door.column for door in self.grid.doors]
        )
        costs = part_costs(self.grid, parts, offsets)
        return sweep(costs, self.grid.across, self.grid.doors, columns, ends=self.grid.ends)[0]

    def lengths(self, picks: Sequence[Sequence[Slot]]) -> Floats:
        """Return the lengths of shortest tours past each of several lists of slots, metres."""
        if self.warehouse.is_one_way or not self._compiled or not len(picks):
            return np.array([self.length(slots) for slots in picks], dtype=np.float64)
        from qrobot.warehouse.kernels import masks_of, tour_length  # takes a second to load

        layout, masks = masks_of(self.warehouse, picks)
        return np.array([float(tour_length(mask, layout)) for mask in masks])

    def tour(
        self,
        slots: Sequence[Slot],
        *,
        start: Slot | OnCrossAisle | None = None,
        end: Slot | OnCrossAisle | None = None,
    ) -> Tour:
        """Return a shortest tour past all slots.

        Parameters
        ----------
        slots
            In any sequence.
        start, end
            Where it starts and ends; by default at the depot.

        Raises
        ------
        InputError
            When the layout has no such place, or one-way aisles and a place on a cross aisle.
        """
        if start is None and end is None and not slots:
            return Tour(0.0, ())
        if self.warehouse.is_one_way:
            return self._along_one_ways(slots, start, end)
        ends = ends_of(self.grid, self.warehouse, start, end)
        if not slots and np.isfinite(ends.direct):
            return Tour(ends.direct, ())
        parts, offsets = positions_of(self.warehouse, slots)
        costs = part_costs(self.grid, parts, offsets)
        at: dict[InAisle, list[int]] = defaultdict(list)
        for i, (part, offset) in enumerate(zip(parts.tolist(), offsets.tolist(), strict=True)):
            at[*divmod(part, self.warehouse.blocks), offset].append(i)
        points: dict[Crossing, list[float]] = defaultdict(list)
        for column, block, offset in sorted({*at, *ends.places.values()}):
            points[column, block].append(offset)
        turns: dict[Crossing, dict[int, float]] = defaultdict(dict)
        for which, (column, block, offset) in ends.places.items():
            turns[column, block][which] = offset
        inside = {
            part: Inside(
                2 if len(here) == 2 else min(here),
                prices_inside(points[part], float(self.grid.along[part]), here.values()),
            )
            for part, here in turns.items()
        }
        columns = self._columns([part[0] for part in points], [door.column for door in ends.doors])
        length, choices = sweep(
            costs,
            self.grid.across,
            ends.doors,
            columns,
            ends=ends.kind,
            inside=inside,
            choices=True,
        )
        if not np.isfinite(length):
            return Tour(np.inf, ())
        walks = self._walks(columns, choices, ends.doors, points, turns)
        walked = _walk(walks, ends.places.get(0, OFF[0]))
        if ends.kind is Ends.APART:
            walked.reverse()
        sequence = [i for spot in walked if len(spot) == 3 for i in at.pop(spot, ())]
        return Tour(length, tuple(sequence))

    def route(self, instance: Instance, nodes: Sequence[int]) -> tuple[float, list[int]]:
        """Return the length of a shortest tour past the items of some nodes, and its sequence.

        Parameters
        ----------
        instance
            Its warehouse is that of this router.
        nodes
            Item indices + 1.
        """
        slots = [p for node in nodes if isinstance(p := instance.items[node - 1].place, Slot)]
        tour = self.tour(slots)
        return tour.length, [nodes[at] for at in tour.sequence]

    def _along_one_ways(
        self,
        slots: Sequence[Slot],
        start: Slot | OnCrossAisle | None,
        end: Slot | OnCrossAisle | None,
    ) -> Tour:
        if isinstance(start, OnCrossAisle) or isinstance(end, OnCrossAisle):
            raise InputError(
                "along one-way aisles a tour starts and ends at the depot or at a slot",
                field="start" if isinstance(start, OnCrossAisle) else "end",
                advice="give the slot next to it",
            )
        for place in (start, end):
            if place is not None:
                self.warehouse.check(place)
        return Tour(*one_way_tour(self.warehouse, slots, start, end))

    def _columns(self, *used: Iterable[int]) -> tuple[int, int]:
        """Return the columns that a shortest tour may use."""
        if not self._open:
            return 0, len(self.grid.along) - 1
        columns = [int(column) for part in used for column in part]
        return min(columns), max(columns)

    def _walks(
        self,
        columns: tuple[int, int],
        choices: list[int],
        doors: Sequence[Door],
        points: Mapping[Crossing, Sequence[float]],
        turns: Mapping[Crossing, Mapping[int, float]],
    ) -> Iterator[tuple[Spot, Spot]]:
        """Yield every straight walk of a tour, as often as it is walked."""
        following = iter(choices)
        for column in range(columns[0], columns[1] + 1):
            for door in doors:
                if door.column == column:
                    for _ in range(next(following)):
                        yield OFF[door.end], (column, door.cross)
            for block in range(self.grid.cross_aisles - 1):
                part = column, block
                here = points.get(part, ())
                ends = turns.get(part, {}).values()
                walks = walks_inside(VERTICAL[next(following)], here, ends)
                assert walks is not None
                spots: list[Spot] = [part, *((*part, y) for y in here), (column, block + 1)]
                for step, times in zip(pairwise(spots), walks, strict=True):
                    yield from [step] * times
            for cross in range(self.grid.cross_aisles):
                for _ in range(next(following)):
                    yield (column, cross), (column + 1, cross)


def _walk(walks: Iterator[tuple[Spot, Spot]], start: Spot) -> list[Spot]:
    """Return the spots of a way that takes every walk once, from its end (Hierholzer 1873)."""
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
