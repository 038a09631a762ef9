"""A warehouse of parallel aisles, cut into blocks by cross aisles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise, permutations
from math import dist
from typing import ClassVar, Literal

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.aisle_graph import (
    AisleGraph,
    Crossing,
    Door,
    InAisle,
    OneWays,
    without_repeats,
)
from qrobot.problem.checks import (
    check_count,
    check_direction,
    check_index,
    check_length,
)
from qrobot.problem.warehouse import Place, Slot

__all__ = ["AisleWarehouse"]

MAX_CROSSINGS = 4_000
"""Larger layouts are refused: the ways between all crossings alone would take 128 MB."""

MIN_PITCH, MAX_PITCH = 1e-3, 1e6
"""A millimetre and a thousand kilometres: whatever the unit, a layout fits between."""


ALONG, ACROSS = ("front", "back"), ("left", "right")
"""Where a one-way sub-aisle, and a one-way segment of a cross aisle, may lead."""


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
    one_way_aisles
        Sub-aisles ``(aisle, block, towards)`` that pickers walk only towards the ``front`` or the
        ``back``.
    one_way_crossings
        Cross-aisle segments ``(cross_aisle, aisle, towards)`` that pickers walk only to the
        ``left`` or the ``right``.
    block_gaps
        Gaps ``(front, back)`` of each block, where they are not all `end_gap`.
    depot_ways
        Further straight ways ``(aisle, length)`` from the depot, to other crossings of its cross
        aisle. None may be a short cut between crossings: the depot is only where trips end.
    depot_offset
        The depot's way leads to a place so many metres to the right of `depot_aisle`, between two
        aisles of an open segment; then there are no `depot_ways`.
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
    block_gaps: tuple[tuple[float, float], ...] = ()
    depot_ways: tuple[tuple[int, float], ...] = ()
    depot_offset: float = 0.0
    one_way_aisles: OneWays = field(default_factory=frozenset)
    one_way_crossings: OneWays = field(default_factory=frozenset)
    kind: Literal["aisles"] = "aisles"

    is_metric: ClassVar = True
    has_given_distances: ClassVar = False
    unit: ClassVar = "m"

    def __post_init__(self) -> None:
        """Check that the layout can be built."""
        check_count(self.aisles, "aisles", most=MAX_CROSSINGS)
        check_count(self.blocks, "blocks", most=MAX_CROSSINGS)
        check_count(self.slots, "slots", most=10_000)
        if self.aisles * (self.blocks + 1) > MAX_CROSSINGS:
            raise InputError(
                f"{self.aisles * (self.blocks + 1)} crossings are more than {MAX_CROSSINGS}",
                field="aisles",
                advice="give only the part of the layout that this wave needs",
            )
        # Bounded both ways, so that sums of lengths keep every millimetre apart.
        check_length(self.aisle_pitch, "aisle_pitch", least=MIN_PITCH, most=MAX_PITCH)
        check_length(self.slot_pitch, "slot_pitch", least=MIN_PITCH, most=MAX_PITCH)
        check_length(self.end_gap, "end_gap", most=MAX_PITCH)
        self._check_gaps()
        check_length(self.depot_distance, "depot.distance", most=MAX_PITCH)
        check_index(self.depot_aisle, "depot.aisle", count=self.aisles)
        check_index(self.depot_cross_aisle, "depot.cross_aisle", count=self.blocks + 1)
        for aisle, block in self.closed_aisles:
            check_index(aisle, "closed_aisles[].aisle", count=self.aisles)
            check_index(block, "closed_aisles[].block", count=self.blocks)
        for cross_aisle, aisle in self.closed_crossings:
            check_index(cross_aisle, "closed_crossings[].cross_aisle", count=self.blocks + 1)
            check_index(aisle, "closed_crossings[].aisle", count=self.aisles - 1)
        self._check_directions()
        if self.depot_offset:
            self._check_offset()
        if self.depot_ways:
            self._check_ways()

    def _check_gaps(self) -> None:
        if len(self.block_gaps) not in (0, self.blocks):
            raise InputError(
                f"{len(self.block_gaps)} pairs of gaps for {self.blocks} blocks",
                field="block_gaps",
                advice="give a front and a back gap for each block",
            )
        for b, pair in enumerate(self.block_gaps):
            for side, gap in zip(("front", "back"), pair, strict=True):
                check_length(gap, f"block_gaps[{b}].{side}", most=MAX_PITCH)
        for b, length in enumerate(self.block_lengths):
            if length < MIN_PITCH:
                field = f"block_gaps[{b}].front" if self.block_gaps else "end_gap"
                raise InputError("0 leaves no aisle", field=field, advice="use metres above 0")

    def _check_directions(self) -> None:
        for aisle, block, towards in self.one_way_aisles:
            check_index(aisle, "one_way_aisles[].aisle", count=self.aisles)
            check_index(block, "one_way_aisles[].block", count=self.blocks)
            where = f"block {block} of aisle {aisle}"
            closed = (aisle, block) in self.closed_aisles
            opposites = [(aisle, block, other) in self.one_way_aisles for other in ALONG]
            check_direction(where, "one_way_aisles[]", towards, ALONG, closed, all(opposites))
        for cross, aisle, towards in self.one_way_crossings:
            check_index(cross, "one_way_crossings[].cross_aisle", count=self.blocks + 1)
            check_index(aisle, "one_way_crossings[].aisle", count=self.aisles - 1)
            where = f"cross aisle {cross} to the right of aisle {aisle}"
            closed = (cross, aisle) in self.closed_crossings
            opposites = [(cross, aisle, other) in self.one_way_crossings for other in ACROSS]
            check_direction(where, "one_way_crossings[]", towards, ACROSS, closed, all(opposites))

    def _check_offset(self) -> None:
        check_length(self.depot_offset, "depot.offset", most=MAX_PITCH)
        if self.depot_ways:
            raise InputError(
                "a depot between two aisles has one way only",
                field="depot.ways",
                advice="leave depot.offset or depot.ways out",
            )
        if self.depot_offset >= self.aisle_pitch or self.depot_aisle == self.aisles - 1:
            raise InputError(
                f"the depot is not between aisle {self.depot_aisle} and the next",
                field="depot.offset",
                advice="count it from the aisle to the left, less than an aisle pitch",
            )
        if (self.depot_cross_aisle, self.depot_aisle) in self.closed_crossings:
            raise InputError(
                "the depot is on a closed segment of its cross aisle",
                field="depot.offset",
                advice="open it, or move the depot",
            )

    def _check_ways(self) -> None:
        for i, (aisle, length) in enumerate(self.depot_ways):
            check_index(aisle, f"depot.ways[{i}].aisle", count=self.aisles)
            check_length(length, f"depot.ways[{i}].distance", most=MAX_PITCH)
        doors, far = zip(*self.doors, strict=True)
        if len(set(doors)) < len(doors):
            raise InputError(
                "two ways lead to one aisle", field="depot.ways", advice="keep the shorter one"
            )
        lengths = self.graph().lengths_from(doors)
        for (i, a), (j, b) in permutations(enumerate(doors), 2):
            if far[i] + far[j] < lengths[(*a, j)] * (1 - 1e-12):
                raise InputError(
                    f"the ways to aisles {a[0]} and {b[0]} are a short cut past the depot",
                    field="depot.ways",
                    advice="lengthen them, or give the distances as a matrix",
                )

    @property
    def is_one_way(self) -> bool:
        """Whether some part may be walked in one direction only: a way there is not one back."""
        return bool(self.one_way_aisles or self.one_way_crossings)

    @property
    def way_out(self) -> str:
        """What to do beside moving the items when nothing leads to them."""
        return "open an aisle" + (" or drop a direction" if self.is_one_way else "")

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """The front and the back gap of each block, metres."""
        return self.block_gaps or ((self.end_gap, self.end_gap),) * self.blocks

    @property
    def block_lengths(self) -> tuple[float, ...]:
        """Length of the sub-aisles of each block, from cross aisle to cross aisle, metres."""
        slots = (self.slots - 1) * self.slot_pitch
        return tuple(front + back + slots for front, back in self.gaps)

    @property
    def cross_aisle_heights(self) -> tuple[float, ...]:
        """Distance of each cross aisle from the front one, metres."""
        return tuple(accumulate(self.block_lengths, initial=0.0))

    @property
    def doors(self) -> list[Door]:
        """The crossings that the depot has ways to, and the lengths of these, metres."""
        aisle, length, offset = self.depot_aisle, self.depot_distance, self.depot_offset
        ways = ((aisle, length + offset), *self.depot_ways)
        if offset:
            ways = (*ways, (aisle + 1, length + self.aisle_pitch - offset))
        return [((aisle, self.depot_cross_aisle), length) for aisle, length in ways]

    @property
    def ways_out(self) -> list[Door]:
        """Those of the `doors` that the depot may be left by: all but on a one-way segment."""
        return self._doors_towards("right")

    @property
    def ways_back(self) -> list[Door]:
        """Those of the `doors` that ways back to the depot may come from."""
        return self._doors_towards("left")

    def _doors_towards(self, last: str) -> list[Door]:
        """Return the doors, without that against the direction of the segment around the depot.

        It is the left one where the segment leads to `last`, and the right one otherwise.
        """
        segment = self.depot_cross_aisle, self.depot_aisle
        leads = [t for t in ACROSS if (*segment, t) in self.one_way_crossings]
        if not self.depot_offset or not leads:
            return self.doors
        return self.doors[1:] if leads[0] == last else self.doors[:1]

    @property
    def depot(self) -> tuple[float, float]:
        """Where the depot is drawn, metres."""
        x = self.depot_aisle * self.aisle_pitch + self.depot_offset
        y = self.cross_aisle_heights[self.depot_cross_aisle]
        outward = -1.0 if self.depot_cross_aisle <= self.blocks / 2 else 1.0
        return x, y + outward * self.depot_distance

    def graph(self) -> AisleGraph:
        """Return the graph of crossings that ways run on."""
        return AisleGraph(
            aisles=self.aisles,
            cross_aisles=self.blocks + 1,
            aisle_pitch=self.aisle_pitch,
            block_lengths=self.block_lengths,
            closed_aisles=self.closed_aisles,
            closed_crossings=self.closed_crossings,
            one_way_aisles=self.one_way_aisles,
            one_way_crossings=self.one_way_crossings,
        )

    def position(self, place: Place) -> tuple[float, float]:
        """Return where the picker stands to reach a slot, metres."""
        assert isinstance(place, Slot)
        y = self.cross_aisle_heights[place.block] + self.offset(place)
        return place.aisle * self.aisle_pitch, y

    def offset(self, slot: Slot) -> float:
        """Return the distance of a slot from the front cross aisle of its block, metres."""
        return self.gaps[slot.block][0] + slot.slot * self.slot_pitch

    def check(self, place: Place) -> None:
        """Raise `InputError` when a place is not a slot of this layout."""
        if not isinstance(place, Slot):
            raise InputError(
                f"{place} is not a slot", advice="an aisle warehouse needs aisle, block and slot"
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
                    advice=f"use 0 to {count - 1}, or enlarge the layout",
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
        points = [(s.aisle, s.block, self.offset(s)) for s in places if isinstance(s, Slot)]
        return self.graph().distance_matrix(points, self.ways_out, self.ways_back)

    def way(self, start: Place | None, end: Place | None) -> list[tuple[float, float]]:
        """Return the corner points of a shortest way; ``None`` stands for the depot."""
        graph, ways = self.graph(), []
        for first, out in self._spots(start, self.ways_out):
            for last, back in self._spots(end, self.ways_back):
                points = graph.way(first, last)
                length = out + sum(dist(a, b) for a, b in pairwise(points)) + back
                ways.append((length, points))
        points, lead = min(ways)[1], [self.depot, *self._gate]
        return without_repeats(lead * (start is None) + points + lead[::-1] * (end is None))

    @property
    def _gate(self) -> list[tuple[float, float]]:
        """Where the way of a depot between two aisles meets the cross aisle."""
        height = self.cross_aisle_heights[self.depot_cross_aisle]
        return [(self.depot[0], height)] if self.depot_offset else []

    def _spots(
        self, place: Place | None, doors: Sequence[Door]
    ) -> Sequence[tuple[InAisle | Crossing, float]]:
        """Return where ways to a place end, and how far it is from there."""
        if place is None:
            return doors
        assert isinstance(place, Slot)
        return [((place.aisle, place.block, self.offset(place)), 0.0)]

    def notes(self, *_of: object) -> tuple[str, ...]:
        """Return what is unusual about the distances: nothing can be."""
        return ()
