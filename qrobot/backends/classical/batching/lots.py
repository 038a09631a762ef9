"""Orders that rules put together: their loads and tours, and whether they still fit the trips."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import Routes, Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.backends.classical.batching.tour import improve_tour, tour_length
from qrobot.problem import Instance

__all__ = ["Lots", "StopTours", "Tours", "fits_surely", "packed", "tours_of"]

PROMISING = 25
"""Lots whose common tour with another one is looked for, where no kernel finds it."""


class Tours(Protocol):
    """The tour of each lot; a lot is an order at first, and takes others in."""

    lengths: Floats
    """Shape (lots,), metres."""

    def common(self, lot: int, others: Ints) -> Floats:
        """Return the length of a tour of a lot with each of some others; ``inf``: not tried."""

    def join(self, lot: int, other: int) -> None:
        """Let a lot take in another one."""

    def routes(self, batches: list[list[int]]) -> Routes:
        """Return the routes of batches of orders."""


def tours_of(instance: Instance, stop: Stop) -> Tours:
    """Return the tours of an instance's orders: shortest ones where there are aisles.

    Elsewhere tours are no longer improved after `stop`.
    """
    if takes(instance) and compiled_soon(stop):
        from qrobot.backends.classical.batching.aisle_lots import AisleTours  # loads numba

        return AisleTours(instance)
    return StopTours(instance, stop)


class StopTours:
    """Tours past stops: inserted one after the other, then 2-opt and or-opt."""

    def __init__(self, instance: Instance, stop: Stop) -> None:
        self._instance, self._stop = instance, stop
        self._d = instance.stop_distances
        stops: list[list[int]] = [[] for _ in instance.orders]
        for s, nodes in enumerate(instance.stops):
            stops[int(instance.order_of_node[nodes[0]])].append(s + 1)
        self._stops = stops
        self._tours = [self._tour([], own) for own in stops]
        self.lengths: Floats = np.array([tour_length(self._d, tour) for tour in self._tours])

    def common(self, lot: int, others: Ints) -> Floats:
        """Return the lengths of common tours, of the most promising others only."""
        found = np.full(len(others), np.inf)
        tried = np.arange(len(others))
        if len(others) > PROMISING:
            tried = np.argsort(self._added(lot, others) - self.lengths[others], kind="stable")
        for at in tried[:PROMISING].tolist():
            found[at] = tour_length(self._d, self._joined(lot, int(others[at])))
        return found

    def join(self, lot: int, other: int) -> None:
        """Let a lot take in another one."""
        self._tours[lot] = self._joined(lot, other)
        self.lengths[lot] = tour_length(self._d, self._tours[lot])

    def routes(self, batches: list[list[int]]) -> Routes:
        """Return routes; the tours that lots have are taken where they are of the same orders."""
        known = {frozenset(tour): tour for tour in self._tours}
        routes = []
        for batch in batches:
            stops = [stop for order in batch for stop in self._stops[order]]
            tour = known.get(frozenset(stops)) or self._tour([], stops)
            routes.append([node for stop in tour for node in self._instance.stops[stop - 1]])
        return routes

    def _added(self, lot: int, others: Ints) -> Floats:
        """Return about how much longer a lot's tour becomes with each of some others."""
        way = np.array([0, *self._tours[lot], 0])
        a, b = way[:-1, None], way[1:, None]
        stops = np.concatenate([self._tours[other] for other in others.tolist()])
        added = (self._d[a, stops] + self._d[stops, b] - self._d[a, b]).min(axis=0)
        first = np.cumsum([0, *(len(self._tours[other]) for other in others[:-1].tolist())])
        return np.asarray(np.add.reduceat(added, first), dtype=np.float64)

    def _joined(self, lot: int, other: int) -> list[int]:
        long, short = sorted((self._tours[lot], self._tours[other]), key=len, reverse=True)
        return self._tour(long, short)

    def _tour(self, tour: list[int], stops: list[int]) -> list[int]:
        way = np.array([0, *tour, 0], dtype=np.intp)
        for stop in stops:
            a, b = way[:-1], way[1:]
            added = self._d[a, stop] + self._d[stop, b] - self._d[a, b]
            way = np.insert(way, int(added.argmin()) + 1, stop)
        return improve_tour(self._d, way[1:-1].tolist(), self._stop)


