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
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from qrobot.report.lanes import XY, Line, rounded
from qrobot.report.legend import DASHES, GREY, Legend, Patch, depot_marker
from qrobot.report.scene import Journey, Scene

__all__ = ["Canvas", "Look"]

POINTS = 72.0
MAP = (9.0, 6.6)  # inches, at most
LEAST = (3.8, 3.2)
TOP, EDGE = 0.92, 0.3
LEAST_LEGEND = 4.6


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
    patches
        Rows of the legend below the trips.
    frame
        Room for numbers at the left and the bottom of the map, inches.
    """

    def __init__(
        self, scene: Scene, low: XY, high: XY, patches: Sequence[Patch] = (), *, frame: float = 0.0
    ) -> None:
        width, height = max(high[0] - low[0], 1e-6), max(high[1] - low[1], 1e-6)
        crowd = 1 + 0.5 * min(scene.instance.size / 1000, 1)
        self.scale = min(MAP[0] * crowd / width, MAP[1] * crowd / height)
        inner = max(width * self.scale, LEAST[0]), max(height * self.scale, LEAST[1])
        legend = Legend(scene, patches, height=max(inner[1], LEAST_LEGEND))
        panel = (legend.pitch * legend.columns, legend.per_column * legend.row)
        tall = max(inner[1] + frame, panel[1])
        sheet = inner[0] + frame + 2 * EDGE + panel[0], tall + TOP + EDGE
        self.figure = Figure(figsize=sheet, facecolor="white")
        self.axes = self._axes(EDGE + frame, EDGE + frame, inner[0], tall - frame)
        spare = inner[0] / self.scale - width, (tall - frame) / self.scale - height
        self.axes.set_xlim(low[0] - spare[0] / 2, high[0] + spare[0] / 2)
        self.axes.set_ylim(low[1] - spare[1] / 2, high[1] + spare[1] / 2)
        self.axes.set_axis_off()
        beside = self._axes(sheet[0] - panel[0] - 0.1, EDGE, panel[0], tall)
        beside.set_axis_off()
        beside.set_xlim(0, panel[0])
        beside.set_ylim(tall, 0)
        legend.draw(beside)
        self._title(scene)

    def _axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        w, h = self.figure.get_size_inches()
        return self.figure.add_axes((left / w, bottom / h, width / w, height / h))

    def metres(self, points: float) -> float:
        """Return how many metres of the floor a length on the sheet is."""
        return points / POINTS / self.scale

    def points(self, metres: float) -> float:
        """Return how many points on the sheet a length of the floor is."""
        return metres * self.scale * POINTS

    def _title(self, scene: Scene) -> None:
        w, h = self.figure.get_size_inches()
        title = scene.title
        # A bold letter is about 0.7 of its size wide.
        size = min(15.0, (w - 2 * EDGE) * POINTS / (0.7 * len(title)))
        place = {"x": EDGE / w, "va": "center"}
        self.figure.text(y=1 - 0.36 / h, s=title, size=size, weight="bold", gid="title", **place)
        self.figure.text(y=1 - 0.66 / h, s=scene.subtitle, size=10.5, color=GREY, **place)

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
                self.axes.add_artist(PathPatch(path, ec=shade, lw=look.line + extra, **common))
        self.axes.add_artist(
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
            self.axes.add_artist(
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
        if line.heads is not None:
            return line.heads
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
        self.axes.plot([at[0]], [at[1]], gid="depot", zorder=8, **depot_marker(15))
        self.axes.annotate(
            "depot",
            at,
            xytext=label,
            textcoords="offset points",
            ha=align[0],
            va=align[1],
            size=10,
            weight="bold",
            bbox={"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.85},
            zorder=7.5,
        )


def _near(at: XY, stops: list[XY], distance: float) -> bool:
    """Return whether a stop lies near a point; the stops are sorted."""
    first = bisect_left(stops, (at[0] - distance, -math.inf))
    for stop in stops[first:]:
        if stop[0] > at[0] + distance:
            return False
        if abs(stop[1] - at[1]) < distance:
            return True
    return False
