"""A few trips of a good plan, whose orders a small model deals out anew.

A model of all orders and trips is large, and its pairs say little of trips of many orders. One of
two or three trips has tens of variables, and its pairs are fitted to batches of just these orders.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from qrobot._arrays import Bools, Ints
from qrobot.backends.classical.orders import Batch, Orders
from qrobot.models.batches import Assignment
from qrobot.planning.surrogate import Surrogate

__all__ = ["Neighbourhood", "Neighbourhoods"]

TRIPS = (2, 3)
"""Trips of a neighbourhood; each number as often as the others."""

SAMPLE = 120
"""Batches of its orders, filled to the capacity, that the pairs are fitted to."""

KEPT = 0.7
"""Share of a trip's orders that a batch of the sample begins with."""

RIDGE = 0.3
"""Pull of the fit towards that of all orders, in batches."""


@dataclass(frozen=True, slots=True)
class Neighbourhood:
    """Trips to deal out anew, and those that stay.

    Parameters
    ----------
    orders
        Shape (n,): of the chosen trips, rising.
    trips
        Shape (orders of the question,): trips of those that stay, from `slots` on; -1 elsewhere.
    slots
        Shape (trips,): capacities of the chosen trips.
    groups
        Shape (trips, n): who is on them.
    """

    orders: Ints
    trips: Ints
    slots: Ints
    groups: Bools

    def completed(self, parts: Ints) -> Ints:
        """Return trips of all orders for each of the chosen ones', shape (reads, orders)."""
        whole = np.tile(self.trips, (len(parts), 1))
        whole[:, self.orders] = parts
        return whole


class Neighbourhoods:
    """Draws neighbourhoods, and makes their models.

    Parameters
    ----------
    orders
        The question.
    surrogate
        Of all orders.
    length
        Returns the length of a shortest tour of a batch.
    rng
        Of every choice.
    """

    def __init__(
        self,
        orders: Orders,
        surrogate: Surrogate,
        length: Callable[[Batch], float],
        rng: np.random.Generator,
    ) -> None:
        self._orders, self._surrogate, self._length, self._rng = orders, surrogate, length, rng

    def draw(self, plan: Iterable[Batch]) -> Neighbourhood:
        """Choose a trip at random, and others that probably go well with it."""
        batches, rng = [list(batch) for batch in sorted(plan)], self._rng
        weights = self._orders.weights
        # The heaviest batch has the largest robot.
        batches.sort(key=lambda batch: -int(weights[batch].sum()))
        first = int(rng.integers(len(batches)))
        saved = self._surrogate.pairs
        near = np.array([saved[np.ix_(batches[first], batch)].mean() for batch in batches])
        near = near / max(float(near.std()), 1e-9) + rng.gumbel(size=len(batches))
        near[first] = np.inf
        chosen = np.sort(np.argsort(-near)[: int(rng.choice(TRIPS))])
        inside = np.array(sorted(order for trip in chosen for order in batches[trip]))
        trips = np.full(len(weights), -1, dtype=np.int64)
        others = (batch for trip, batch in enumerate(batches) if trip not in set(chosen.tolist()))
        for number, batch in enumerate(others, len(chosen)):
            trips[batch] = number
        groups = np.array([np.isin(inside, batches[trip]) for trip in chosen])
        return Neighbourhood(inside, trips, self._orders.capacities[chosen], groups)

    def model(self, part: Neighbourhood) -> tuple[Assignment, float]:
        """Return the model of a neighbourhood, and the scale of its energies."""
        weights = self._orders.weights[part.orders]
        rows = self._batches(part, weights)
        lengths = np.array([self._length(tuple(part.orders[row].tolist())) for row in rows])
        alone, savings = self._surrogate.fitted(part.orders, rows, lengths, RIDGE)
        room = int(part.slots[0])
        gain = Assignment.usual_gain(weights, savings, room)
        penalties = Assignment.measured(weights, savings, room)
        return Assignment(weights, part.slots, alone, savings, *penalties), 4.0 * gain

    def _batches(self, part: Neighbourhood, weights: Ints) -> Bools:
        """Return batches like those of the plan, and the plan's own, shape (batches, n)."""
        rng, count = self._rng, len(weights)
        begun = part.groups[rng.integers(len(part.groups), size=SAMPLE)]
        # In random sequence, but most of a trip's own orders first: whoever fits comes in.
        keys = rng.random((SAMPLE, count)) - (begun & (rng.random((SAMPLE, count)) < KEPT))
        room = np.full(SAMPLE, part.slots[0])
        made = np.zeros((SAMPLE, count), dtype=bool)
        rows = np.arange(SAMPLE)
        for order in np.argsort(keys, axis=1).T:
            fits = weights[order] <= room
            made[rows, order] = fits
            room -= np.where(fits, weights[order], 0)
        found = np.unique(np.vstack([made, part.groups]), axis=0)
        return np.asarray(found[found.any(axis=1)])
