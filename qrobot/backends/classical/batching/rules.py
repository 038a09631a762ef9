"""Simple rules of batching, as warehouses use them: what a search is measured against.

Each rule is a planner without random choices. Tours are shortest ones where there are aisles.
Trips of unlike robots are filled from the largest down. Where trips are scarce, a rule does only
what leaves a packing of all orders onto them, as far as a quick look finds one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import Capabilities, OnBest, Routes, Search, Stop
from qrobot.backends.classical.batching.lots import Lots, Tours, packed, tours_of
from qrobot.problem import Instance

__all__ = ["FirstComePlanner", "SavingsPlanner", "SeedPlanner", "join_by_savings"]

LEAST = 1e-9
"""Share of a tour below which a saving is rounding."""


class _Rule:
    """A planner by a rule: `batch` does the work, and this tells of it.

    Work units: orders that were given a trip or joined another one.
    """

    name: str
    capabilities = Capabilities(kind="planner")

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,  # noqa: ARG002 - nothing is random
        start: Routes | None = None,  # noqa: ARG002 - a rule begins at the beginning
        on_best: OnBest | None = None,
    ) -> Search:
        """Follow the rule, or until `stop`; see `Planner.search`.

        A rule that is stopped keeps what it has joined. There are no routes when it finds no
        packing of the orders.
        """
        if not instance.orders:
            return Search(routes=[])
        best, least, work = None, np.inf, 0
        for routes, done in self.batch(instance, stop):
            work += done
            length = instance.length(routes)
            if best is None or length < least:
                best, least = routes, length
                if on_best is not None:
                    on_best(routes, length)
        return Search(routes=best, work=work)

    def batch(self, instance: Instance, stop: Stop) -> Iterator[tuple[Routes, int]]:
        """Yield plans, and the units of work that each took; nothing without a packing."""
        raise NotImplementedError


class FirstComePlanner(_Rule):
    """First come first served: orders join the open trip in the sequence that they have.

    An order that does not fit opens the next trip, and those before are closed. Where the trips
    run out like this, each order joins the first trip with room for it, in the same sequence;
    where that fails, too, the heaviest orders come first.
    """

    name = "fcfs"

    def batch(self, instance: Instance, stop: Stop) -> Iterator[tuple[Routes, int]]:
        """Yield the one plan of the rule."""
        loads, rooms = instance.order_weights.astype(np.int64), instance.vehicle_capacities
        capacities = rooms.astype(np.int64)
        trips = _in_sequence(loads, capacities, closing=True)
        if trips is None:
            trips = _in_sequence(loads, capacities, closing=False)
        if trips is None:
            trips = packed(loads, capacities)
        if trips is not None:
            batches = [np.flatnonzero(trips == trip).tolist() for trip in np.unique(trips)]
            yield tours_of(instance, stop).routes(batches), len(loads)


def _in_sequence(loads: Ints, capacities: Ints, *, closing: bool) -> Ints | None:
    """Return the trip of each load, in sequence; `closing`: none before the last is looked at."""
    room = capacities.copy()
    trips = np.empty(len(loads), dtype=np.int64)
    first = 0
    for order, load in enumerate(loads.tolist()):
        fits = np.flatnonzero(room[first:] >= load)
        if not len(fits):
            return None
        trip = first + int(fits[0])
        trips[order] = trip
        room[trip] -= load
        first = trip if closing else 0
    return trips


Choice = Callable[[Instance, Tours], Floats]
"""For each order a number: of those without a trip, the largest is the seed."""


def _most_stops(instance: Instance, _tours: Tours) -> Floats:
    owners = [int(instance.order_of_node[nodes[0]]) for nodes in instance.stops]
    return np.bincount(owners, minlength=len(instance.orders)).astype(np.float64)


SEEDS: tuple[Choice, ...] = (lambda _, tours: tours.lengths.copy(), _most_stops)
"""The order of the longest tour, and the one of most stops."""


class SeedPlanner(_Rule):
    """Seed rules: an order opens a trip, and others join it until none fits.

    Two choices of a seed (the longest tour; the most stops) with two choices of who joins (the
    largest saving against a tour alone; the least way added) are four rules; the best of the four
    plans is taken. The seed is cumulative: tours are those of all orders on the trip so far.
    Rules by Elsayed (1981) and Gibson and Sharp (1992); these and others are compared by
    de Koster, van der Poort and Wolters (1999).
    """

    name = "seed"

    def batch(self, instance: Instance, stop: Stop) -> Iterator[tuple[Routes, int]]:
        """Yield the plan of each rule."""
        work = 0
        for choose, saving in product(SEEDS, (True, False)):
            lots = Lots(instance, stop)
            if not lots.possible or (work and stop(work)):
                return
            before = work
            work = _grow(lots, choose(instance, lots.tours), stop, work, saving=saving)
            yield lots.routes(), work - before


def _grow(lots: Lots, value: Floats, stop: Stop, work: int, *, saving: bool) -> int:
    """Let one seed after the other take in orders; return the work with that of before."""
    alone = lots.tours.lengths.copy()
    free = np.ones(len(value), dtype=bool)
    for seed in np.argsort(-value, kind="stable").tolist():
        if not free[seed]:
            continue
        free[seed] = False
        work += 1
        refused = np.zeros(len(value), dtype=bool)
        while not stop(work):
            others = lots.fitting(seed)
            others = others[free[others] & ~refused[others]]
            if not len(others):
                break
            added = lots.tours.common(seed, others)
            if saving:
                added = added - alone[others]
            other = int(others[added.argmin()])
            if lots.join(seed, other):
                free[other] = False
                work += 1
            else:
                refused[other] = True
    return work


class SavingsPlanner(_Rule):
    """Clarke and Wright (ii): the two trips join that save most, and savings are found anew.

    Clarke and Wright (1964) for trips of one vehicle; for order batching, with savings
    recomputed for the joined trip after every step, de Koster, van der Poort and Wolters (1999).
    Trips join as long as that saves way, or while there are more than the robots may make.
    """

    name = "savings"

    def batch(self, instance: Instance, stop: Stop) -> Iterator[tuple[Routes, int]]:
        """Yield the one plan of the rule."""
        lots = Lots(instance, stop)
        if lots.possible:
            work = join_by_savings(lots, stop)
            yield lots.routes(), work


def join_by_savings(lots: Lots, stop: Stop) -> int:
    """Join the two lots that save most, again and again; return how often."""
    count = len(lots.loads)
    saved = np.full((count, count), -np.inf)
    joined = 0
    for lot in range(count):
        if stop(joined):
            return joined
        others = lots.fitting(lot)
        _fill_in(lots, saved, lot, others[others > lot])
    row_best = saved.max(axis=1)
    while not stop(joined):
        lot = int(row_best.argmax())
        other = int(saved[lot].argmax())
        most = saved[lot, other]
        least = LEAST * (lots.tours.lengths[lot] + lots.tours.lengths[other])
        if most == -np.inf or (most <= least and not lots.too_many):
            break
        if lots.join(lot, other):
            joined += 1
            for gone in (lot, other):
                saved[gone, :] = saved[:, gone] = -np.inf
            _fill_in(lots, saved, lot, lots.fitting(lot))
        else:
            saved[lot, other] = -np.inf
            saved[other, lot] = -np.inf
        row_best = saved.max(axis=1)
    return joined


def _fill_in(lots: Lots, saved: Floats, lot: int, others: Ints) -> None:
    lengths = lots.tours.lengths
    saved[lot, others] = lengths[lot] + lengths[others] - lots.tours.common(lot, others)
