"""When each item of a trip is reached and collected, at the speed of the robot."""

from __future__ import annotations

from dataclasses import dataclass

from qrobot.problem import Times
from qrobot.report.scene import Journey

__all__ = ["Visit", "timeline"]


@dataclass(frozen=True, slots=True)
class Visit:
    """A stop of a trip, or its end at the depot.

    Parameters
    ----------
    distance
        Length of the way since the depot.
    arrives, leaves
        Seconds since the set-up of the trip began; between them the item is collected.
    """

    distance: float
    arrives: float
    leaves: float


def timeline(journey: Journey, times: Times) -> list[Visit]:
    """Return the visits of a trip: a stop an item, and the return to the depot.

    The last one ends when the objective ``time`` says that the trip does.
    """
    picks = [*map(times.of, journey.items), 0.0]
    visits, distance, clock = [], 0.0, times.per_trip
    for leg, seconds in zip(journey.lengths, picks, strict=True):
        distance += leg
        arrives = clock + leg / journey.robot.speed
        clock = arrives + seconds
        visits.append(Visit(distance, arrives, clock))
    return visits
