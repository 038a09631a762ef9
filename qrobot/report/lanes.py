"""Lanes: how ways that run along the same aisle are drawn beside each other.

A way along aisles is a chain of straight runs. Runs of one corridor (one aisle, one cross
aisle) that overlap get lanes of their own, so that no way hides another and a way in and
back out again shows as two lines. Everything is in metres of the floor.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

__all__ = ["XY", "Lanes", "Track", "rounded"]

XY = tuple[float, float]

CLOSE = 1e-9


@dataclass(slots=True)
class Track:
    """A way, ready to draw.

    Parameters
    ----------
    corners
        Its corner points.
    stops
        Where it halts, in sequence.
    heads
        Where its arrows stand and their directions of length 1; ``None`` leaves it to the
        one who draws.
    """

    corners: list[XY]
    stops: list[XY]
    heads: list[tuple[XY, XY]] | None = None


@dataclass(slots=True)
class _Run:
    """A straight part of a way: along x (axis 0) or along y (axis 1)."""

    trip: int
    index: int
    axis: int
    across: float
    start: float
    end: float
    stops: list[tuple[int, float]] = field(default_factory=list)
    wish: int = 0
    lane: int = 0
    lanes: int = 1
    off: float = 0.0

    @property
    def low(self) -> float:
        return min(self.start, self.end)

    @property
    def high(self) -> float:
        return max(self.start, self.end)

    def at(self, along: float) -> XY:
        across = self.across + self.off
        return (along, across) if self.axis == 0 else (across, along)


class Lanes:
    """The lanes of several ways.

    Parameters
    ----------
    ways
        For each trip its legs, each the corner points from one stop to the next. A slanting
        part, such as a further way of the depot, is drawn with a corner.
    margin
        Runs of one corridor that come closer than this do not share a lane.
    """

    def __init__(self, ways: Sequence[Sequence[Sequence[XY]]], *, margin: float) -> None:
        self._ways = ways
        self._chains = [_runs(trip, legs) for trip, legs in enumerate(ways)]
        corridors: defaultdict[tuple[int, float], list[_Run]] = defaultdict(list)
        for runs in self._chains:
            _wishes(runs)
            for run in runs:
                corridors[run.axis, round(run.across, 6)].append(run)
        self._groups = [g for runs in corridors.values() for g in _touching(runs, margin)]
        for group in self._groups:
            _assign(group, margin)

    def widest_gap(self, widths: tuple[float, float]) -> float:
        """Return the gap between two lanes that the most crowded corridor has room for.

        Parameters
        ----------
        widths
            Room for the lanes of a corridor along x and of one along y.
        """
        return min((widths[g[0].axis] / g[0].lanes for g in self._groups), default=math.inf)

    def lines(self, *, step: float, widths: tuple[float, float]) -> list[Track]:
        """Return the ways in their lanes.

        Parameters
        ----------
        step
            Wanted gap between two lanes; where more lanes than fit, they stand closer.
        widths
            Room for the lanes of a corridor along x and of one along y.

        Returns
        -------
        list of Track
            One for each trip; its stops are the ends of all legs but the last.
        """
        for group in self._groups:
            for run in group:
                gap = min(step, widths[run.axis] / run.lanes)
                run.off = (run.lane - (run.lanes - 1) / 2) * gap
        return [
            _joined(runs) if runs else Track([legs[0][0]], [leg[-1] for leg in legs[:-1]])
            for runs, legs in zip(self._chains, self._ways, strict=True)
        ]


def _runs(trip: int, legs: Sequence[Sequence[XY]]) -> list[_Run]:
    """Cut a chain of legs into straight runs; a run goes on through stops."""
    runs: list[_Run] = []
    waiting: list[int] = []  # stops before the first move
    for number, leg in enumerate(legs):
        for a, b in pairwise(_square(leg, out=number == 0)):
            dx, dy = b[0] - a[0], b[1] - a[1]
            if abs(dx) < CLOSE and abs(dy) < CLOSE:
                continue
            axis = 0 if abs(dx) >= abs(dy) else 1
            ahead = (b[axis] - a[axis]) > 0
            last = runs[-1] if runs else None
            if last is not None and last.axis == axis and (last.end > last.start) == ahead:
                last.end = b[axis]
            else:
                runs.append(_Run(trip, len(runs), axis, a[1 - axis], a[axis], b[axis]))
                runs[-1].stops += [(stop, a[axis]) for stop in waiting]
                waiting.clear()
        if number < len(legs) - 1:
            if runs:
                runs[-1].stops.append((number, runs[-1].end))
            else:
                waiting.append(number)
    return runs


def _square(leg: Sequence[XY], *, out: bool) -> list[XY]:
    """Return a leg with a corner in each slanting part: beside its end at the depot."""
    points = list(leg[:1])
    for a, b in pairwise(leg):
        if abs(a[0] - b[0]) >= CLOSE and abs(a[1] - b[1]) >= CLOSE:
            points.append((b[0], a[1]) if out else (a[0], b[1]))
        points.append(b)
    return points


def _wishes(runs: list[_Run]) -> None:
    """Let each run wish for the side that its neighbours come from and go to."""
    for before, run in pairwise(runs):
        if before.axis != run.axis:
            run.wish += -1 if before.end > before.start else 1
            before.wish += 1 if run.end > run.start else -1


def _touching(runs: list[_Run], margin: float) -> list[list[_Run]]:
    """Group the runs of one corridor that overlap, directly or over others."""
    groups: list[list[_Run]] = []
    reach = -math.inf
    for run in sorted(runs, key=lambda r: (r.low, r.trip, r.index)):
        if run.low > reach + margin:
            groups.append([])
        groups[-1].append(run)
        reach = max(reach, run.high)
    return groups


def _assign(group: list[_Run], margin: float) -> None:
    """Put each run into the first free lane.

    The runs of a trip lie beside each other, those that turn off to one side on that side,
    long ones outside: that way few ways cross.
    """
    wishes: defaultdict[int, list[int]] = defaultdict(list)
    for run in group:
        wishes[run.trip].append(run.wish)
    mean = {trip: sum(found) / len(found) for trip, found in wishes.items()}
    reach = {run.trip: 0.0 for run in group}
    for run in group:
        reach[run.trip] = max(reach[run.trip], run.high - run.low)

    def rank(run: _Run) -> tuple[float, ...]:
        outside = reach[run.trip] if mean[run.trip] < 0 else -reach[run.trip]
        return mean[run.trip], outside, run.trip, run.wish, run.index

    lanes: list[list[_Run]] = []
    for run in sorted(group, key=rank):
        run.lane = next(
            (lane for lane, taken in enumerate(lanes) if _free(taken, run, margin)), len(lanes)
        )
        if run.lane == len(lanes):
            lanes.append([])
        lanes[run.lane].append(run)
    for run in group:
        run.lanes = len(lanes)


def _free(taken: list[_Run], run: _Run, margin: float) -> bool:
    return all(run.low > r.high + margin or r.low > run.high + margin for r in taken)


def _joined(runs: list[_Run]) -> Track:
    corners = [runs[0].at(runs[0].start)]
    halts: dict[int, XY] = {}
    for run, after in zip(runs, [*runs[1:], None], strict=True):
        turn = after is not None and after.axis == run.axis
        for stop, along in run.stops:
            halts[stop] = run.at(along)
            if after is not None and along == run.end:
                if turn:  # the middle of the cap
                    (ax, ay), (bx, by) = run.at(along), after.at(after.start)
                    halts[stop] = (ax + bx) / 2, (ay + by) / 2
                else:
                    halts[stop] = _corner(run, after)
        if after is None:
            corners.append(run.at(run.end))
        elif turn:
            corners += [run.at(run.end), after.at(after.start)]
        else:
            corners.append(_corner(run, after))
    return Track(corners, [halts[stop] for stop in sorted(halts)])


def _corner(run: _Run, after: _Run) -> XY:
    across, along = run.across + run.off, after.across + after.off
    return (along, across) if run.axis == 0 else (across, along)


def rounded(corners: Sequence[XY], radius: float) -> list[tuple[str, XY]]:
    """Return drawing steps for a line with round corners.

    Returns
    -------
    list of tuple
        ``("move", point)``, ``("line", point)`` or ``("control", point)``; a control point
        is followed by the ``("curve", point)`` that the quadratic curve ends at.
    """
    points = [corners[0], *(b for a, b in pairwise(corners) if a != b)]
    steps: list[tuple[str, XY]] = [("move", points[0])]
    for before, at, after in zip(points, points[1:], points[2:], strict=False):
        r = min(radius, math.dist(before, at) / 2, math.dist(at, after) / 2)
        steps.append(("line", _towards(at, before, r)))
        steps.append(("control", at))
        steps.append(("curve", _towards(at, after, r)))
    if len(points) > 1:
        steps.append(("line", points[-1]))
    return steps


def _towards(a: XY, b: XY, length: float) -> XY:
    share = length / math.dist(a, b)
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
