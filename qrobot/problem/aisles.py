"""A warehouse of aisles, the graph of its crossings, and shortest ways.

Nodes are the crossings of aisles and cross aisles. Slots hang inside the edges (the
sub-aisles), so the way between two slots is either straight along one sub-aisle or leads
over one end of each. Closed edges are left out, so detours and unreachable slots come out
by themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.checks import check_count, check_index, check_length
from qrobot.problem.warehouse import Place, Slot

__all__ = ["AisleGraph", "AisleWarehouse"]

Crossing = tuple[int, int]
"""(aisle, cross aisle)"""
InAisle = tuple[int, int, float]
"""(aisle, block, distance from the block's front cross aisle)"""


_TOGETHER = 256
"""Starts whose ways are found at once: more would only take more memory."""


@dataclass(frozen=True, slots=True)
class AisleGraph:
    """Crossings, sub-aisles and cross-aisle segments of a rectangular layout."""

    aisles: int
    cross_aisles: int
    aisle_pitch: float
    block_length: float
    closed_aisles: frozenset[tuple[int, int]]
    closed_crossings: frozenset[tuple[int, int]]

    def neighbours(self, at: Crossing) -> list[tuple[Crossing, float]]:
        """Return the crossings one step from `at` and the length of each step, metres."""
        aisle, cross = at
        found = []
        if aisle > 0 and (cross, aisle - 1) not in self.closed_crossings:
            found.append(((aisle - 1, cross), self.aisle_pitch))
        if aisle < self.aisles - 1 and (cross, aisle) not in self.closed_crossings:
            found.append(((aisle + 1, cross), self.aisle_pitch))
        if cross > 0 and (aisle, cross - 1) not in self.closed_aisles:
            found.append(((aisle, cross - 1), self.block_length))
        if cross < self.cross_aisles - 1 and (aisle, cross) not in self.closed_aisles:
            found.append(((aisle, cross + 1), self.block_length))
        return found

    def lengths_from(self, starts: Sequence[Crossing]) -> npt.NDArray[np.float64]:
        """Return the shortest ways from some crossings to all.

        Lengths spread along every aisle and cross aisle, to and fro, until nothing gets
        shorter: one round per turn that the ways need, each for all starts at once.

        Returns
        -------
        numpy.ndarray
            Shape (aisles, cross aisles, starts), metres; ``inf`` where no way exists.
        """
        across = np.full((self.aisles - 1, self.cross_aisles, 1), float(self.aisle_pitch))
        along = np.full((self.aisles, self.cross_aisles - 1, 1), float(self.block_length))
        for cross, aisle in self.closed_crossings:
            across[aisle, cross] = np.inf
        for aisle, block in self.closed_aisles:
            along[aisle, block] = np.inf
        far = np.full((self.aisles, self.cross_aisles, len(starts)), np.inf)
        for s, (aisle, cross) in enumerate(starts):
            far[aisle, cross, s] = 0.0
        known = None
        while known is None or not np.array_equal(known, far):
            known = far.copy()
            _spread(far, across)
            _spread(far.swapaxes(0, 1), along.swapaxes(0, 1))
        return far

    def distance_matrix(
        self, places: Sequence[InAisle], *, depot: Crossing, lead: float
    ) -> npt.NDArray[np.float64]:
        """Return all shortest ways between the depot and places inside aisles.

        Parameters
        ----------
        places
            n places inside sub-aisles.
        depot
            The crossing that the depot stands at.
        lead
            Length of the way from the depot to that crossing, metres.

        Returns
        -------
        numpy.ndarray
            Shape (n + 1, n + 1), metres; row 0 is the depot; ``inf`` where no way exists.
        """
        ends = [(depot, depot), *(((a, b), (a, b + 1)) for a, b, _ in places)]
        crossings = sorted({c for pair in ends for c in pair})
        index = {c: i for i, c in enumerate(crossings)}
        columns = tuple(np.array(crossings).T)
        groups = [crossings[i : i + _TOGETHER] for i in range(0, len(crossings), _TOGETHER)]
        between = np.hstack([self.lengths_from(group)[columns] for group in groups])
        offset = np.array([lead, *(y for *_, y in places)], dtype=np.float64)
        closed = np.array([False, *((a, b) in self.closed_aisles for a, b, _ in places)])
        # Way from each place to its front and back crossing; the depot has one crossing.
        reach = np.stack([offset, self.block_length - offset])
        reach[1, 0] = lead
        reach[:, closed] = np.inf
        at = np.array([[index[front], index[back]] for front, back in ends]).T
        # First from every place to every crossing, then on into the aisles.
        out = np.minimum(*(reach[i][:, None] + between[at[i]] for i in range(2)))
        ways = np.minimum(*(out[:, at[j]] + reach[j] for j in range(2)))
        aisle = np.array([-1, *(a * self.cross_aisles + b for a, b, _ in places)])
        straight = np.abs(offset[:, None] - offset[None, :])
        straight[(aisle[:, None] != aisle[None, :]) | closed] = np.inf
        np.minimum(ways, straight, out=ways)
        np.fill_diagonal(ways, 0.0)
        # The same sums in another sequence may differ by an ulp.
        return np.asarray(np.minimum(ways, ways.T), dtype=np.float64)

    def way(self, start: InAisle | Crossing, end: InAisle | Crossing) -> list[tuple[float, float]]:
        """Return the corner points of a shortest way between two places or crossings."""
        straight = np.inf
        if len(start) == 3 and len(end) == 3 and start[:2] == end[:2]:
            straight = abs(start[2] - end[2])
        best, corners = straight, []
        for exit_, out in self._exits(start):
            far = self.lengths_from([exit_])[..., 0]
            for entry, back in self._exits(end):
                if out + far[entry] + back < best - 1e-12:
                    best = out + far[entry] + back
                    path = [entry]
                    while path[-1] != exit_:
                        path.append(self._towards(path[-1], far))
                    corners = [self._xy(c) for c in reversed(path)]
        return _without_repeats([self._xy(start), *corners, self._xy(end)])

    def _towards(self, at: Crossing, far: npt.NDArray[np.float64]) -> Crossing:
        """Return the neighbour that a shortest way comes from."""
        return min(self.neighbours(at), key=lambda step: float(far[step[0]]) + step[1])[0]

    def _exits(self, place: InAisle | Crossing) -> list[tuple[Crossing, float]]:
        if len(place) == 2:
            return [(place, 0.0)]
        aisle, block, y = place
        return [((aisle, block), y), ((aisle, block + 1), self.block_length - y)]

    def _xy(self, place: InAisle | Crossing) -> tuple[float, float]:
        y = place[1] * self.block_length + (place[2] if len(place) == 3 else 0.0)
        return place[0] * self.aisle_pitch, y


def _spread(far: npt.NDArray[np.float64], steps: npt.NDArray[np.float64]) -> None:
    """Shorten ``far`` in place by walking up and down its first axis."""
    for i in range(len(steps)):
        np.minimum(far[i + 1], far[i] + steps[i], out=far[i + 1])
    for i in reversed(range(len(steps))):
        np.minimum(far[i], far[i + 1] + steps[i], out=far[i])


def _without_repeats(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    kept = points[:1]
    kept.extend(b for a, b in pairwise(points) if a != b)
    return kept


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
    back_gap
        That distance at the back end of every sub-aisle, where it is not `end_gap`.
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
    back_gap: float | None = None
    kind: Literal["aisles"] = "aisles"

    is_metric: ClassVar = True
    has_given_distances: ClassVar = False
    unit: ClassVar = "m"
    way_out: ClassVar = "open an aisle"

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
        check_length(self.gaps[1], "back_gap", most=MAX_PITCH)
        if self.block_length < MIN_PITCH:
            raise InputError("0 leaves no aisle", field="end_gap", advice="use metres above 0")
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
    def gaps(self) -> tuple[float, float]:
        """The gaps at the front and at the back end of every sub-aisle, metres."""
        return self.end_gap, self.end_gap if self.back_gap is None else self.back_gap

    @property
    def block_length(self) -> float:
        """Length of one sub-aisle between two cross aisles, metres."""
        return sum(self.gaps) + (self.slots - 1) * self.slot_pitch

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

    def offset(self, slot: Slot) -> float:
        """Return the distance of a slot from the front cross aisle of its block, metres."""
        return self.end_gap + slot.slot * self.slot_pitch

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
                ends.append((place.aisle, place.block, self.offset(place)))
        points = graph.way(ends[0], ends[1])
        if start is None and self.depot_distance:
            points = [self.depot, *points]
        if end is None and self.depot_distance:
            points = [*points, self.depot]
        return points

    def notes(self, *_of: object) -> tuple[str, ...]:
        """Return what is unusual about the distances: nothing can be."""
        return ()
