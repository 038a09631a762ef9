"""Robots that do not meet in narrow aisles: sub-aisles are reserved, trip by trip.

A trip is a sequence of stays: in a sub-aisle from its one crossing to the next, or outside, where
robots can pass each other. The trip that may begin first is timed next: each of its stays in a
sub-aisle begins as soon as fewer than so many robots are there until it ends, and until then the
robot waits outside, at the crossing. All reservations of a trip are made before those of the next,
and none is changed afterwards. So no robot ever waits for one that was timed after it: there is no
circle of robots that wait for each other, hence no deadlock.
"""

from __future__ import annotations

import bisect
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import dist

from qrobot.problem import AisleWarehouse, Times
from qrobot.report.lanes import XY
from qrobot.report.scene import Journey
from qrobot.report.timeline import Visit

__all__ = ["Inside", "Reservations"]

SAME = 1e-6
"""Metres below which two heights are the same."""

SubAisle = tuple[int, int]
"""Aisle and block."""


@dataclass(frozen=True, slots=True)
class Inside:
    """A stay of a robot in a sub-aisle, seconds since all robots began."""

    aisle: int
    block: int
    enters: float
    leaves: float


@dataclass(slots=True)
class _Stay:
    """Time in a sub-aisle or outside, and the stops in it: index, arrival and departure."""

    where: SubAisle | None
    seconds: float = 0.0
    stops: list[tuple[int, float, float]] = field(default_factory=list)


class Reservations:
    """The reserved times of all sub-aisles.

    Parameters
    ----------
    warehouse
        Its aisles are narrow, its cross aisles are not.
    robots
        How many robots may be in a sub-aisle at once.
    """

    def __init__(self, warehouse: AisleWarehouse, robots: int) -> None:
        self._warehouse = warehouse
        # Of each sub-aisle so many lanes; in each the times that are taken, rising.
        self._lanes: dict[SubAisle, list[list[tuple[float, float]]]] = defaultdict(
            lambda: [[] for _ in range(robots)]
        )

    def take(
        self, journey: Journey, times: Times, begins: float
    ) -> tuple[list[Visit], list[Inside], list[tuple[float, float]]]:
        """Time a trip and reserve its sub-aisles.

        Parameters
        ----------
        journey
            The trip.
        times
            Of set-up and picks.
        begins
            When its set-up begins, seconds since all robots began.

        Returns
        -------
        tuple
            Its stops and its end in seconds since its set-up began, its stays in sub-aisles, and
            from when to when the robot waits before one.
        """
        clock = begins
        waits = []
        visits: list[Visit] = []
        inside = []
        metres = 0.0
        for stay in self._stays(journey, times):
            enters = clock
            if stay.where is not None:
                enters = self._reserve(stay.where, clock, stay.seconds)
                inside.append(Inside(*stay.where, enters, enters + stay.seconds))
            if enters > clock:
                waits.append((clock, enters))
            for stop, arrives, leaves in stay.stops:
                metres += journey.lengths[stop]
                since = enters - begins
                visits.append(Visit(metres, since + arrives, since + leaves))
            clock = enters + stay.seconds
        visits.append(Visit(metres + journey.lengths[-1], clock - begins, clock - begins))
        return visits, inside, waits

    def _reserve(self, where: SubAisle, soonest: float, seconds: float) -> float:
        """Take the earliest time at which a lane of a sub-aisle is free for so long."""
        found = [(_free(lane, soonest, seconds), i) for i, lane in enumerate(self._lanes[where])]
        begins, best = min(found)
        bisect.insort(self._lanes[where][best], (begins, begins + seconds))
        return begins

    def _stays(self, journey: Journey, times: Times) -> list[_Stay]:
        """Return the stays of a trip, from its set-up to its end."""
        stays = [_Stay(None, times.per_trip)]
        speed = journey.robot.speed
        for k, (leg, length) in enumerate(zip(journey.legs, journey.lengths, strict=True)):
            drawn = sum(dist(a, b) for a, b in pairwise(leg))
            if drawn <= SAME:
                stays[-1].seconds += length / speed
            for where, metres in self._parts(leg):
                if where != stays[-1].where:
                    stays.append(_Stay(where))
                stays[-1].seconds += metres / drawn * length / speed
            if k < len(journey.items):
                here = stays[-1]
                picking = times.of(journey.items[k])
                here.stops.append((k, here.seconds, here.seconds + picking))
                here.seconds += picking
        return stays

    def _parts(self, leg: tuple[XY, ...]) -> Iterator[tuple[SubAisle | None, float]]:
        """Yield the straight parts of a leg: where each is, and how long it is drawn."""
        heights = self._warehouse.cross_aisle_heights
        for (x, y), (to_x, to_y) in pairwise(leg):
            if abs(x - to_x) > SAME:
                yield None, dist((x, y), (to_x, to_y))
                continue
            low, high = sorted((y, to_y))
            cuts = [low, *(h for h in heights if low + SAME < h < high - SAME), high]
            parts = []
            for a, b in pairwise(cuts):
                middle = (a + b) / 2.0
                inside = heights[0] < middle < heights[-1]
                block = bisect.bisect(heights, middle) - 1
                aisle = round(x / self._warehouse.aisle_pitch)
                parts.append(((aisle, block) if inside else None, b - a))
            yield from parts if y < to_y else reversed(parts)


def _free(taken: list[tuple[float, float]], soonest: float, seconds: float) -> float:
    """Return the earliest time from which so many seconds are free."""
    at = bisect.bisect_left(taken, (soonest, soonest))
    if at and taken[at - 1][1] > soonest:
        at -= 1
    begins = soonest
    for start, end in taken[at:]:
        if start >= begins + seconds:
            return begins
        begins = max(begins, end)
    return begins
