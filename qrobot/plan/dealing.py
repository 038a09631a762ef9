"""Which robot makes which trip, where that costs no metre: so that the last robot is back early."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from qrobot.problem import Instance

__all__ = ["deal"]


def deal(instance: Instance, routes: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Return for each route the robot (its index) and turn, so that all are done early.

    The trip that takes longest is dealt first, each to the robot that is back from it first
    (Graham 1969, longest processing time), as long as the heavier ones that are left find room.
    Where the robots cannot carry the trips, loads are not looked at.

    Parameters
    ----------
    instance
        The question; times are those of its robots' speeds and of each pick.
    routes
        Nodes of each trip.

    Raises
    ------
    ValueError
        When there are more routes than turns of robots.
    """
    if not routes:
        return []
    loads = np.array([instance.weights[np.array(route) - 1].sum() for route in routes])
    picks = [math.fsum(instance.items[v - 1].pick_seconds for v in route) for route in routes]
    lengths = np.array([instance.route_length(route) for route in routes])
    speeds = np.array([robot.speed for robot in instance.robots])
    seconds = lengths[:, None] / speeds + np.array(picks)[:, None]
    left = _Left(instance, loads)
    if not left.fits:  # a wrong plan, which the checker refuses: any robot takes any trip
        loads = np.zeros_like(loads)
        left = _Left(instance, loads)
    if not left.fits:
        raise ValueError(f"{len(routes)} trips for {left.turns.sum()} turns of the robots")
    back = np.zeros(len(instance.robots))
    turns = [0] * len(instance.robots)
    chosen = [(0, 0)] * len(routes)
    # Equal times are told apart by the stops, so that the sequence of the routes does not matter.
    for i in sorted(range(len(routes)), key=lambda i: (-seconds[i].max(), routes[i])):
        able = left.robots_for(int(loads[i]))
        # Sums that differ by rounding are equal, and the first of the robots takes the trip.
        robot = int(able[np.round(back[able] + seconds[i, able], 9).argmin()])
        left.take(int(loads[i]), robot)
        chosen[i] = robot, turns[robot]
        turns[robot] += 1
        back[robot] += seconds[i, robot]
    return chosen


class _Left:
    """The trips that are not dealt yet, and the turns that robots have left.

    The trips fit when, for every capacity, no more of them are heavier than all smaller robots
    can carry than larger robots have turns.
    """

    def __init__(self, instance: Instance, loads: npt.NDArray[np.int64]) -> None:
        self.turns = np.array([min(robot.trips, len(loads)) for robot in instance.robots])
        self.levels, self.level = np.unique(instance.capacities, return_inverse=True)
        # Of each level the trips that want at least that much room, and the turns that give it.
        wanted = np.searchsorted(self.levels, loads)
        self.trips = np.array([(wanted >= k).sum() for k in range(len(self.levels))])
        self.seats = np.array([self.turns[self.level >= k].sum() for k in range(len(self.levels))])
        self.fits = bool((wanted < len(self.levels)).all() and (self.trips <= self.seats).all())

    def robots_for(self, load: int) -> npt.NDArray[np.intp]:
        """Return the robots that may take a trip of a load without leaving a heavier one behind.

        Of the levels above the trip's own that such a robot serves, each has a turn to spare.
        """
        wanted = int(np.searchsorted(self.levels, load))
        scarce = np.flatnonzero(self.seats[wanted + 1 :] <= self.trips[wanted + 1 :])
        end = wanted + 1 + int(scarce[0]) if len(scarce) else len(self.levels)
        return np.flatnonzero((self.turns > 0) & (wanted <= self.level) & (self.level < end))

    def take(self, load: int, robot: int) -> None:
        """Deal a trip of a load to a robot."""
        self.turns[robot] -= 1
        self.trips[: int(np.searchsorted(self.levels, load)) + 1] -= 1
        self.seats[: self.level[robot] + 1] -= 1
