"""The checker's own measure of distances: plain Python, no solver's graph.

Euclid and Manhattan by arithmetic, tables by their rows, and aisle warehouses by Dijkstra's
algorithm on crossings of its own, which slots and depot lie between or beside; maps and lanes
in `map_ruler`.
It shares no code with `AisleGraph` or `Instance.distances`, so that a fault there shows.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

from qrobot.plan.map_ruler import CellWalk, LaneWalk
from qrobot.problem.aisles import AisleWarehouse
from qrobot.problem.checks import MAX_LENGTH
from qrobot.problem.floor import OpenFloor
from qrobot.problem.floor_map import FloorMap
from qrobot.problem.lane_network import LaneNetwork
from qrobot.problem.table import DistanceTable
from qrobot.problem.warehouse import Node, Place, Point, Slot, Warehouse

__all__ = ["Ruler"]

_Crossing = tuple[int, int]
"""Aisle and cross aisle."""


class Ruler:
    """Measures ways in a warehouse; every leg once.

    Parameters
    ----------
    warehouse
        Where to measure.
    """

    def __init__(self, warehouse: Warehouse) -> None:
        self._warehouse = warehouse
        self._known: dict[tuple[Place | None, Place | None], float] = {}
        self._walk: _Walk | CellWalk | LaneWalk | None = None
        if isinstance(warehouse, AisleWarehouse):
            self._walk = _Walk(warehouse)
        elif isinstance(warehouse, FloorMap):
            self._walk = CellWalk(warehouse)
        elif isinstance(warehouse, LaneNetwork):
            self._walk = LaneWalk(warehouse)

    def both_ways(self) -> Ruler | None:
        """Return a ruler that measures as if no aisle were one-way, or None when none is."""
        w = self._warehouse
        if not isinstance(w, AisleWarehouse) or not (w.one_way_aisles or w.one_way_crossings):
            return None
        return Ruler(replace(w, one_way_aisles=frozenset(), one_way_crossings=frozenset()))

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
    length = 0.0 if row == column else float(table.matrix[row][column])
    return length if length <= MAX_LENGTH else math.inf  # a marker: no way leads there


def _on_floor(floor: OpenFloor, a: Place | None, b: Place | None) -> float:
    here = (floor.depot_x, floor.depot_y)
    (ax, ay), (bx, by) = ((p.x, p.y) if isinstance(p, Point) else here for p in (a, b))
    if floor.metric == "manhattan":
        length = abs(ax - bx) + abs(ay - by)
    else:
        length = math.hypot(ax - bx, ay - by)
    return float(math.floor(length + 0.5)) if floor.rounding == "nearest" else length


class _Walk:
    """Dijkstra's algorithm over the crossings of an aisle warehouse, from place to place."""

    def __init__(self, w: AisleWarehouse) -> None:
        self._w = w
        self._gaps = w.block_gaps or [(w.end_gap, w.end_gap)] * w.blocks
        self._lengths = [sum(gaps) + w.slot_pitch * (w.slots - 1) for gaps in self._gaps]
        self._steps: defaultdict[_Crossing, list[tuple[_Crossing, float]]] = defaultdict(list)
        for aisle in range(w.aisles):
            for block in range(w.blocks):
                if (aisle, block) not in w.closed_aisles:
                    ends = (aisle, block), (aisle, block + 1)
                    leads = [(aisle, block, t) in w.one_way_aisles for t in ("front", "back")]
                    self._join(*ends, self._lengths[block], *leads)
        for cross in range(w.blocks + 1):
            for aisle in range(w.aisles - 1):
                if (cross, aisle) not in w.closed_crossings:
                    ends = (aisle, cross), (aisle + 1, cross)
                    leads = [(cross, aisle, t) in w.one_way_crossings for t in ("left", "right")]
                    self._join(*ends, w.aisle_pitch, *leads)

    def _join(
        self, a: _Crossing, b: _Crossing, length: float, only_back: bool, only_on: bool
    ) -> None:
        """Add a part from `a` on to `b`, which may lead back to `a` only, or on to `b` only."""
        if not only_back:
            self._steps[a].append((b, length))
        if not only_on:
            self._steps[b].append((a, length))

    def _gates(self, place: Place | None, *, leaving: bool) -> dict[_Crossing, float]:
        """Return the crossings that a place may be left, or entered, by, and how far they are.

        None is the depot.
        """
        w = self._w
        if not isinstance(place, Slot):
            left, right = w.depot_offset, w.aisle_pitch - w.depot_offset
            ways = [(w.depot_aisle, w.depot_distance + left), *w.depot_ways]
            if w.depot_offset:
                ways.append((w.depot_aisle + 1, w.depot_distance + right))
                segment = w.depot_cross_aisle, w.depot_aisle
                against = ("right", "left") if leaving else ("left", "right")
                ways = [
                    way
                    for way, towards in zip(ways, against, strict=True)
                    if (*segment, towards) not in w.one_way_crossings
                ]
            return {(aisle, w.depot_cross_aisle): length for aisle, length in ways}
        if (place.aisle, place.block) in w.closed_aisles:
            return {}
        front = self._gaps[place.block][0] + place.slot * w.slot_pitch
        gates = {}
        if self._leads(place, "front" if leaving else "back"):
            gates[place.aisle, place.block] = front
        if self._leads(place, "back" if leaving else "front"):
            gates[place.aisle, place.block + 1] = self._lengths[place.block] - front
        return gates

    def _leads(self, place: Slot, towards: str) -> bool:
        """Return whether the sub-aisle of a slot may be walked towards its front or its back."""
        one_way = [t for a, b, t in self._w.one_way_aisles if (a, b) == (place.aisle, place.block)]
        return not one_way or towards in one_way

    def __call__(self, start: Place | None, end: Place | None) -> float:
        """Return the length of a shortest way, ``inf`` without one; None is the depot."""
        gates, best = self._gates(end, leaving=False), math.inf
        queue = [(length, at) for at, length in self._gates(start, leaving=True).items()]
        if not gates or not queue:
            return math.inf
        match start, end:  # along the aisle that both are in
            case Slot(), Slot() if (start.aisle, start.block) == (end.aisle, end.block):
                slots = end.slot - start.slot
                if not slots or self._leads(start, "back" if slots > 0 else "front"):
                    best = abs(slots) * self._w.slot_pitch
        heapq.heapify(queue)
        done: set[_Crossing] = set()
        while queue:
            length, at = heapq.heappop(queue)
            if length >= best:
                break
            if at in done:
                continue
            done.add(at)
            if at in gates:
                best = min(best, length + gates[at])
            for to, step in self._steps[at]:
                if to not in done:
                    heapq.heappush(queue, (length + step, to))
        return best
