"""What can be said at once: how many trips there must and need be, and two first bounds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.problem import AisleWarehouse, Instance, Slot
from qrobot.warehouse import MAX_CROSS_AISLES, Router

__all__ = [
    "fewest_trips",
    "least_trips",
    "most_trips",
    "quick_bound",
    "radial_bound",
    "shortest_ways",
    "tours_bound",
]

MAX_SHORTCUTS = 350_000_000
"""Pairs of stops times places on the way, beyond which nobody looks for shorter ways: seconds."""


def fewest_trips(instance: Instance) -> int:
    """Return a number of trips that no plan can stay below."""
    if not instance.orders:
        return 0
    return int(_trips_for(instance, np.argsort(-instance.order_weights, kind="stable"))[-1])


def _trips_for(instance: Instance, sequence: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    """Return how many trips the first 1, 2, .. orders of a sequence need at least.

    The largest robots, filled to the brim; and orders above half of the largest capacity
    never share a trip.
    """
    weights = instance.order_weights[sequence]
    capacities = instance.vehicle_capacities
    filled = np.searchsorted(np.cumsum(capacities), np.cumsum(weights)) + 1
    alone = np.cumsum(2 * weights > capacities[0])
    needed: npt.NDArray[np.intp] = np.minimum(np.maximum(filled, alone), len(capacities))
    return needed


def most_trips(instance: Instance) -> int:
    """Return a number of trips that some shortest plan does not exceed.

    Two trips that fit on one robot together can be joined, unless the way between two
    stops is longer than over the depot; so at most one trip is half empty or less.
    """
    capacities = instance.vehicle_capacities
    d = instance.stop_distances
    joinable = bool((d[1:, 0, None] + d[None, 0, 1:] >= d[1:, 1:] - 1e-9).all())
    if not joinable or capacities[0] != capacities[-1]:
        return len(capacities)
    total = int(instance.weights.sum())
    return min(len(capacities), max(1, 2 * total // max(int(capacities[0]), 1) + 1))


def quick_bound(instance: Instance) -> float:
    """Return a bound that costs next to nothing: every stop is entered, every trip comes home.

    Valid for any matrix: each stop must be entered from somewhere else and each trip must
    return to the depot. Never below `radial_bound`.
    """
    if not instance.items:
        return 0.0
    d = instance.stop_distances
    apart = d.copy()
    np.fill_diagonal(apart, np.inf)
    entered = float(apart[:, 1:].min(axis=0).sum()) + fewest_trips(instance) * float(d[1:, 0].min())
    return max(entered, radial_bound(instance))


def radial_bound(instance: Instance) -> float:
    """Return a bound from the ways out and back: strong where trips are many.

    In the spirit of Haimovich and Rinnooy Kan (1985). Let out(i) and back(i) be the lengths
    of the shortest ways from the depot to stop i and back, over any places. For an order o
    (or an item, where items stand alone) let r(o) be the largest out(i) + back(i) of its
    stops.

    Proof. The trip that collects o passes the stop i with r(o) = out(i) + back(i). Up to i
    it is a way from the depot to i, after i a way back, so the trip is no shorter than
    r(o). This needs neither symmetry nor the triangle inequality, only that no distance is
    negative.

    Let N(x) be a number of trips that the orders with r(o) >= x need at least, however they
    are shared out: as many of the largest capacities as hold their weight, and one for each
    that weighs more than half of the largest. At least N(x) trips collect such an order and
    are no shorter than x. The total distance is the integral over x of the number of trips
    that are no shorter than x, hence at least the integral of N(x).

    With N(x) >= weight / largest capacity that is at least the sum over the orders of
    r(o) * weight(o) / largest capacity, the radial bound of the literature.
    """
    if not instance.orders:
        return 0.0
    return _longest_first(instance, least_trips(instance))


def tours_bound(instance: Instance) -> float:
    """Return the `radial_bound` with shortest tours instead of the ways out and back.

    In aisles the shortest tour past all stops of an order is found at once, and no trip that
    collects the order is shorter: leaving stops out lengthens no trip. So the proof of
    `radial_bound` holds with that length as r(o). Zero where it tells nothing more.
    """
    house = instance.warehouse
    if not isinstance(house, AisleWarehouse) or house.is_one_way:
        return 0.0
    if instance.stock or not instance.whole_orders or house.blocks >= MAX_CROSS_AISLES:
        return 0.0
    places = [[instance.items[v - 1].place for v in nodes] for nodes in instance.order_nodes]
    picks = [[place for place in own if isinstance(place, Slot)] for own in places]
    return _longest_first(instance, Router(house).lengths(picks))


def _longest_first(instance: Instance, reach: Floats) -> float:
    """Return the integral of N(x) of `radial_bound`, with these r(o)."""
    farthest_first = np.argsort(-reach, kind="stable")
    steps = -np.diff(reach[farthest_first], append=0.0)
    return float(steps @ _trips_for(instance, farthest_first))


def least_trips(instance: Instance) -> Floats:
    """Return for each order a length that no trip which collects it is below, metres.

    The way out to its farthest stop and back, over any places.
    """
    d = instance.stop_distances
    if instance.warehouse.is_metric:
        away = d[0, 1:] + d[1:, 0]
    else:
        away = (_from_depot(d) + _from_depot(d.T))[1:]
    owner = instance.order_of_node[[nodes[0] for nodes in instance.stops]]
    reach = np.zeros(len(instance.orders))
    np.maximum.at(reach, owner, away)
    return reach


def _from_depot(d: Floats) -> Floats:
    """Return the lengths of the shortest ways from row 0 over any places (Dijkstra 1959)."""
    reach: Floats = d[0].copy()
    open_ = np.ones(len(d), dtype=bool)
    for _ in range(len(d)):
        at = int(np.where(open_, reach, np.inf).argmin())
        open_[at] = False
        np.minimum(reach, reach[at] + d[at], out=reach)
    return reach


def shortest_ways(
    instance: Instance, stop: Callable[[], bool], over: Sequence[int] | None = None
) -> Floats | None:
    """Return distances that no way over other places is shorter than; no longer than given.

    Parameters
    ----------
    instance
        Aisles and floors have such distances by construction; in tables and rounded floors
        every way becomes the shortest one over other places (Floyd 1962).
    stop
        Asked for every place.
    over
        Rows of the stops that ways may lead over, all by themselves: whoever leaves some
        stops out of a trip needs shortest ways over these alone, however many others there are.

    Returns
    -------
    numpy.ndarray or None
        ``None`` when stopped, or when there are too many to look at.
    """
    if instance.warehouse.is_metric:
        return instance.stop_distances
    d = instance.stop_distances.copy()
    places = range(len(d)) if over is None else over
    if len(places) * d.size > MAX_SHORTCUTS:
        return None
    for k in places:
        if stop():
            return None
        np.minimum(d, d[:, k, None] + d[None, k, :], out=d)
    return d
