"""The checker's own measure of distances: plain Python, no solver's graph.

Euclid and Manhattan by arithmetic, tables by their rows, and aisle warehouses by Dijkstra's
algorithm on a graph of its own, in which slots and depot are nodes beside the crossings.
It shares no code with `AisleGraph` or `Instance.distances`, so that a fault there shows.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Hashable, Iterable
from itertools import pairwise

from qrobot.problem.warehouse import (
    AisleWarehouse,
    DistanceTable,
    Node,
    OpenFloor,
    Place,
    Point,
    Slot,
    Warehouse,
)

__all__ = ["Ruler"]


class Ruler:
    """Measures ways in a warehouse; every leg once.

    Parameters
    ----------
    warehouse
        Where to measure.
    places
        Every place that will be asked for.
    """

    def __init__(self, warehouse: Warehouse, places: Iterable[Place]) -> None:
        self._warehouse = warehouse
        self._known: dict[tuple[Place | None, Place | None], float] = {}
        self._walk: _Walk | None = None
        if isinstance(warehouse, AisleWarehouse):
            self._walk = _Walk(warehouse, places)

    def trip(self, places: Iterable[Place]) -> float:
        """Return the length of a trip from the depot past the places and back."""
        stops = [None, *places, None]
        if len(stops) == 2:
            return 0.0
        return math.fsum(self.leg(a, b) for a, b in pairwise(stops))

    def leg(self, a: Place | None, b: Place | None) -> float:
        """Return the length of one way, ``inf`` without one; ``None`` stands for the depot."""
        if a == b:
            return 0.0
        if (a, b) not in self._known:
            if self._walk is not None:
                length = self._walk(a, b)
            elif isinstance(self._warehouse, DistanceTable):
                length = _in_table(self._warehouse, a, b)
            else:
                assert isinstance(self._warehouse, OpenFloor)
                length = _on_floor(self._warehouse, a, b)
            self._known[a, b] = length
        return self._known[a, b]


def _in_table(table: DistanceTable, a: Place | None, b: Place | None) -> float:
    row, column = (p.index if isinstance(p, Node) else table.depot_node for p in (a, b))
    return 0.0 if row == column else float(table.matrix[row][column])


def _on_floor(floor: OpenFloor, a: Place | None, b: Place | None) -> float:
    here = (floor.depot_x, floor.depot_y)
    (ax, ay), (bx, by) = ((p.x, p.y) if isinstance(p, Point) else here for p in (a, b))
    if floor.metric == "manhattan":
        length = abs(ax - bx) + abs(ay - by)
    else:
        length = math.hypot(ax - bx, ay - by)
    return float(math.floor(length + 0.5)) if floor.rounding == "nearest" else length


class _Walk:
    """Dijkstra's algorithm over crossings, slots and the depot of an aisle warehouse."""

    def __init__(self, w: AisleWarehouse, places: Iterable[Place]) -> None:
        self._steps: defaultdict[Hashable, list[tuple[Hashable, float]]] = defaultdict(list)
        length = w.end_gap * 2 + w.slot_pitch * (w.slots - 1)
        used: defaultdict[tuple[int, int], set[int]] = defaultdict(set)
        for p in places:
            if isinstance(p, Slot):
                used[p.aisle, p.block].add(p.slot)
        for aisle in range(w.aisles):
            for block in range(w.blocks):
                if (aisle, block) in w.closed_aisles:
                    continue
                slots = sorted(used[aisle, block])
                chain: list[tuple[Hashable, float]] = [
                    (("cross", aisle, block), 0.0),
                    *(((aisle, block, s), w.end_gap + s * w.slot_pitch) for s in slots),
                    (("cross", aisle, block + 1), length),
                ]
                for (a, at), (b, to) in pairwise(chain):
                    self._join(a, b, to - at)
        for cross in range(w.blocks + 1):
            for aisle in range(w.aisles - 1):
                if (cross, aisle) not in w.closed_crossings:
                    self._join(("cross", aisle, cross), ("cross", aisle + 1, cross), w.aisle_pitch)
        door = ("cross", w.depot_aisle, w.depot_cross_aisle)
        self._join("depot", door, w.depot_distance)

    def _join(self, a: Hashable, b: Hashable, length: float) -> None:
        self._steps[a].append((b, length))
        self._steps[b].append((a, length))

    def __call__(self, start: Place | None, end: Place | None) -> float:
        """Return the length of a shortest way, ``inf`` without one; None is the depot."""
        source, target = (
            (p.aisle, p.block, p.slot) if isinstance(p, Slot) else "depot" for p in (start, end)
        )
        done: set[Hashable] = set()
        turn = 0  # breaks ties, so that nodes are never compared
        queue: list[tuple[float, int, Hashable]] = [(0.0, turn, source)]
        while queue:
            length, _, at = heapq.heappop(queue)
            if at == target:
                return length
            if at in done:
                continue
            done.add(at)
            for to, step in self._steps[at]:
                if to not in done:
                    turn += 1
                    heapq.heappush(queue, (length + step, turn, to))
        return math.inf
