"""Texts on a sheet: how wide they are, and that none covers another or leaves the sheet."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text

from qrobot.report.lanes import XY

__all__ = ["Labels", "text_width"]

POINTS = 72.0
FINE = 1440.0
"""Dots per inch to measure with: widths are whole dots."""
APART = 0.6
"""Points between two texts."""


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
        FigureCanvasAgg(figure)
        figure.draw_without_rendering()
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
