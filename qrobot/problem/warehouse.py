"""Where things stand: the three kinds of warehouse and the places in them.

A warehouse knows two things: where a place is drawn (`position`) and how long the way
between two places is (`distance_matrix`). All lengths of one warehouse are in one unit,
metres by convention.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.aisles import AisleGraph
from qrobot.problem.checks import check_count, check_index, check_length
from qrobot.problem.floor import OpenFloor
from qrobot.problem.places import Node, Place, Point, Slot
from qrobot.problem.table import DistanceTable

__all__ = ["AisleWarehouse", "DistanceTable", "Node", "OpenFloor", "Place", "Point", "Slot"]


MAX_CROSSINGS = 4_000
"""Larger layouts are refused: the ways between all crossings alone would take 128 MB."""

MIN_PITCH, MAX_PITCH = 1e-3, 1e6
"""A millimetre and a thousand kilometres: whatever the unit, a layout fits between."""


@dataclass(frozen=True, slots=True)
class AisleWarehouse:
    """A rectangular layout: parallel aisles, cut into blocks by cross aisles.

    With B blocks there are B + 1 cross aisles; cross aisle 0 is the front. Pickers walk in
    the middle of aisles and cross aisles (van Gils et al. 2018, the paper's figure of the
    warehouse).

    Parameters
    ----------
    aisles, blocks, slots
        Number of aisles, of blocks, and of slots per aisle and block on each side.
    aisle_pitch
        Distance between the middles of two neighbouring aisles, metres.
    slot_pitch
        Distance between the middles of two neighbouring slots, metres.
    end_gap
        Distance from the middle of a cross aisle to the middle of the nearest slot, metres.
    depot_aisle, depot_cross_aisle
        The crossing that the depot stands at.
    depot_distance
        Length of the way from the depot to that crossing, metres.
    closed_aisles
        Sub-aisles ``(aisle, block)`` that nobody can enter.
    closed_crossings
        Cross-aisle segments ``(cross_aisle, aisle)`` between an aisle and its right
        neighbour that nobody can pass.
    """

    aisles: int
    slots: int
    blocks: int = 1
    aisle_pitch: float = 3.0
    slot_pitch: float = 1.0
    end_gap: float = 1.0
    depot_aisle: int = 0
    depot_cross_aisle: int = 0
    depot_distance: float = 0.0
    closed_aisles: frozenset[tuple[int, int]] = field(default_factory=frozenset)
    closed_crossings: frozenset[tuple[int, int]] = field(default_factory=frozenset)
    kind: Literal["aisles"] = "aisles"

    def __post_init__(self) -> None:
        """Check that the layout can be built."""
        check_count(self.aisles, "aisles", most=MAX_CROSSINGS)
        check_count(self.blocks, "blocks", most=MAX_CROSSINGS)
        check_count(self.slots, "slots", most=10_000)
        if self.aisles * (self.blocks + 1) > MAX_CROSSINGS:
            raise InputError(
                f"{self.aisles * (self.blocks + 1)} crossings are more than {MAX_CROSSINGS}",
                field="aisles",
                mend="give only the part of the layout that this wave needs",
            )
        # Bounded both ways, so that sums of lengths keep every millimetre apart.
        check_length(self.aisle_pitch, "aisle_pitch", least=MIN_PITCH, most=MAX_PITCH)
        check_length(self.slot_pitch, "slot_pitch", least=MIN_PITCH, most=MAX_PITCH)
        check_length(self.end_gap, "end_gap", most=MAX_PITCH)
        if self.block_length < MIN_PITCH:
            raise InputError("0 leaves no aisle", field="end_gap", mend="use metres above 0")
        check_length(self.depot_distance, "depot.distance", most=MAX_PITCH)
        check_index(self.depot_aisle, "depot.aisle", count=self.aisles)
        check_index(self.depot_cross_aisle, "depot.cross_aisle", count=self.blocks + 1)
        for aisle, block in self.closed_aisles:
            check_index(aisle, "closed_aisles[].aisle", count=self.aisles)
            check_index(block, "closed_aisles[].block", count=self.blocks)
        for cross_aisle, aisle in self.closed_crossings:
            check_index(cross_aisle, "closed_crossings[].cross_aisle", count=self.blocks + 1)
            check_index(aisle, "closed_crossings[].aisle", count=self.aisles - 1)

    @property
    def block_length(self) -> float:
        """Length of one sub-aisle between two cross aisles, metres."""
        return 2 * self.end_gap + (self.slots - 1) * self.slot_pitch

    @property
    def depot(self) -> tuple[float, float]:
        """Where the depot is drawn, metres."""
        x = self.depot_aisle * self.aisle_pitch
        y = self.depot_cross_aisle * self.block_length
        outward = -1.0 if self.depot_cross_aisle <= self.blocks / 2 else 1.0
        return x, y + outward * self.depot_distance

    def graph(self) -> AisleGraph:
        """Return the graph of crossings that ways run on."""
        return AisleGraph(
            aisles=self.aisles,
            cross_aisles=self.blocks + 1,
            aisle_pitch=self.aisle_pitch,
            block_length=self.block_length,
            closed_aisles=self.closed_aisles,
            closed_crossings=self.closed_crossings,
        )

    def position(self, place: Place) -> tuple[float, float]:
        """Return where the picker stands to reach a slot, metres."""
        assert isinstance(place, Slot)
        y = place.block * self.block_length + self.end_gap + place.slot * self.slot_pitch
        return place.aisle * self.aisle_pitch, y

    def check(self, place: Place) -> None:
        """Raise `InputError` when a place is not a slot of this layout."""
        if not isinstance(place, Slot):
            raise InputError(
                f"{place} is not a slot", mend="an aisle warehouse needs aisle, block and slot"
            )
        for name, value, count in (
            ("aisle", place.aisle, self.aisles),
            ("block", place.block, self.blocks),
            ("slot", place.slot, self.slots),
        ):
            if not 0 <= value < count:
                raise InputError(
                    f"{name} {value} is outside the layout",
                    field=name,
                    mend=f"use 0 to {count - 1}, or enlarge the layout",
                )

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return the shortest ways between depot and places along the aisles.

        Parameters
        ----------
        places
            n slots.

        Returns
        -------
        numpy.ndarray
            Shape (n + 1, n + 1), metres; row 0 is the depot. ``inf`` where no way exists.
        """
        points = [(s.aisle, *self._offset(s)) for s in places if isinstance(s, Slot)]
        return self.graph().distance_matrix(
            points, depot=(self.depot_aisle, self.depot_cross_aisle), lead=self.depot_distance
        )

    def way(self, start: Place | None, end: Place | None) -> list[tuple[float, float]]:
        """Return the corner points of a shortest way; ``None`` stands for the depot."""
        graph = self.graph()
        ends: list[tuple[int, int, float] | tuple[int, int]] = []
        for place in (start, end):
            if place is None:
                ends.append((self.depot_aisle, self.depot_cross_aisle))
            else:
                assert isinstance(place, Slot)
                ends.append((place.aisle, *self._offset(place)))
        points = graph.way(ends[0], ends[1])
        if start is None and self.depot_distance:
            points = [self.depot, *points]
        if end is None and self.depot_distance:
            points = [*points, self.depot]
        return points

    def _offset(self, slot: Slot) -> tuple[int, float]:
        """Return the block of a slot and its distance from the block's front cross aisle."""
        return slot.block, self.end_gap + slot.slot * self.slot_pitch


Warehouse = AisleWarehouse | OpenFloor | DistanceTable
