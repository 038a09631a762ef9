"""The animated page of a plan: robots moving along their ways, at their speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise
from pathlib import Path

from qrobot._json import json_text
from qrobot._text import shown
from qrobot.pages import render, script
from qrobot.report.floorplan import Way, floor_plan
from qrobot.report.lanes import XY
from qrobot.report.picklist import exact_text, location
from qrobot.report.scene import Scene
from qrobot.report.schedules import TimedTrip
from qrobot.report.scheduling import schedule_of

__all__ = ["animation_page"]

HERE = Path(__file__).parent
DRAWING = 660.0, 520.0
SPEEDS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000)
WATCHED = 30.0
"""Seconds that the whole takes at the first speed, at most where there is such a speed."""


@dataclass(frozen=True, slots=True)
class Moving:
    """A robot as the map and the table name it."""

    name: str
    fill: str
    edge: str
    text: str
    at: XY


def animation_page(scene: Scene) -> str:
    """Return a page on which the robots of a plan move along their ways.

    Every robot leaves the depot at once and makes its trips one after the other, at its own
    speed, and stays as long at each stop as the pick takes. The page needs nothing but itself.
    """
    plan = floor_plan(scene, scene.journeys, DRAWING)
    moving = [own for own in schedule_of(scene).robots if own.trips]
    robots = [
        Moving(shown(own.robot), colour.fill, colour.edge, colour.text, plan.depot)
        for own in moving
        for colour in (own.trips[0].journey.colour,)
    ]
    end = max((own.ends for own in moving), default=0.0)
    data = {
        "end": round(end, 3),
        "robots": [
            {
                "capacity": exact_text(own.trips[0].journey.capacity),
                "picks": sum(len(trip.journey.items) for trip in own.trips),
                "trips": [
                    _trip(scene, trip, plan.ways[number]) | {"way": number}
                    for trip in own.trips
                    for number in (trip.journey.number - 1,)
                ],
            }
            for own in moving
        ],
    }
    return render(
        HERE / "animation.html",
        title=scene.title,
        subtitle=scene.subtitle,
        map=plan,
        robots=robots,
        end=data["end"],
        speeds=SPEEDS,
        speed=next((speed for speed in SPEEDS if end / speed <= WATCHED), SPEEDS[-1]),
        data=json_text(data),
        script=script(HERE / "animation.js"),
    )


def _trip(scene: Scene, trip: TimedTrip, way: Way) -> dict[str, object]:
    """Return a trip as the script wants it; times are those of the whole plan."""
    journey, visits, begin = trip.journey, trip.visits, trip.begins
    frames = _frames(way.legs, trip)
    loads = accumulate((item.weight for item in journey.items), initial=Fraction(0))
    leaves = [round(begin + visit.leaves, 3) for visit in visits]
    return {
        "start": round(begin, 3),
        "end": leaves[-1],
        "t": [round(t, 3) for t, _ in frames],
        "x": [round(x, 1) for _, (x, _) in frames],
        "y": [round(y, 1) for _, (_, y) in frames],
        "arrives": [round(begin + visit.arrives, 3) for visit in visits[:-1]],
        "leaves": leaves[:-1],
        "labels": [
            f"{location(scene.instance, item)}: {shown(item.article or item.id)}"
            for item in journey.items
        ],
        "loads": [exact_text(load) for load in loads][1:],
        "marked": [leaves[mark.last - 1] for mark in way.marks],
        "fill": way.colour.fill,
        "edge": way.colour.edge,
        "text": way.colour.text,
    }


def _frames(legs: Sequence[Sequence[XY]], trip: TimedTrip) -> list[tuple[float, XY]]:
    """Return where the robot is when: at each corner, and at each stop from arrival to departure.

    Between two stops it passes the drawn way evenly; what it takes is the length of the real one.
    """
    begin, left = trip.begins, trip.leaves
    frames = [(begin, legs[0][0]), (left, legs[0][0])]
    for leg, visit in zip(legs, trip.visits, strict=True):
        arrives = begin + visit.arrives
        steps = list(accumulate((math.dist(a, b) for a, b in pairwise(leg)), initial=0.0))
        for point, passed in zip(leg[1:], steps[1:], strict=True):
            share = passed / steps[-1] if steps[-1] > 0 else 1.0
            frames.append((left + (arrives - left) * share, point))
        frames.append((arrives, leg[-1]))
        left = begin + visit.leaves
        frames.append((left, leg[-1]))
    return frames
