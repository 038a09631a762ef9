"""Labels: how wide texts are, on which side of a point each stands, and that none hides another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text

from qrobot.report.lanes import XY

__all__ = ["POINTS", "Labels", "Spot", "placed", "spread", "text_width"]

POINTS = 72.0
FINE = 1440.0
"""Dots per inch to measure with: widths are whole dots."""
APART = 0.6
"""Points between two texts."""

Spot = tuple[XY, str, str]
"""Offset of a label from its point, horizontal and vertical alignment."""

SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1))


@lru_cache(maxsize=1)
def _renderer() -> Any:
    return RendererAgg(8, 8, FINE)


def text_width(text: str, size: float, weight: str = "normal") -> float:
    """Return the width of a line of text in inches, in the fonts that are set."""
    font = FontProperties(size=size, weight=weight)
    width, _, _ = _renderer().get_text_width_height_descent(text, font, False)
    return float(width) / FINE


class Labels:
    """Texts that may be left out; those that are not added here are always shown.

    An unreadable text tells nothing, so one that would cover another is hidden: those that were
    added later give way.
    """

    def __init__(self) -> None:
        self._first: list[Text] = []
        self._later: list[tuple[Text, Sequence[XY]]] = []

    def first(self, text: Text) -> None:
        """Add a text before which all others give way."""
        self._first.append(text)

    def add(self, text: Text, spots: Sequence[XY] = ()) -> None:
        """Add a text, with the places where it may stand as well as at its own."""
        self._later.append((text, spots))

    def settle(self, figure: Figure) -> None:
        """Hide what covers another text or leaves the sheet; call it when all is drawn."""
        # Axes stand where they were put and ticks are made when they are asked for: texts can be
        # measured without a drawing of the figure.
        FigureCanvasAgg(figure)
        renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
        width, height = figure.bbox.width, figure.bbox.height
        apart = APART * figure.dpi / POINTS
        ticks = [
            text
            for axes in figure.axes
            if axes.axison
            for text in (*axes.get_xticklabels(), *axes.get_yticklabels())
        ]
        own = {id(text) for text in (*self._first, *(text for text, _ in self._later))}
        every = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
        fixed = [text for text in every if id(text) not in own]
        taken = np.empty((len(ticks) + len(every), 4))
        count = 0

        def fits(text: Text) -> bool:
            nonlocal count
            box = np.asarray(text.get_window_extent(renderer).extents)
            low, high = box[:2] - apart, box[2:] + apart
            others = taken[:count]
            covers = (others[:, :2] < high).all(axis=1) & (others[:, 2:] > low).all(axis=1)
            inside = (box[:2] >= 0).all() and box[2] <= width and box[3] <= height
            if covers.any() or not inside:
                return False
            taken[count] = box
            count += 1
            return True

        for text in fixed:
            if not fits(text):
                taken[count] = text.get_window_extent(renderer).extents  # shown all the same
                count += 1
        for text in (*self._first, *ticks):
            text.set_visible(fits(text))
        for text, spots in self._later:
            text.set_visible(fits(text) or any(_moved(text, spot, fits) for spot in spots[1:]))


def _moved(text: Text, spot: XY, fits: Any) -> bool:
    text.set_position(spot)
    return bool(fits(text))


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
