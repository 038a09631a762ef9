"""The graph of the crossings of a warehouse of aisles, and shortest ways in it.

Nodes are the crossings of aisles and cross aisles. Slots hang inside the edges (the
sub-aisles), so the way between two slots is either straight along one sub-aisle or leads
over one end of each. Closed edges are left out, and one-way ones lead in one direction only, so
detours and unreachable slots come out by themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from qrobot._arrays import Floats

__all__ = ["AisleGraph", "Crossing", "Door", "InAisle", "OneWays", "without_repeats"]

Crossing = tuple[int, int]
"""(aisle, cross aisle)"""
InAisle = tuple[int, int, float]
"""(aisle, block, distance from the block's front cross aisle)"""
Door = tuple[Crossing, float]
"""A crossing that the depot has a way to, and the length of that way."""
OneWays = frozenset[tuple[int, int, str]]
"""(aisle, block, ``front`` or ``back``), or (cross aisle, aisle, ``left`` or ``right``): where
pickers may go to."""

_TOGETHER = 256
"""Starts whose ways are found at once: more would only take more memory."""


@dataclass(frozen=True, slots=True)
class AisleGraph:
    """Crossings, sub-aisles and cross-aisle segments of a rectangular layout."""

    aisles: int
    cross_aisles: int
    aisle_pitch: float
    block_lengths: tuple[float, ...]
    closed_aisles: frozenset[tuple[int, int]]
    closed_crossings: frozenset[tuple[int, int]]
    one_way_aisles: OneWays = frozenset()
    one_way_crossings: OneWays = frozenset()

    def _leads(self, aisle: int, block: int, towards: str) -> bool:
        """Return whether a sub-aisle may be walked towards its front or its back."""
        opposite = "back" if towards == "front" else "front"
        blocked = (aisle, block, opposite) in self.one_way_aisles
        return not blocked and (aisle, block) not in self.closed_aisles

    def _passes(self, cross: int, aisle: int, towards: str) -> bool:
        """Return whether a segment of a cross aisle may be walked to the left or right."""
        opposite = "left" if towards == "right" else "right"
        blocked = (cross, aisle, opposite) in self.one_way_crossings
        return not blocked and (cross, aisle) not in self.closed_crossings

    def _sources(self, at: Crossing) -> list[tuple[Crossing, float]]:
        """Return the crossings that one step to `at` comes from, and its length, metres."""
        aisle, cross = at
        found = []
        if aisle > 0 and self._passes(cross, aisle - 1, "right"):
            found.append(((aisle - 1, cross), self.aisle_pitch))
        if aisle < self.aisles - 1 and self._passes(cross, aisle, "left"):
            found.append(((aisle + 1, cross), self.aisle_pitch))
        if cross > 0 and self._leads(aisle, cross - 1, "back"):
            found.append(((aisle, cross - 1), self.block_lengths[cross - 1]))
        if cross < self.cross_aisles - 1 and self._leads(aisle, cross, "front"):
            found.append(((aisle, cross + 1), self.block_lengths[cross]))
        return found

    def lengths_from(self, starts: Sequence[Crossing]) -> Floats:
        """Return the shortest ways from some crossings to all.

        Lengths spread along every aisle and cross aisle, to and fro, until nothing gets
        shorter: one round per turn that the ways need, each for all starts at once.

        Returns
        -------
        numpy.ndarray
            Shape (aisles, cross aisles, starts), metres; ``inf`` where no way exists.
        """
        return self._lengths(starts, *self._steps())

    def lengths_to(self, ends: Sequence[Crossing]) -> Floats:
        """Return the shortest ways from all crossings to some, in the shape of `lengths_from`."""
        right, left, back, front = self._steps()
        return self._lengths(ends, left, right, front, back)

    def _steps(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the lengths of single steps to the right, left, back and front.

        The first two have the shape (aisles - 1, cross aisles, 1), the others (aisles, blocks, 1).
        """
        across = np.full((self.aisles - 1, self.cross_aisles, 1), float(self.aisle_pitch))
        along = np.tile(np.array(self.block_lengths)[:, None], (self.aisles, 1, 1))
        for cross, aisle in self.closed_crossings:
            across[aisle, cross] = np.inf
        for aisle, block in self.closed_aisles:
            along[aisle, block] = np.inf
        right, left, back, front = across, across.copy(), along, along.copy()
        for cross, aisle, towards in self.one_way_crossings:
            (left if towards == "right" else right)[aisle, cross] = np.inf
        for aisle, block, towards in self.one_way_aisles:
            (front if towards == "back" else back)[aisle, block] = np.inf
        return right, left, back, front

    def _lengths(
        self, starts: Sequence[Crossing], right: Floats, left: Floats, back: Floats, front: Floats
    ) -> Floats:
        far = np.full((self.aisles, self.cross_aisles, len(starts)), np.inf)
        for s, (aisle, cross) in enumerate(starts):
            far[aisle, cross, s] = 0.0
        known = None
        while known is None or not np.array_equal(known, far):
            known = far.copy()
            _spread(far, right, left)
            _spread(far.swapaxes(0, 1), back.swapaxes(0, 1), front.swapaxes(0, 1))
        return far

    def distance_matrix(
        self, places: Sequence[InAisle], out: Sequence[Door], back: Sequence[Door]
    ) -> Floats:
        """Return all shortest ways between the depot and places inside aisles.

        Parameters
        ----------
        places
            n places inside sub-aisles.
        out, back
            Where the ways from the depot lead to, and where those back to it begin.

        Returns
        -------
        numpy.ndarray
            Shape (n + 1, n + 1), metres; row 0 is the depot; ``inf`` where no way exists.
        """
        if not places:
            return np.zeros((1, 1))
        ends = [((a, b), (a, b + 1)) for a, b, _ in places]
        crossings = sorted({c for pair in ends for c in pair})
        index = {c: i for i, c in enumerate(crossings, 1)}
        between = self._between(crossings, out, back)
        offset = np.array([0.0, *(y for *_, y in places)], dtype=np.float64)
        # Way from each place to its front and back crossing; the depot is its own.
        length = np.array([0.0, *(self.block_lengths[b] for _, b, _ in places)])
        reach = np.stack([offset, length - offset])
        to_front = np.array([True, *(self._leads(a, b, "front") for a, b, _ in places)])
        to_back = np.array([True, *(self._leads(a, b, "back") for a, b, _ in places)])
        leave = np.where(np.stack([to_front, to_back]), reach, np.inf)
        enter = np.where(np.stack([to_back, to_front]), reach, np.inf)
        at = np.array([[0, 0], *([index[front], index[back]] for front, back in ends)]).T
        # First from every place to every crossing, then on into the aisles.
        way_out = np.minimum(*(leave[i][:, None] + between[at[i]] for i in range(2)))
        ways = np.minimum(*(way_out[:, at[j]] + enter[j] for j in range(2)))
        aisle = np.array([-1, *(a * self.cross_aisles + b for a, b, _ in places)])
        further = offset[None, :] - offset[:, None]
        allowed = ((further >= 0) & to_back[:, None]) | ((further <= 0) & to_front[:, None])
        allowed &= aisle[:, None] == aisle[None, :]
        np.minimum(ways, np.where(allowed, np.abs(further), np.inf), out=ways)
        np.fill_diagonal(ways, 0.0)
        if self.one_way_aisles or self.one_way_crossings:
            return np.asarray(ways, dtype=np.float64)
        # The same sums in another sequence may differ by an ulp.
        return np.asarray(np.minimum(ways, ways.T), dtype=np.float64)

    def _between(
        self, crossings: Sequence[Crossing], out: Sequence[Door], back: Sequence[Door]
    ) -> Floats:
        """Return the shortest ways between the depot (row 0) and some crossings."""
        columns = tuple(np.array(crossings).T)
        groups = [crossings[i : i + _TOGETHER] for i in range(0, len(crossings), _TOGETHER)]
        between = np.zeros((len(crossings) + 1,) * 2)
        between[1:, 1:] = np.hstack([self.lengths_from(group)[columns] for group in groups]).T
        there = self.lengths_from([door for door, _ in out])[columns] + [far for _, far in out]
        home = self.lengths_to([door for door, _ in back])[columns] + [far for _, far in back]
        between[0, 1:], between[1:, 0] = there.min(axis=1), home.min(axis=1)
        return between

    def way(self, start: InAisle | Crossing, end: InAisle | Crossing) -> list[tuple[float, float]]:
        """Return the corner points of a shortest way between two places or crossings."""
        straight = np.inf
        if len(start) == 3 and len(end) == 3 and start[:2] == end[:2]:
            further = end[2] - start[2]
            if further == 0 or self._leads(*start[:2], "back" if further > 0 else "front"):
                straight = abs(further)
        best, corners = straight, []
        for exit_, out in self._gates(start, leaving=True):
            far = self.lengths_from([exit_])[..., 0]
            for entry, back in self._gates(end, leaving=False):
                if out + far[entry] + back < best - 1e-12:
                    best = out + far[entry] + back
                    path = [entry]
                    while path[-1] != exit_:
                        path.append(self._towards(path[-1], far))
                    corners = [self._xy(c) for c in reversed(path)]
        return without_repeats([self._xy(start), *corners, self._xy(end)])

    def _towards(self, at: Crossing, far: Floats) -> Crossing:
        """Return the neighbour that a shortest way comes from."""
        return min(self._sources(at), key=lambda step: float(far[step[0]]) + step[1])[0]

    def _gates(self, place: InAisle | Crossing, *, leaving: bool) -> list[tuple[Crossing, float]]:
        """Return the crossings that a place may be left, or entered, by, and how far they are."""
        if len(place) == 2:
            return [(place, 0.0)]
        aisle, block, y = place
        gates = []
        if self._leads(aisle, block, "front" if leaving else "back"):
            gates.append(((aisle, block), y))
        if self._leads(aisle, block, "back" if leaving else "front"):
            gates.append(((aisle, block + 1), self.block_lengths[block] - y))
        return gates

    def _xy(self, place: InAisle | Crossing) -> tuple[float, float]:
        y = sum(self.block_lengths[: place[1]]) + (place[2] if len(place) == 3 else 0.0)
        return place[0] * self.aisle_pitch, y


def _spread(far: Floats, up: Floats, down: Floats) -> None:
    """Shorten ``far`` in place by walking up and down its first axis."""
    for i in range(len(up)):
        np.minimum(far[i + 1], far[i] + up[i], out=far[i + 1])
    for i in reversed(range(len(down))):
        np.minimum(far[i], far[i + 1] + down[i], out=far[i])


def without_repeats(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return points without those that repeat the one before."""
    kept = points[:1]
    kept.extend(b for a, b in pairwise(points) if a != b)
    return kept
