"""Trips under way: robots bring home what is on board, past what is left of their orders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qrobot.backends import Stop
from qrobot.backends.classical.batching.tour import tour_length
from qrobot.backends.classical.exact.tours import best_sequence
from qrobot.errors import InputError
from qrobot.plan import Trip
from qrobot.planning.state import State
from qrobot.problem import Instance, Item
from qrobot.problem.table import unreachable

__all__ = ["Finish", "cut_off_items", "finish"]

REST_SECONDS = 0.2
"""For the proof that the rest of a trip is as short as can be."""


@dataclass(frozen=True, slots=True)
class Finish:
    """The rest of a trip under way.

    Parameters
    ----------
    robot
        Its id.
    trip
        Number of the trip in the old plan.
    picked
        Ids of the items that are on board.
    stops
        Ids of the items that are still collected, in sequence.
    back
        When the robot is back, seconds since all robots began.
    """

    robot: str
    trip: int
    picked: tuple[str, ...]
    stops: tuple[str, ...]
    back: float


def cut_off_items(instance: Instance) -> frozenset[str]:
    """Return the items that no way leads to any more."""
    if not instance.items:
        return frozenset()
    ways = np.isfinite(instance.warehouse.distance_matrix(instance.places))
    rows = set(unreachable(ways).tolist())
    place = instance.row_of_place
    return frozenset(item.id for item in instance.items if place[item.place] in rows)


def finish(state: State, cut_off: frozenset[str]) -> tuple[list[Finish], list[str]]:
    """Return the rest of each trip under way, and what is different from the plan."""
    finishing, notes = [], []
    instance, cancelled = state.instance, set(state.cancelled)
    missing = cut_off | set(state.missing)
    owner = {item: order.id for order in instance.orders for item in order.items}
    robots = {robot.id: robot for robot in instance.robots}
    items = {item.id: item for item in instance.items}
    for one in state.robots:
        if one.trip == 0 or one.lost:
            continue
        trip = state.plan.trips[one.trip - 1]
        left = [stop for stop in trip.stops if stop not in one.picked]
        stops = [s for s in left if s not in missing and owner[s] not in cancelled]
        if left_behind := [s for s in left if s in cut_off and owner[s] not in cancelled]:
            notes.append(
                f"no way leads to {', '.join(left_behind)}: robot {one.robot} comes home without"
            )
        gone = [order for order in trip.orders if order in cancelled]
        if held := [o for o in gone if any(owner[item] == o for item in one.picked)]:
            notes.append(
                f"robot {one.robot} has items of the cancelled orders {', '.join(held)} on board"
            )
        back = one.back
        if stops != left or back < state.now or not _is_as_planned(instance, trip):
            picked = [items[name] for name in one.picked[-1:]]
            length, order = _rest(instance, picked, [items[name] for name in stops])
            if math.isinf(length):
                raise InputError(
                    f"no way leads robot {one.robot} home from where it stands",
                    field="robots",
                    advice="mark it as lost, or open the aisle that it stands in",
                )
            stops = [stops[k] for k in order]
            handling = math.fsum(instance.times.of(items[name]) for name in stops)
            back = state.now + length / robots[one.robot].speed + handling
        finishing.append(Finish(one.robot, one.trip, one.picked, tuple(stops), back))
    return finishing, notes


def _is_as_planned(instance: Instance, trip: Trip) -> bool:
    """Return whether the ways of a trip are as long as when it was planned."""
    items = {item.id: item for item in instance.items}
    ways = instance.warehouse.distance_matrix([items[stop].place for stop in trip.stops])
    rows = [0, *range(1, len(ways)), 0]
    return math.isclose(float(ways[rows[:-1], rows[1:]].sum()), trip.distance, rel_tol=1e-6)


def _rest(
    instance: Instance, at: Sequence[Item], items: Sequence[Item]
) -> tuple[float, Sequence[int]]:
    """Return the length of a short way past items to the depot, and the sequence of the items.

    It leads from the last item that was collected, `at`, or from the depot.
    """
    places = [item.place for item in (*at, *items)]
    ways = instance.warehouse.distance_matrix(places)
    first = len(at)
    # One row stands for both ends: ways leave it from the robot and enter it at the depot.
    rows = [first, *range(first + 1, len(ways))]
    ways = ways[np.ix_(rows, [0, *rows[1:]])]
    if not items:
        return float(ways[0, 0]), ()
    tour, _ = best_sequence(ways, Stop(REST_SECONDS))
    return tour_length(ways, tour), [v - 1 for v in tour]
