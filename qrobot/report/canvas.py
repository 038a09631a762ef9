"""The sheet of a picture: a map to scale, a title above, the robots beside it.

A metre of the floor is a known number of points on the sheet, so that line widths, lanes
and arrows can be given in either.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

from qrobot.report.lanes import XY, Line, rounded
from qrobot.report.palette import DEPOT, INK
from qrobot.report.scene import Journey, Scene, number

__all__ = ["Canvas", "Look"]

POINTS = 72.0
MAP = (9.0, 6.6)  # inches, at most
LEAST = (3.8, 3.2)
PANEL, TOP, EDGE = 3.05, 0.92, 0.3
ROW = 0.44
MOST_ROWS = 40

SOLID: Any = "solid"
DASHES: tuple[Any, ...] = (SOLID, (0, (5, 1.6)), (0, (2.2, 1.2)), (0, (6, 1.4, 1.4, 1.4)))


@dataclass(frozen=True, slots=True)
class Look:
    """How ways are drawn; all in points.

    Parameters
    ----------
    line
        Width of a way.
    halo
        Width of the white rim that keeps crossing ways apart.
    arrow
        Length of an arrow head.
    every
        Distance between two arrows.
    """

    line: float
    halo: float
    arrow: float
    every: float


class Canvas:
    """A figure with one map, in which a metre has the same length in x and y.

    Parameters
    ----------
    scene
        What is drawn.
    low, high
        Corners of the map, metres.
    extra
        Rows of the legend below the robots: label, face colour and hatch of a patch.
    """

    def __init__(
        self, scene: Scene, low: XY, high: XY, extra: Sequence[tuple[str, str, str]] = ()
    ) -> None:
        self.scene = scene
        width, height = max(high[0] - low[0], 1e-6), max(high[1] - low[1], 1e-6)
        self.scale = min(MAP[0] / width, MAP[1] / height)
        inner = max(width * self.scale, LEAST[0]), max(height * self.scale, LEAST[1])
        rows = min(len(scene.journeys), MOST_ROWS) + len(extra) + 2
        columns = 1 + rows * ROW // (max(inner[1], MAP[1]) + 0.3)
        self._columns = int(columns)
        per_column = -(-rows // self._columns)
        sheet = (
            inner[0] + 2 * EDGE + PANEL * self._columns,
            max(inner[1], per_column * ROW) + TOP + EDGE,
        )
        self.figure = Figure(figsize=sheet, facecolor="white")
        self.axes = self._axes(EDGE, EDGE, inner[0], sheet[1] - TOP - EDGE)
        spare = (
            inner[0] / self.scale - width,
            (sheet[1] - TOP - EDGE) / self.scale - height,
        )
        self.axes.set_xlim(low[0] - spare[0] / 2, high[0] + spare[0] / 2)
        self.axes.set_ylim(low[1] - spare[1] / 2, high[1] + spare[1] / 2)
        self.axes.set_axis_off()
        self.sheet = sheet
        self._title()
        self._legend(extra, per_column)

    def _axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        w, h = self.figure.get_size_inches()
        return self.figure.add_axes((left / w, bottom / h, width / w, height / h))

    def metres(self, points: float) -> float:
        """Return how many metres of the floor a length on the sheet is."""
        return points / POINTS / self.scale

    def points(self, metres: float) -> float:
        """Return how many points on the sheet a length of the floor is."""
        return metres * self.scale * POINTS

    def _title(self) -> None:
        w, h = self.sheet
        title = self.scene.title
        size = min(15.0, 15.0 * (w - 2 * EDGE) * 7.6 / max(len(title), 1) / 1.0)
        self.figure.text(
            EDGE / w, 1 - 0.36 / h, title, size=size, weight="bold", va="center", gid="title"
        )
        self.figure.text(
            EDGE / w, 1 - 0.66 / h, self.scene.subtitle, size=10.5, color="#5b6673", va="center"
        )

    # -- the legend ------------------------------------------------------------------

    def _legend(self, extra: Sequence[tuple[str, str, str]], per_column: int) -> None:
        w, h = self.sheet
        panel = self._axes(
            w - PANEL * self._columns - 0.1, EDGE, PANEL * self._columns, h - TOP - EDGE
        )
        panel.set_axis_off()
        panel.set_xlim(0, PANEL * self._columns)
        panel.set_ylim(h - TOP - EDGE, 0)
        spots = [
            (PANEL * (i // per_column) + 0.25, ROW * (i % per_column) + 0.22)
            for i in range(per_column * self._columns)
        ]
        shown = self.scene.journeys[:MOST_ROWS]
        for (x, y), journey in zip(spots, shown, strict=False):
            self._robot_row(panel, x, y, journey)
        spots = spots[len(shown) :]
        if hidden := len(self.scene.journeys) - len(shown):
            x, y = spots.pop(0)
            panel.text(x, y, f"and {hidden} more trips", size=9, va="center")
        x, y = spots.pop(0)
        panel.plot([x + 0.17], [y], **_depot_marker(11))
        panel.text(x + 0.45, y, "depot: every trip starts and ends here", size=8.5, va="center")
        for (x, y), (label, face, hatch) in zip(spots, extra, strict=False):
            panel.add_patch(
                Rectangle(
                    (x + 0.04, y - 0.09), 0.26, 0.18, fc=face, ec="#9aa5b1", lw=0.6, hatch=hatch
                )
            )
            panel.text(x + 0.45, y, label, size=8.5, va="center")

    def _robot_row(self, panel: Any, x: float, y: float, journey: Journey) -> None:
        trip, colour = journey.trip, journey.colour
        dashes = DASHES[journey.turn % len(DASHES)]
        panel.add_line(
            Line2D([x, x + 0.34], [y, y], color=colour.edge, lw=5.2, solid_capstyle="round")
        )
        panel.add_line(
            Line2D(
                [x, x + 0.34], [y, y], color=colour.fill, lw=4, ls=dashes, solid_capstyle="round"
            )
        )
        stops = f"{len(trip.stops)} stop" + ("s" if len(trip.stops) != 1 else "")
        panel.text(x + 0.45, y - 0.085, journey.name, size=10, weight="bold", va="center")
        panel.text(
            x + 0.45,
            y + 0.1,
            f"{self.scene.length(trip.distance)}, {stops}, "
            f"load {number(trip.load)} of {number(journey.capacity)}",
            size=8.5,
            color="#5b6673",
            va="center",
        )

    # -- what is drawn on the map ------------------------------------------------------

    def way(self, journey: Journey, line: Line, look: Look, *, bend: float) -> None:
        """Draw a trip's way with its arrows; gid ``trip-<number>-way``."""
        steps = rounded(line.corners, bend)
        codes = {"move": Path.MOVETO, "line": Path.LINETO, "control": Path.CURVE3}
        path = Path(
            [point for _, point in steps], [codes.get(kind, Path.CURVE3) for kind, _ in steps]
        )
        colour, dashes = journey.colour, DASHES[journey.turn % len(DASHES)]
        level = 4 + journey.number * 1e-4
        common = {"fill": False, "capstyle": "round", "joinstyle": "round", "zorder": level}
        for extra, shade in ((look.halo, "white"), (look.line * 0.45, colour.edge)):
            if extra:
                self.axes.add_patch(PathPatch(path, ec=shade, lw=look.line + extra, **common))
        self.axes.add_patch(
            PathPatch(
                path,
                ec=colour.fill,
                lw=look.line,
                ls=dashes,
                gid=f"trip-{journey.number}-way",
                **common,
            )
        )
        heads = [self._head(at, ahead, look) for at, ahead in self._spots(line, look)]
        if heads:
            self.axes.add_collection(
                PolyCollection(
                    heads,
                    facecolors=colour.fill,
                    edgecolors=colour.edge,
                    linewidths=0.5,
                    zorder=level + 0.5,
                    gid=f"trip-{journey.number}-arrows",
                )
            )

    def _spots(self, line: Line, look: Look) -> list[tuple[XY, XY]]:
        """Return where arrows stand and their directions: not at corners, nor at stops."""
        found = []
        gap, least = self.metres(look.every), self.metres(look.arrow * 2.2)
        free = self.metres(look.arrow)
        stops = sorted(line.stops)
        for (ax, ay), (bx, by) in pairwise(line.corners):
            length = math.dist((ax, ay), (bx, by))
            if length < least:
                continue
            count = max(1, round(length / gap))
            ahead = ((bx - ax) / length, (by - ay) / length)
            for k in range(count):
                # Off the middle: the ways in and back out have their arrows apart.
                for shift in (0.0, 1.2, -1.2, 2.4, -2.4):
                    along = length * (k + 0.42) / count + shift * free
                    at = (ax + ahead[0] * along, ay + ahead[1] * along)
                    inside = free < along < length - free
                    if inside and not _near(at, stops, free):
                        found.append((at, ahead))
                        break
        return found

    def _head(self, at: XY, ahead: XY, look: Look) -> list[XY]:
        long, wide = self.metres(look.arrow), self.metres(look.arrow * 0.42)
        (x, y), (dx, dy) = at, ahead
        tip = (x + dx * long / 2, y + dy * long / 2)
        back = (x - dx * long / 2, y - dy * long / 2)
        return [
            tip,
            (back[0] - dy * wide, back[1] + dx * wide),
            (x - dx * long * 0.28, y - dy * long * 0.28),
            (back[0] + dy * wide, back[1] - dx * wide),
        ]

    def halts(
        self, journey: Journey, stops: Sequence[XY], *, size: float, face: str | None = None
    ) -> None:
        """Mark a trip's stops; gid ``trip-<number>-stops``."""
        if stops:
            self.axes.plot(
                [x for x, _ in stops],
                [y for _, y in stops],
                ls="none",
                marker="o",
                ms=size,
                mfc=face or "white",
                mec=journey.colour.edge,
                mew=min(0.9, size / 5),
                zorder=6,
                gid=f"trip-{journey.number}-stops",
            )

    def depot(self, at: XY, *, label: XY, align: tuple[str, str]) -> None:
        """Draw the depot and its label; gid ``depot``."""
        self.axes.plot([at[0]], [at[1]], gid="depot", zorder=8, **_depot_marker(15))
        self.axes.annotate(
            "depot",
            at,
            xytext=label,
            textcoords="offset points",
            ha=align[0],
            va=align[1],
            size=10,
            weight="bold",
            zorder=9,
        )


def _depot_marker(size: float) -> dict[str, Any]:
    return {"ls": "none", "marker": "s", "ms": size, "mfc": DEPOT, "mec": INK, "mew": 1.4}


def _near(at: XY, stops: list[XY], distance: float) -> bool:
    """Return whether a stop lies near a point; the stops are sorted."""
    first = bisect_left(stops, (at[0] - distance, -math.inf))
    for stop in stops[first:]:
        if stop[0] > at[0] + distance:
            return False
        if abs(stop[1] - at[1]) < distance:
            return True
    return False
