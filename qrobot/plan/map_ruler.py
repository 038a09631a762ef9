"""The checker's own measure on maps and lanes; nothing of SciPy, nothing of their own graphs.

Over cells it is Dijkstra's algorithm, a ring at a time: no step is shorter than a cell, so all
cells whose lengths have the same whole part are settled together. A way over a map of half a
million cells takes some hundredths of a second like that.
"""

from __future__ import annotations

import cmath
import heapq
import math
from collections import defaultdict

import numpy as np
import numpy.typing as npt

from qrobot.problem.floor_map import FloorMap
from qrobot.problem.lane_network import LaneNetwork
from qrobot.problem.warehouse import Place, Point, Pose

__all__ = ["CellWalk", "LaneWalk"]

_Cells = npt.NDArray[np.intp]

_STEP = np.array([1.0] * 4 + [math.sqrt(2)] * 4)
"""Length of the step to each neighbour: right, left, up, down, and the diagonal ones."""

_BESIDE = ([2, 2, 3, 3], [0, 1, 0, 1])
"""The two straight neighbours that each diagonal step passes between."""


class CellWalk:
    """Measures ways over the cells of a map.

    Parameters
    ----------
    map_
        Where to measure.
    """

    def __init__(self, map_: FloorMap) -> None:
        self._map = map_
        self._names = dict(map_.poses)
        # A rim of cells that nobody enters, so that no step leaves the array.
        allowed = np.pad(_blocks(_standing(map_), map_.coarse), 1)
        self._width = allowed.shape[1]
        self._allowed = allowed.ravel()
        wide = self._width
        self._off = np.array([1, -1, wide, -wide, wide + 1, wide - 1, 1 - wide, -1 - wide])

    def __call__(self, start: Place | None, end: Place | None) -> float:
        """Return the length of a shortest way, ``inf`` without one; None is the depot."""
        a, b = self._cell(start), self._cell(end)
        if not (self._allowed[a] and self._allowed[b]):
            return math.inf
        return self._steps(a, b) * self._map.resolution * self._map.coarse

    def _cell(self, place: Place | None) -> int:
        place = self._map.depot_place if place is None else place
        at = self._names[place.name] if isinstance(place, Pose) else _xy(place)
        x, y, yaw = self._map.origin
        turned = (complex(*at) - complex(x, y)) * cmath.exp(-1j * yaw)
        side = self._map.resolution
        row, column = (
            math.floor(value / side + 1e-9) // self._map.coarse
            for value in (turned.imag, turned.real)
        )
        return int((row + 1) * self._width + column + 1)

    def _steps(self, start: int, end: int) -> float:
        """Return the length of a shortest way between two cells, in cells."""
        lengths = np.full(len(self._allowed), np.inf)
        lengths[start] = 0.0
        rings: defaultdict[int, list[_Cells]] = defaultdict(list)
        rings[0].append(np.array([start]))
        while rings:
            ring = min(rings)
            cells = np.unique(np.concatenate(rings.pop(ring)))
            # Some were reached again, by a shorter way that an earlier ring settled.
            cells = cells[lengths[cells] >= ring]
            if ring > lengths[end]:
                break
            reached = self._relax(cells, lengths)
            whole = lengths[reached].astype(np.intp)
            for value in range(ring + 1, ring + 3):
                if (part := reached[whole == value]).size:
                    rings[value].append(part)
        return float(lengths[end])

    def _relax(self, cells: _Cells, lengths: npt.NDArray[np.float64]) -> _Cells:
        """Shorten the ways to the neighbours of settled cells; return those that got shorter."""
        there = cells + self._off[:, None]
        ok = self._allowed[there]
        ok[4:] &= ok[_BESIDE[0]] & ok[_BESIDE[1]]  # past no corner
        length = lengths[cells] + _STEP[:, None]
        shorter = ok & (length < lengths[there])
        reached = there[shorter]
        np.minimum.at(lengths, reached, length[shorter])
        return np.asarray(reached)


def _xy(place: Place) -> tuple[float, float]:
    assert isinstance(place, Point)
    return place.x, place.y


def _standing(map_: FloorMap) -> npt.NDArray[np.bool_]:
    """Return where a robot may stand: no cell that is not free has its middle within the radius.

    Every cell that is not free, and all beside the map, covers a disc of others.
    """
    free = np.array([np.array(list(row)) == "." for row in map_.rows[::-1]])
    if map_.radius <= 0:
        return free
    reach = math.floor(map_.radius * (1 + 1e-9) / map_.resolution)
    # Beside the map nothing is known: one such cell may cover others as far as any wall.
    taken = np.pad(~free, reach + 1, constant_values=True)
    height, width = free.shape
    covered = np.zeros_like(free)
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            if math.hypot(down, right) * map_.resolution <= map_.radius * (1 + 1e-9):
                top, left = reach + 1 + down, reach + 1 + right
                covered |= taken[top : top + height, left : left + width]
    return np.asarray(free & ~covered)


def _blocks(cells: npt.NDArray[np.bool_], side: int) -> npt.NDArray[np.bool_]:
    """Return for each square of so many cells whether all are allowed, and none beyond the map."""
    height, width = cells.shape
    rows, columns = -(-height // side), -(-width // side)
    found = np.ones((rows, columns), dtype=bool)
    for down in range(side):
        for right in range(side):
            part = cells[down::side, right::side]
            found[: part.shape[0], : part.shape[1]] &= part
            found[part.shape[0] :, :] = False
            found[:, part.shape[1] :] = False
    return found


class LaneWalk:
    """Measures ways along lanes, by Dijkstra's algorithm.

    Parameters
    ----------
    network
        Where to measure.
    """

    def __init__(self, network: LaneNetwork) -> None:
        self._vertices = dict(network.poses)
        self._depot = network.depot_pose
        self._next: defaultdict[int, list[tuple[int, float]]] = defaultdict(list)
        for a, b in network.lanes:
            length = math.dist(network.vertices[a], network.vertices[b])
            self._next[a].append((b, length))

    def __call__(self, start: Place | None, end: Place | None) -> float:
        """Return the length of a shortest way, ``inf`` without one; None is the depot."""
        first, last = (
            self._vertices[place.name if isinstance(place, Pose) else self._depot]
            for place in (start, end)
        )
        queue, done = [(0.0, first)], set[int]()
        while queue:
            length, at = heapq.heappop(queue)
            if at == last:
                return length
            if at in done:
                continue
            done.add(at)
            for to, step in self._next[at]:
                if to not in done:
                    heapq.heappush(queue, (length + step, to))
        return math.inf
