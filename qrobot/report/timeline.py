"""When each item of a trip is reached and collected, at the speed of the robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from qrobot.problem import Instance, Robot

__all__ = ["Visit", "timeline"]


@dataclass(frozen=True, slots=True)
class Visit:
    """A stop of a trip, or its end at the depot.

    Parameters
    ----------
    distance
        Length of the way since the depot.
    arrives, leaves
        Seconds since the robot left the depot; between them the item is collected.
    """

    distance: float
    arrives: float
    leaves: float


def timeline(instance: Instance, robot: Robot, nodes: Sequence[int]) -> list[Visit]:
    """Return the visits of a trip to nodes: a stop an item, and the return to the depot.

    The last one ends when the objective ``time`` says that the trip does.
    """
    picks = [*(instance.items[node - 1].pick_seconds for node in nodes), 0.0]
    visits, distance, clock = [], 0.0, 0.0
    places = instance.place_of_node[[0, *nodes, 0]].tolist()
    for (start, end), seconds in zip(pairwise(places), picks, strict=True):
        leg = float(instance.place_distances[start, end])
        distance += leg
        arrives = clock + leg / robot.speed
        clock = arrives + seconds
        visits.append(Visit(distance, arrives, clock))
    return visits
