"""The sheet of a picture: a title, a map of all trips, a legend, and a small map of each of many.

With many trips no map of all of them can be followed, so each gets one of its own below, under
its number, robot and load; the sheet grows with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from qrobot._text import shortened
from qrobot.report.labels import Labels, text_width
from qrobot.report.lanes import XY
from qrobot.report.legend import GREY, Legend, Patch, caption, caption_width
from qrobot.report.maps import Map
from qrobot.report.scene import Journey, Scene

__all__ = ["Canvas"]

MAP = (9.0, 6.6)  # inches, at most
LEAST = (3.8, 3.2)
TOP, EDGE = 0.92, 0.3
LEAST_LEGEND = 4.6
TITLES = (15.0, 9.0)
"""Points of a title, at most and at least; a longer one is cut."""
SUBTITLE = 10.5
FEW = 12
"""More trips than this get small maps of their own."""
MOST_PANELS = 120
CELL = (2.4, 2.5)
"""Inches: width at least and height of the map at most, of a trip's own map."""
GAP = 0.25
CAPTION = 0.46


class Canvas:
    """A figure with a map of all trips and, where they are many, one of each.

    Parameters
    ----------
    scene
        What is drawn.
    low, high
        Corners of the map, metres.
    patches
        Rows of the legend below the trips.
    frame
        Room for numbers at the left and the bottom of the map, inches.
    """

    def __init__(
        self, scene: Scene, low: XY, high: XY, patches: Sequence[Patch] = (), *, frame: float = 0.0
    ) -> None:
        size = max(high[0] - low[0], 1e-6), max(high[1] - low[1], 1e-6)
        crowd = 1 + 0.5 * min(scene.instance.size / 1000, 1)
        scale = min(MAP[0] * crowd / size[0], MAP[1] * crowd / size[1])
        inner = max(size[0] * scale, LEAST[0]), max(size[1] * scale, LEAST[1])
        many = len(scene.journeys) > FEW
        alone = scene.journeys[:MOST_PANELS] if many else ()
        legend = Legend(scene, () if many else scene.journeys, patches, max(inner[1], LEAST_LEGEND))
        tall = max(inner[1] + frame, legend.height)
        cell = max([CELL[0], *(caption_width(scene, j) for j in alone)])
        per_row = max(1, min(-(-len(alone) // 2), 4 if len(alone) <= 24 else 6))
        small = min(cell / size[0], CELL[1] / size[1])
        row = CAPTION + size[1] * small + GAP
        grid = per_row * (cell + GAP) - GAP, -(-len(alone) // per_row) * row if alone else 0.0
        longest = max(
            text_width(_cut(scene.title), TITLES[1], "bold"), text_width(scene.subtitle, 10.5)
        )
        wide = max(inner[0] + frame + EDGE + legend.width, grid[0] if alone else 0.0, longest)
        sheet = wide + 2 * EDGE, TOP + tall + EDGE + (EDGE + grid[1] if alone else 0.0)
        self.figure = Figure(figsize=sheet, facecolor="white")
        self.labels = Labels()
        bottom = sheet[1] - TOP - tall
        box = EDGE + frame, bottom + frame, inner[0], tall - frame
        self.main = self._map(box, scale, low, high, "")
        paper = self._axes(0.0, 0.0, *sheet)  # of inches, from the top left
        paper.set_axis_off()
        paper.set(xlim=(0, sheet[0]), ylim=(sheet[1], 0))
        legend.draw(paper, (2 * EDGE + frame + inner[0], TOP))
        self.panels: list[tuple[Journey, Map]] = []
        for k, journey in enumerate(alone):
            left = EDGE + (k % per_row) * (cell + GAP)
            top = bottom - EDGE - (k // per_row) * row
            caption(paper, (left, sheet[1] - top + CAPTION / 2), scene, journey)
            box = left, top - row + GAP, cell, row - CAPTION - GAP
            self.panels.append((journey, self._map(box, small, low, high, "alone-")))
        self._title(scene)
        if left_out := len(scene.journeys) - len(alone) if many else 0:
            self.figure.text(
                EDGE / sheet[0], 0.1 / sheet[1], f"and {left_out} more trips", size=8.5, color=GREY
            )

    def finish(self) -> Figure:
        """Return the figure when all is drawn."""
        self.labels.settle(self.figure)
        return self.figure

    def _axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        w, h = self.figure.get_size_inches()
        return self.figure.add_axes((left / w, bottom / h, width / w, height / h))

    def _map(
        self, box: tuple[float, float, float, float], scale: float, low: XY, high: XY, prefix: str
    ) -> Map:
        axes = self._axes(*box)
        spare = [(box[2 + k] / scale - (high[k] - low[k])) / 2 for k in (0, 1)]
        axes.set_xlim(low[0] - spare[0], high[0] + spare[0])
        axes.set_ylim(low[1] - spare[1], high[1] + spare[1])
        axes.set_axis_off()
        return Map(axes, scale, self.labels, prefix)

    def _title(self, scene: Scene) -> None:
        w, h = self.figure.get_size_inches()
        title = _cut(scene.title)
        fits = TITLES[1] * (w - 2 * EDGE) / max(text_width(title, TITLES[1], "bold"), 1e-6)
        size = max(TITLES[1], min(TITLES[0], 0.99 * fits))
        place = {"x": EDGE / w, "va": "center"}
        self.figure.text(y=1 - 0.36 / h, s=title, size=size, weight="bold", gid="title", **place)
        self.figure.text(y=1 - 0.66 / h, s=scene.subtitle, size=SUBTITLE, color=GREY, **place)


def _cut(title: str) -> str:
    return shortened(title, 140)
