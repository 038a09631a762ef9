"""The graph of the crossings of a warehouse of aisles, and shortest ways in it.

Nodes are the crossings of aisles and cross aisles. Slots hang inside the edges (the
sub-aisles), so the way between two slots is either straight along one sub-aisle or leads
over one end of each. Closed edges are left out, so detours and unreachable slots come out
by themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

__all__ = ["AisleGraph", "Crossing", "Door", "InAisle", "without_repeats"]

Crossing = tuple[int, int]
"""(aisle, cross aisle)"""
InAisle = tuple[int, int, float]
"""(aisle, block, distance from the block's front cross aisle)"""
Door = tuple[Crossing, float]
"""A crossing that the depot has a way to, and the length of that way."""


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

    def neighbours(self, at: Crossing) -> list[tuple[Crossing, float]]:
        """Return the crossings one step from `at` and the length of each step, metres."""
        aisle, cross = at
        found = []
        if aisle > 0 and (cross, aisle - 1) not in self.closed_crossings:
            found.append(((aisle - 1, cross), self.aisle_pitch))
        if aisle < self.aisles - 1 and (cross, aisle) not in self.closed_crossings:
            found.append(((aisle + 1, cross), self.aisle_pitch))
        if cross > 0 and (aisle, cross - 1) not in self.closed_aisles:
            found.append(((aisle, cross - 1), self.block_lengths[cross - 1]))
        if cross < self.cross_aisles - 1 and (aisle, cross) not in self.closed_aisles:
            found.append(((aisle, cross + 1), self.block_lengths[cross]))
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
        along = np.tile(np.array(self.block_lengths)[:, None], (self.aisles, 1, 1))
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
        self, places: Sequence[InAisle], doors: Sequence[Door]
    ) -> npt.NDArray[np.float64]:
        """Return all shortest ways between the depot and places inside aisles.

        Parameters
        ----------
        places
            n places inside sub-aisles.
        doors
            Where the ways from the depot lead to.

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
        columns = tuple(np.array(crossings).T)
        groups = [crossings[i : i + _TOGETHER] for i in range(0, len(crossings), _TOGETHER)]
        between = np.zeros((len(crossings) + 1,) * 2)  # row 0 is the depot
        between[1:, 1:] = np.hstack([self.lengths_from(group)[columns] for group in groups])
        out = self.lengths_from([door for door, _ in doors])[columns] + [far for _, far in doors]
        between[0, 1:] = between[1:, 0] = out.min(axis=1)
        offset = np.array([0.0, *(y for *_, y in places)], dtype=np.float64)
        closed = np.array([False, *((a, b) in self.closed_aisles for a, b, _ in places)])
        # Way from each place to its front and back crossing; the depot is its own.
        length = np.array([0.0, *(self.block_lengths[b] for _, b, _ in places)])
        reach = np.stack([offset, length - offset])
        reach[:, closed] = np.inf
        at = np.array([[0, 0], *([index[front], index[back]] for front, back in ends)]).T
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
        return without_repeats([self._xy(start), *corners, self._xy(end)])

    def _towards(self, at: Crossing, far: npt.NDArray[np.float64]) -> Crossing:
        """Return the neighbour that a shortest way comes from."""
        return min(self.neighbours(at), key=lambda step: float(far[step[0]]) + step[1])[0]

    def _exits(self, place: InAisle | Crossing) -> list[tuple[Crossing, float]]:
        if len(place) == 2:
            return [(place, 0.0)]
        aisle, block, y = place
        return [((aisle, block), y), ((aisle, block + 1), self.block_lengths[block] - y)]

    def _xy(self, place: InAisle | Crossing) -> tuple[float, float]:
        y = sum(self.block_lengths[: place[1]]) + (place[2] if len(place) == 3 else 0.0)
        return place[0] * self.aisle_pitch, y


def _spread(far: npt.NDArray[np.float64], steps: npt.NDArray[np.float64]) -> None:
    """Shorten ``far`` in place by walking up and down its first axis."""
    for i in range(len(steps)):
        np.minimum(far[i + 1], far[i] + steps[i], out=far[i + 1])
    for i in reversed(range(len(steps))):
        np.minimum(far[i], far[i + 1] + steps[i], out=far[i])


def without_repeats(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return points without those that repeat the one before."""
    kept = points[:1]
    kept.extend(b for a, b in pairwise(points) if a != b)
    return kept
