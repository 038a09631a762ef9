"""What stands behind the ways on a map and on lanes: walls, the lanes themselves, their extent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from qrobot._arrays import Bools
from qrobot.problem import FloorMap, LaneNetwork, Warehouse
from qrobot.problem.floor_map import OCCUPIED, UNKNOWN
from qrobot.report.lanes import XY, Track

__all__ = ["beside", "extent", "is_drawn", "shades", "walls"]

FINEST = 240
"""Cells along the longer side of the walls of a page; finer maps are drawn coarser."""

WALL, UNSEEN, MARGIN = (0xB4, 0xBE, 0xC9), (0xE9, 0xED, 0xF1), (0xF6, 0xF0, 0xE6)
"""Colours of what is occupied, unknown, and too near to it for a robot's middle."""


def is_drawn(house: Warehouse) -> bool:
    """Return whether a warehouse has ways of its own with corners, behind which it is drawn."""
    return isinstance(house, FloorMap | LaneNetwork)


def extent(house: FloorMap | LaneNetwork) -> tuple[float, float, float, float]:
    """Return least x and y and largest x and y of what is drawn: the known part of a map."""
    if isinstance(house, LaneNetwork):
        return house.bounds
    known = _cells(house) != ord(UNKNOWN)
    if not known.any():
        return house.bounds
    rows, columns = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    side = house.resolution
    ends = [(float(k[0]) * side, float(k[-1] + 1) * side) for k in (columns, rows)]
    xs, ys = zip(*(house.on_floor(x, y) for x in ends[0] for y in ends[1]), strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def shades(house: FloorMap) -> Any:
    """Return the colours of all cells, the row of the least y first, shape (rows, columns, 3)."""
    cells = _cells(house)
    found = np.full((*cells.shape, 3), 255, dtype=np.uint8)
    found[~house.clear] = MARGIN
    found[cells == ord(UNKNOWN)] = UNSEEN
    found[cells == ord(OCCUPIED)] = WALL
    return found


def _cells(house: FloorMap) -> Any:
    text = "".join(reversed(house.rows)).encode()
    return np.frombuffer(text, dtype=np.uint8).reshape(len(house.rows), -1)


def walls(house: FloorMap) -> list[list[XY]]:
    """Return what is occupied as rectangles, each by its corners, metres."""
    taken = np.asarray(_cells(house) == ord(OCCUPIED))
    side = -(-max(taken.shape) // FINEST)
    taken = _coarser(taken, side)
    found = []
    for low, high, left, right in _rectangles(taken):
        a, b, c, d = (v * side * house.resolution for v in (left, low, right, high))
        found.append([house.on_floor(*at) for at in ((a, b), (c, b), (c, d), (a, d))])
    return found


def _coarser(cells: Bools, side: int) -> Bools:
    """Return for each square of so many cells whether any is set."""
    height, width = (-(-n // side) * side for n in cells.shape)
    padded = np.zeros((height, width), dtype=bool)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    blocks = padded.reshape(height // side, side, width // side, side)
    return np.asarray(blocks.any(axis=(1, 3)))


def _rectangles(cells: Bools) -> list[tuple[int, int, int, int]]:
    """Return rectangles that cover the set cells: first and last row, first and last column.

    The last ones are excluded. Equal runs of neighbouring rows are one.
    """
    growing: dict[tuple[int, int], int] = {}
    found = []
    for row in range(cells.shape[0] + 1):
        line = cells[row] if row < cells.shape[0] else np.zeros(cells.shape[1], dtype=bool)
        edges = np.flatnonzero(np.diff(np.concatenate(([False], line, [False]))))
        runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
        ended = [run for run in growing if run not in runs]
        found += [(growing.pop(run), row, *run) for run in ended]
        for run in runs:
            growing.setdefault(run, row)
    return found


def beside(trips: Sequence[Sequence[Sequence[XY]]], step: float, most: float) -> list[Track]:
    """Return the ways of trips, each to the right of its way by a distance of its own.

    So a way there and back shows as two lines, and no trip hides another.

    Parameters
    ----------
    trips
        For each the legs, each the corner points from one stop to the next.
    step
        Wanted distance between two lines, metres.
    most
        Of the last one from its way.
    """
    step = min(step, most / max(1, len(trips)))
    found = []
    for k, legs in enumerate(trips):
        corners = [legs[0][0], *(point for leg in legs for point in leg[1:])]
        found.append(Track(_shifted(corners, step * (k + 0.5)), [leg[-1] for leg in legs[:-1]]))
    return found


def _shifted(corners: Sequence[XY], off: float) -> list[XY]:
    """Return a line at a distance to the right of another."""
    line = [corners[0], *(b for a, b in pairwise(corners) if math.dist(a, b) > 1e-9)]
    if len(line) < 2:
        return line
    sides = []
    for (ax, ay), (bx, by) in pairwise(line):
        length = math.dist((ax, ay), (bx, by))
        sides.append(((by - ay) / length, -(bx - ax) / length))
    found = [_moved(line[0], sides[0], off)]
    for at, (ax, ay), (bx, by) in zip(line[1:], sides, sides[1:], strict=False):
        bend = 1 + ax * bx + ay * by
        if bend < 0.3:  # it turns back: round the end
            found += [_moved(at, (ax, ay), off), _moved(at, (bx, by), off)]
        else:
            found.append(_moved(at, ((ax + bx) / bend, (ay + by) / bend), off))
    return [*found, _moved(line[-1], sides[-1], off)]


def _moved(at: XY, side: XY, off: float) -> XY:
    return at[0] + side[0] * off, at[1] + side[1] * off