class Lots:
    """Lots that take each other in; at any time they fit the trips together.

    Parameters
    ----------
    instance, stop
        The question, and when to leave off improving tours.

    Attributes
    ----------
    possible
        Whether the orders fit the trips, as far as `packed` finds out.
    """

    def __init__(self, instance: Instance, stop: Stop) -> None:
        self.tours = tours_of(instance, stop)
        self.loads: Ints = instance.order_weights.astype(np.int64)
        self.capacities: Ints = instance.vehicle_capacities.astype(np.int64)
        self.orders = [[order] for order in range(len(self.loads))]
        self.alive = np.ones(len(self.loads), dtype=bool)
        self.possible = packed(self.loads, self.capacities) is not None

    @property
    def too_many(self) -> bool:
        """Whether there are more lots than trips."""
        return int(self.alive.sum()) > len(self.capacities)

    def fitting(self, lot: int) -> Ints:
        """Return the other lots that the largest robot carries together with one."""
        fits = self.alive & (self.loads + self.loads[lot] <= self.capacities[0])
        fits[lot] = False
        return np.flatnonzero(fits)

    def join(self, lot: int, other: int) -> bool:
        """Let a lot take in another one, unless the trips would not hold all lots then."""
        alive = self.alive.copy()
        alive[other] = False
        loads = self.loads.copy()
        loads[lot] += loads[other]
        left = loads[alive]
        if not fits_surely(left, self.capacities) and packed(left, self.capacities) is None:
            return False
        self.tours.join(lot, other)
        self.loads, self.alive = loads, alive
        self.orders[lot] += self.orders[other]
        return True

    def routes(self) -> Routes:
        """Return a route for each trip; lots share one only where there are too many."""
        lots = np.flatnonzero(self.alive)
        trips = packed(self.loads[lots], self.capacities)
        assert trips is not None  # it is held at all times
        batches: dict[int, list[int]] = {}
        for lot, trip in zip(lots.tolist(), trips.tolist(), strict=True):
            batches.setdefault(trip, []).extend(self.orders[lot])
        return self.tours.routes([sorted(batch) for batch in batches.values()])


def fits_surely(loads: Ints, capacities: Ints) -> bool:
    """Return whether `packed` is sure to find trips, without packing.

    On as many equal trips the heaviest loads come first, each onto a trip of its own. Where
    another one fits nowhere, no trip has room for the heaviest of the others.
    """
    count = len(capacities)
    if capacities[-1] < capacities[0] or loads.max(initial=0) > capacities[0]:
        return False
    if len(loads) <= count:
        return True
    next_heaviest = int(np.partition(loads, -count - 1)[-count - 1])
    return int(loads.sum()) <= int(capacities.sum()) - count * next_heaviest


def packed(loads: Ints, capacities: Ints) -> Ints | None:
    """Return the trip of each load, None when none is found.

    One load a trip where there are enough; else the heaviest first, onto the trip that it fits
    best, or else onto the one with most room.

    Parameters
    ----------
    loads
        In any sequence.
    capacities
        Of the trips, largest first.
    """
    heaviest = np.argsort(-loads, kind="stable")
    trips = np.empty(len(loads), dtype=np.int64)
    if len(loads) <= len(capacities) and (loads[heaviest] <= capacities[: len(loads)]).all():
        trips[heaviest] = np.arange(len(loads))
        return trips
    for best_fit in (True, False):
        room = capacities.copy()
        for at in heaviest.tolist():
            fits = np.flatnonzero(room >= loads[at])
            if not len(fits):
                break
            chosen = fits[room[fits].argmin() if best_fit else room[fits].argmax()]
            trips[at] = chosen
            room[chosen] -= loads[at]
        else:
            return trips
    return None
