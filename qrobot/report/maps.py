"""A map to scale: ways, stops and the depot, on axes where a metre has one length.

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
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from qrobot.report.labels import POINTS, Labels
from qrobot.report.lanes import XY, Track, rounded
from qrobot.report.palette import DASHES, depot_marker
from qrobot.report.scene import Journey

__all__ = ["Look", "Map"]


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


class Map:
    """Axes in which a metre has the same length in x and y.

    Parameters
    ----------
    axes
        To draw on.
    scale
        Inches of a metre.
    labels
        Keeps texts from covering each other.
    prefix
        Before the ids of what is drawn.
    """

    def __init__(self, axes: Any, scale: float, labels: Labels, prefix: str = "") -> None:
        self.axes = axes
        self.scale = scale
        self.labels = labels
        self.prefix = prefix

    def metres(self, points: float) -> float:
        """Return how many metres of the floor a length on the sheet is."""
        return points / POINTS / self.scale

    def points(self, metres: float) -> float:
        """Return how many points on the sheet a length of the floor is."""
        return metres * self.scale * POINTS

    def way(self, journey: Journey, line: Track, look: Look, *, bend: float) -> None:
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
                gid=f"{self.prefix}trip-{journey.number}-way",
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
                    gid=f"{self.prefix}trip-{journey.number}-arrows",
                )
            )

    def _spots(self, line: Track, look: Look) -> list[tuple[XY, XY]]:
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

    def heads(self, parts: Sequence[tuple[XY, XY]], look: Look, colour: str) -> None:
        """Draw an arrow head in the middle of each part of the floor that has a direction."""
        found = []
        for a, b in parts:
            if (length := math.dist(a, b)) > self.metres(look.arrow):
                middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
                ahead = (b[0] - a[0]) / length, (b[1] - a[1]) / length
                found.append(self._head(middle, ahead, look))
        if found:
            self.axes.add_artist(
                PolyCollection(found, fc=colour, lw=0, zorder=1.5, gid=f"{self.prefix}one-ways")
            )

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
                gid=f"{self.prefix}trip-{journey.number}-stops",
            )

    def depot(
        self,
        at: XY,
        *,
        size: float = 15,
        label: XY | None = None,
        align: tuple[str, str] = ("", ""),
    ) -> None:
        """Draw the depot and its label; gid ``depot``."""
        self.axes.plot([at[0]], [at[1]], gid=f"{self.prefix}depot", zorder=8, **depot_marker(size))
        if label is None:
            return
        text = self.axes.annotate(
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
        self.labels.first(text)

    def stops(self, journey: Journey, stops: Sequence[XY]) -> None:
        """Mark a trip's stops on a small map, numbered in sequence where there is room."""
        self.halts(journey, stops, size=9.0, face=journey.colour.fill)
        for k, at in enumerate(stops, 1):
            self.number(journey, at, str(k), 6.0)

    def number(self, journey: Journey, at: XY, text: str, size: float) -> None:
        """Write the number of a stop on its mark."""
        self.labels.add(
            self.axes.text(
                *at, text, size=size, color=journey.colour.text, weight="bold",
                ha="center", va="center_baseline", zorder=7,
            )
        )  # fmt: skip

    def tag(self, journey: Journey, line: Track) -> None:
        """Write the number of a trip on its way, where there is room for it."""
        legs = sorted(pairwise(line.corners), key=lambda leg: -math.dist(*leg))
        spots = [
            (a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share)
            for a, b in legs[:8]
            for share in (0.5, 0.3, 0.7)
        ]
        if spots:
            colour = journey.colour
            text = self.axes.text(
                *spots[0], journey.tag, size=6.5, weight="bold", color=colour.text, ha="center",
                va="center", zorder=7.2, clip_on=True,
                bbox={"boxstyle": "round,pad=0.2", "fc": colour.fill, "ec": colour.edge, "lw": 0.5},
            )  # fmt: skip
            self.labels.add(text, spots)


def _near(at: XY, stops: list[XY], distance: float) -> bool:
    """Return whether a stop lies near a point; the stops are sorted."""
    first = bisect_left(stops, (at[0] - distance, -math.inf))
    for stop in stops[first:]:
        if stop[0] > at[0] + distance:
            return False
        if abs(stop[1] - at[1]) < distance:
            return True
    return False
