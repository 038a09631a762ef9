"""The legend beside a map: every trip with its colour, distance and load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from qrobot.report.palette import DEPOT, INK
from qrobot.report.scene import Journey, Scene, number
from qrobot.report.text import shortened

__all__ = ["DASHES", "GREY", "Legend", "Patch", "depot_marker"]

DASHES: tuple[Any, ...] = ("solid", (0, (5, 1.6)), (0, (2.2, 1.2)), (0, (6, 1.4, 1.4, 1.4)))
"""Of a robot's first, second, ... trip."""

GREY = "#5b6673"
MOST_TRIPS = 60

Patch = tuple[str, str, str]
"""A row below the trips: label, face colour (nothing for a plain line of text), hatch."""


@dataclass(frozen=True, slots=True)
class Legend:
    """How large the legend of a scene is, and how to draw it.

    Parameters
    ----------
    scene
        What is drawn.
    patches
        Rows below the trips.
    height
        Inches beside the map; a longer legend gets more columns.
    """

    scene: Scene
    patches: Sequence[Patch]
    height: float

    @property
    def short(self) -> bool:
        """Whether there are so many trips that each gets one line."""
        return len(self.scene.journeys) > 12

    @property
    def row(self) -> float:
        """Height of a row, inches."""
        return 0.235 if self.short else 0.44

    @property
    def rows(self) -> int:
        """Number of rows, the depot's and the patches' among them."""
        trips = len(self.scene.journeys)
        return min(trips, MOST_TRIPS) + (trips > MOST_TRIPS) + 1 + len(self.patches)

    @property
    def columns(self) -> int:
        """Number of columns."""
        return -(-self.rows // max(int(self.height / self.row), 1))

    @property
    def per_column(self) -> int:
        """Rows in a column."""
        return -(-self.rows // self.columns)

    @property
    def pitch(self) -> float:
        """Width of a column, inches."""
        return 3.05 if not self.short or self.columns == 1 else 2.75

    def draw(self, panel: Any) -> None:
        """Draw into axes whose unit is an inch, with y downwards from the top."""
        spots = [
            (
                self.pitch * (i // self.per_column) + 0.25,
                self.row * (i % self.per_column + 0.5),
            )
            for i in range(self.per_column * self.columns)
        ]
        shown = self.scene.journeys[:MOST_TRIPS]
        for spot, journey in zip(spots, shown, strict=False):
            self._trip(panel, spot, journey)
        spots = spots[len(shown) :]
        size = 8.0 if self.short else 8.5
        if hidden := len(self.scene.journeys) - len(shown):
            x, y = spots.pop(0)
            panel.text(x + 0.45, y, f"and {hidden} more trips", size=size, va="center")
        x, y = spots.pop(0)
        panel.plot([x + 0.17], [y], **depot_marker(9 if self.short else 11))
        panel.text(x + 0.45, y, "depot: start and end of every trip", size=size, va="center")
        for (x, y), (label, face, hatch) in zip(spots, self.patches, strict=False):
            if face:
                box = Rectangle((x + 0.04, y - 0.08), 0.26, 0.16, fc=face, ec="#9aa5b1", lw=0.6)
                box.set_hatch(hatch)
                panel.add_patch(box)
            panel.text(x + 0.45, y, label, size=size, va="center", color=INK if face else GREY)

    def _trip(self, panel: Any, spot: tuple[float, float], journey: Journey) -> None:
        (x, y), trip, colour = spot, journey.trip, journey.colour
        thick = 3.0 if self.short else 4.0
        for shade, width, dashes in (
            (colour.edge, thick + 1.2, DASHES[0]),
            (colour.fill, thick, DASHES[journey.turn % len(DASHES)]),
        ):
            panel.add_line(
                Line2D(
                    [x, x + 0.34], [y, y],
                    color=shade, lw=width, ls=dashes, solid_capstyle="round",
                )
            )  # fmt: skip
        stops = f"{len(trip.stops)} stop" + ("s" if len(trip.stops) != 1 else "")
        load = f"{number(trip.load)} of {number(journey.capacity)}"
        length = self.scene.length(trip.distance)
        if self.short:
            name = shortened(journey.name, 18)
            panel.text(x + 0.45, y, name, size=8.5, weight="bold", va="center")
            facts = f"{length}, {stops}, load {load}"
            at, size = (x + 0.55 + 0.075 * max(len(name), 3), y), 7.5
        else:
            name = journey.name
            panel.text(x + 0.45, y - 0.085, name, size=10, weight="bold", va="center")
            facts = f"{length}, {stops}, load {load}"
            at, size = (x + 0.45, y + 0.1), 8.5
        panel.text(*at, facts, size=size, color=GREY, va="center")


def depot_marker(size: float) -> dict[str, Any]:
    """Return how the depot is drawn."""
    return {"ls": "none", "marker": "s", "ms": size, "mfc": DEPOT, "mec": INK, "mew": 1.4}
