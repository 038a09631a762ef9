"""The sheet of a picture: a title, a map of all trips, a legend, and a small map of each of many.

With many trips no map of all of them can be followed, so each gets one of its own below, under
its number, robot and load; the sheet grows with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from qrobot._numbers import number
from qrobot._text import shortened
from qrobot.report.labels import Labels, text_width
from qrobot.report.lanes import XY
from qrobot.report.maps import Map
from qrobot.report.palette import DASHES, GREY, INK, depot_marker
from qrobot.report.scene import Journey, Scene

__all__ = ["Canvas", "Sheet"]

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
PANEL = (3.6, 3.0)
"""Inches of a map on a `Sheet`, at most."""

ROW = 0.44
"""Height of a row, inches."""
NAME, FACTS = 9.5, 8.0
"""Sizes of the two lines of a row, points."""
MARK = 0.5
"""Room for the number and the sample of a way, inches."""
LEGEND_GAP = 0.2

Patch = tuple[str, str, str]
"""A row below the trips: label, face colour (nothing for a plain line of text), hatch."""

DEPOT_ROW: Patch = ("depot: start and end of every trip", "depot", "")
NUMBER_ROW: Patch = ("#1, #2, ...: number of the trip, as in the table", "", "")


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
        self.main = _map_in(self.figure, box, scale, low, high, self.labels, "")
        paper = _axes_in(self.figure, 0.0, 0.0, *sheet)  # of inches, from the top left
        paper.set_axis_off()
        paper.set(xlim=(0, sheet[0]), ylim=(sheet[1], 0))
        legend.draw(paper, (2 * EDGE + frame + inner[0], TOP))
        self.panels: list[tuple[Journey, Map]] = []
        for k, journey in enumerate(alone):
            left = EDGE + (k % per_row) * (cell + GAP)
            top = bottom - EDGE - (k // per_row) * row
            caption(paper, (left, sheet[1] - top + CAPTION / 2), scene, journey)
            box = left, top - row + GAP, cell, row - CAPTION - GAP
            own = _map_in(self.figure, box, small, low, high, self.labels, "alone-")
            self.panels.append((journey, own))
        self._title(scene)
        if left_out := len(scene.journeys) - len(alone) if many else 0:
            self.figure.text(
                EDGE / sheet[0], 0.1 / sheet[1], f"and {left_out} more trips", size=8.5, color=GREY
            )

    def finish(self) -> Figure:
        """Return the figure when all is drawn."""
        self.labels.settle(self.figure)
        return self.figure

    def _title(self, scene: Scene) -> None:
        w, h = self.figure.get_size_inches()
        title = _cut(scene.title)
        fits = TITLES[1] * (w - 2 * EDGE) / max(text_width(title, TITLES[1], "bold"), 1e-6)
        size = max(TITLES[1], min(TITLES[0], 0.99 * fits))
        place = {"x": EDGE / w, "va": "center"}
        self.figure.text(y=1 - 0.36 / h, s=title, size=size, weight="bold", gid="title", **place)
        self.figure.text(y=1 - 0.66 / h, s=scene.subtitle, size=SUBTITLE, color=GREY, **place)


class Sheet:
    """A figure of equal maps in rows of at most four, each below its title.

    Parameters
    ----------
    title
        Of the figure.
    texts
        A title for each map.
    low, high
        Corners of the maps, metres.
    """

    def __init__(self, title: str, texts: Sequence[str], low: XY, high: XY) -> None:
        size = max(high[0] - low[0], 1e-6), max(high[1] - low[1], 1e-6)
        scale = min(PANEL[0] / size[0], PANEL[1] / size[1])
        cell = (
            max([size[0] * scale, *(text_width(t, NAME, "bold") for t in texts)]),
            size[1] * scale,
        )
        columns = min(4, len(texts))
        rows = -(-len(texts) // columns)
        wide = max(columns * (cell[0] + EDGE), text_width(_cut(title), TITLES[0], "bold") + EDGE)
        sheet = wide + EDGE, TOP + rows * (cell[1] + CAPTION + GAP)
        self.figure = Figure(figsize=sheet, facecolor="white")
        self.labels = Labels()
        place: dict[str, Any] = {"weight": "bold", "va": "center"}
        self.figure.text(
            EDGE / sheet[0], 1 - 0.4 / sheet[1], _cut(title), size=TITLES[0], gid="title", **place
        )
        self.maps: list[Map] = []
        for k, text in enumerate(texts):
            left = EDGE + k % columns * (cell[0] + EDGE)
            top = sheet[1] - TOP - k // columns * (cell[1] + CAPTION + GAP)
            self.figure.text(
                left / sheet[0], (top - CAPTION / 2) / sheet[1], text, size=NAME, **place
            )
            box = left, top - CAPTION - cell[1], *cell
            self.maps.append(_map_in(self.figure, box, scale, low, high, self.labels, f"map-{k}-"))

    def finish(self) -> Figure:
        """Return the figure when all is drawn."""
        self.labels.settle(self.figure)
        return self.figure


def _axes_in(figure: Figure, left: float, bottom: float, width: float, height: float) -> Any:
    w, h = figure.get_size_inches()
    return figure.add_axes((left / w, bottom / h, width / w, height / h))


def _map_in(
    figure: Figure,
    box: tuple[float, float, float, float],
    scale: float,
    low: XY,
    high: XY,
    labels: Labels,
    prefix: str,
) -> Map:
    """Return a map in the middle of a box of inches."""
    axes = _axes_in(figure, *box)
    spare = [(box[2 + k] / scale - (high[k] - low[k])) / 2 for k in (0, 1)]
    axes.set_xlim(low[0] - spare[0], high[0] + spare[0])
    axes.set_ylim(low[1] - spare[1], high[1] + spare[1])
    axes.set_axis_off()
    return Map(axes, scale, labels, prefix)


def _cut(title: str) -> str:
    return shortened(title, 140)


class Legend:
    """The rows beside the map: one for each trip, the depot, what the numbers mean.

    Parameters
    ----------
    scene
        What is drawn.
    journeys
        The trips that get a row.
    patches
        Rows below the trips.
    room
        Inches beside the map; a longer legend gets more columns.

    Attributes
    ----------
    width, height
        Inches.
    """

    def __init__(
        self, scene: Scene, journeys: Sequence[Journey], patches: Sequence[Patch], room: float
    ) -> None:
        self._scene = scene
        self._rows: list[Journey | Patch] = [*journeys, DEPOT_ROW, NUMBER_ROW, *patches]
        columns = -(-len(self._rows) // max(int(room / ROW), 1))
        self._per_column = -(-len(self._rows) // columns)
        self._pitch = LEGEND_GAP + max(
            caption_width(scene, row) if isinstance(row, Journey) else _patch_width(row)
            for row in self._rows
        )
        self.width = -(-len(self._rows) // self._per_column) * self._pitch
        self.height = self._per_column * ROW

    def draw(self, panel: Any, corner: XY) -> None:
        """Draw into axes whose unit is an inch, with y downwards, from the top left corner."""
        for k, row in enumerate(self._rows):
            column, line = divmod(k, self._per_column)
            spot = corner[0] + self._pitch * column, corner[1] + ROW * (line + 0.5)
            if isinstance(row, Journey):
                caption(panel, spot, self._scene, row)
            else:
                _patch(panel, spot, row)


def _lines(scene: Scene, journey: Journey) -> tuple[str, str]:
    trip = journey.trip
    stops = f"{number(len(trip.stops))} stop" + ("s" if len(trip.stops) != 1 else "")
    load = f"{number(trip.load)} of {number(journey.capacity)}"
    return journey.name, f"{scene.length(trip.distance)}, {stops}, load {load}"


def caption_width(scene: Scene, journey: Journey) -> float:
    """Return the width of `caption`, inches."""
    name, facts = _lines(scene, journey)
    return MARK + max(text_width(name, NAME, "bold"), text_width(facts, FACTS)) + 0.05


def caption(panel: Any, spot: XY, scene: Scene, journey: Journey) -> None:
    """Write a trip's number, robot and figures, into axes whose unit is an inch."""
    (x, y), colour = spot, journey.colour
    name, facts = _lines(scene, journey)
    box = Rectangle((x, y - 0.16), MARK - 0.1, 0.2, fc=colour.fill, ec=colour.edge, lw=0.8)
    panel.add_patch(box)
    panel.text(
        x + MARK / 2 - 0.05, y - 0.06, journey.tag, size=7.5, weight="bold", color=colour.text,
        ha="center", va="center",
    )  # fmt: skip
    for shade, width, dashes in (
        (colour.edge, 3.2, DASHES[0]),
        (colour.fill, 2.2, DASHES[journey.turn % len(DASHES)]),
    ):
        sample = Line2D(
            [x, x + MARK - 0.1], [y + 0.12, y + 0.12],
            color=shade, lw=width, ls=dashes, solid_capstyle="butt",
        )  # fmt: skip
        panel.add_line(sample)
    panel.text(x + MARK, y - 0.085, name, size=NAME, weight="bold", va="center")
    panel.text(x + MARK, y + 0.1, facts, size=FACTS, color=GREY, va="center")


def _patch_width(row: Patch) -> float:
    return MARK + text_width(row[0], FACTS) + 0.05


def _patch(panel: Any, spot: XY, row: Patch) -> None:
    (x, y), (label, face, hatch) = spot, row
    if face == "depot":
        panel.plot([x + 0.2], [y], **depot_marker(10))
    elif face:
        box = Rectangle((x + 0.07, y - 0.08), 0.26, 0.16, fc=face, ec="#9aa5b1", lw=0.6)
        box.set_hatch(hatch)
        panel.add_patch(box)
    panel.text(x + MARK, y, label, size=FACTS, va="center", color=INK if face else GREY)
