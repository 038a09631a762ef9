"""What is said of a trip beside its way: number, robot, distance, stops and load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from qrobot._numbers import number
from qrobot.report.labels import text_width
from qrobot.report.palette import DEPOT, INK
from qrobot.report.scene import Journey, Scene

__all__ = ["DASHES", "GREY", "Legend", "Patch", "caption", "caption_width", "depot_marker"]

DASHES: tuple[Any, ...] = ("solid", (0, (5, 1.6)), (0, (2.2, 1.2)), (0, (6, 1.4, 1.4, 1.4)))
"""Of a robot's first, second, ... trip."""

GREY = "#5b6673"
ROW = 0.44
"""Height of a row, inches."""
NAME, FACTS = 9.5, 8.0
"""Sizes of the two lines of a row, points."""
MARK = 0.5
"""Room for the number and the sample of a way, inches."""
GAP = 0.2

Patch = tuple[str, str, str]
"""A row below the trips: label, face colour (nothing for a plain line of text), hatch."""

DEPOT_ROW: Patch = ("depot: start and end of every trip", "depot", "")
NUMBER_ROW: Patch = ("#1, #2, ...: number of the trip, as in the table", "", "")


@dataclass(frozen=True, slots=True)
class Legend:
    """How large the legend of a scene is, and how to draw it.

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
    """

    scene: Scene
    journeys: Sequence[Journey]
    patches: Sequence[Patch]
    room: float

    @property
    def rows(self) -> tuple[Journey | Patch, ...]:
        """All rows from the top."""
        return (*self.journeys, DEPOT_ROW, NUMBER_ROW, *self.patches)

    @property
    def per_column(self) -> int:
        """Rows in a column."""
        columns = -(-len(self.rows) // max(int(self.room / ROW), 1))
        return -(-len(self.rows) // columns)

    @property
    def columns(self) -> int:
        """Number of columns."""
        return -(-len(self.rows) // self.per_column)

    @property
    def pitch(self) -> float:
        """Width of a column, inches."""
        widths = [
            caption_width(self.scene, row) if isinstance(row, Journey) else _patch_width(row)
            for row in self.rows
        ]
        return max(widths) + GAP

    @property
    def width(self) -> float:
        """Width of all columns, inches."""
        return self.columns * self.pitch

    @property
    def height(self) -> float:
        """Height, inches."""
        return self.per_column * ROW

    def draw(self, panel: Any, corner: tuple[float, float]) -> None:
        """Draw into axes whose unit is an inch, with y downwards, from the top left corner."""
        pitch, (left, top) = self.pitch, corner
        for k, row in enumerate(self.rows):
            spot = left + pitch * (k // self.per_column), top + ROW * (k % self.per_column + 0.5)
            if isinstance(row, Journey):
                caption(panel, spot, self.scene, row)
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


def caption(panel: Any, spot: tuple[float, float], scene: Scene, journey: Journey) -> None:
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


def _patch(panel: Any, spot: tuple[float, float], row: Patch) -> None:
    (x, y), (label, face, hatch) = spot, row
    if face == "depot":
        panel.plot([x + 0.2], [y], **depot_marker(10))
    elif face:
        box = Rectangle((x + 0.07, y - 0.08), 0.26, 0.16, fc=face, ec="#9aa5b1", lw=0.6)
        box.set_hatch(hatch)
        panel.add_patch(box)
    panel.text(x + MARK, y, label, size=FACTS, va="center", color=INK if face else GREY)


def depot_marker(size: float) -> dict[str, Any]:
    """Return how the depot is drawn."""
    return {"ls": "none", "marker": "s", "ms": size, "mfc": DEPOT, "mec": INK, "mew": size / 11}
