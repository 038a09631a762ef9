"""Where small labels stand: beside their points, clear of marks, ways and each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from qrobot.report.lanes import XY

__all__ = ["Spot", "placed", "spread"]

Spot = tuple[XY, str, str]
"""Offset of a label from its point, horizontal and vertical alignment."""

SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1))


def placed(
    points: Sequence[XY],
    sizes: Sequence[XY],
    radius: float,
    marks: Sequence[tuple[XY, float]],
    ways: Sequence[Sequence[XY]],
) -> list[Spot]:
    """Choose a side of every point for its label, the least crowded one.

    Parameters
    ----------
    points
        What is labelled; every length here is in points of the sheet.
    sizes
        Width and height of each label.
    radius
        Of the points' own marks.
    marks
        Centres and radii of all marks.
    ways
        Corner points of lines that labels should not cover.
    """
    taken: list[tuple[float, float, float, float]] = []
    dots = [dot for way in ways for dot in _dots(way)]
    found = []
    for (x, y), (width, height) in zip(points, sizes, strict=True):
        options = []
        for rank, (sx, sy) in enumerate(SIDES):
            away = radius * (0.72 if sx and sy else 1.0) + 2.0
            left = x + sx * away - (width / 2 if not sx else width if sx < 0 else 0)
            low = y + sy * away - (height / 2 if not sy else height if sy < 0 else 0)
            box = (left, low, left + width, low + height)
            cost = 0.05 * rank
            cost += sum(1.0 for dot in dots if _inside(dot, box, 0.5)) * 0.4
            cost += sum(6.0 for at, r in marks if _inside(at, box, r))
            cost += sum(99.0 for other in taken if _overlap(box, other))
            options.append((cost, rank, box, (sx, sy), away))
        _, _, box, (sx, sy), away = min(options)
        taken.append(box)
        found.append(
            (
                (sx * away, sy * away),
                ("right", "center", "left")[sx + 1],
                ("top", "center", "bottom")[sy + 1],
            )
        )
    return found


def _dots(way: Sequence[XY], every: float = 3.0) -> list[XY]:
    found = []
    for (ax, ay), (bx, by) in pairwise(way):
        count = max(1, int(math.dist((ax, ay), (bx, by)) / every))
        found += [(ax + (bx - ax) * k / count, ay + (by - ay) * k / count) for k in range(count)]
    return found


def _inside(at: XY, box: tuple[float, float, float, float], rim: float) -> bool:
    return box[0] - rim < at[0] < box[2] + rim and box[1] - rim < at[1] < box[3] + rim


def _overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def spread(points: Sequence[XY], gap: float) -> list[XY]:
    """Move points that coincide apart, side by side around where they are."""
    crowds: dict[XY, list[int]] = {}
    for index, point in enumerate(points):
        crowds.setdefault(point, []).append(index)
    found = list(points)
    for (x, y), members in crowds.items():
        wide = math.ceil(math.sqrt(len(members)))
        rows = -(-len(members) // wide)
        for k, index in enumerate(members):
            row, column = divmod(k, wide)
            across = min(wide, len(members) - row * wide)
            found[index] = (
                x + (column - (across - 1) / 2) * gap,
                y - (row - (rows - 1) / 2) * gap,
            )
    return found
