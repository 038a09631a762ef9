"""What a quadratic model says of the tours of batches, fitted to exact ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from qrobot._arrays import Bools, Floats, Ints
from qrobot.backends.classical.orders import Batch, Orders, lengths_of

__all__ = ["Surrogate"]

SAMPLE = 200
"""Random batches, filled to the capacity, of the first fit."""


class Surrogate:
    """The length of a batch's tour as a sum over its orders and pairs.

    By least squares over random batches, the length is told by four facts: the lengths of trips
    for each order alone, what its pairs save on common trips, how many pairs there are, and 1.
    Then the batches of the best plans correct the pairs that they hold.

    Parameters
    ----------
    orders
        The question.
    length
        Returns the length of a shortest tour of a batch.
    rng
        Draws the batches.
    """

    def __init__(
        self, orders: Orders, length: Callable[[Batch], float], rng: np.random.Generator
    ) -> None:
        self._orders, self._length = orders, length
        alone, count = orders.alone, len(orders.weights)
        self._saved = np.zeros((count, count))
        for i in range(count):
            common = lengths_of(orders.layout, orders.masks[i] | orders.masks)
            self._saved[i] = alone[i] + alone - common
        np.fill_diagonal(self._saved, 0.0)
        batches = [self._random_batch(rng) for _ in range(SAMPLE)]
        facts = np.array([self._facts(batch) for batch in batches])
        lengths = np.array([length(batch) for batch in batches])
        self._fitted: Floats = np.linalg.lstsq(facts, lengths, rcond=None)[0]

    @property
    def alone(self) -> Floats:
        """What each order adds by itself, shape (orders,)."""
        return np.asarray(self._fitted[0] * self._orders.alone)

    @property
    def pairs(self) -> Floats:
        """What each pair saves on a common trip by the fit alone, shape (orders, orders)."""
        found = self._fitted[1] * self._saved + self._fitted[2]
        np.fill_diagonal(found, 0.0)
        return np.asarray(-found)

    def fitted(
        self, orders: Ints, rows: Bools, lengths: Floats, ridge: float
    ) -> tuple[Floats, Floats]:
        """Return what some orders add alone and save in pairs, fitted to batches of just these.

        Parameters
        ----------
        orders
            Shape (n,).
        rows
            Shape (batches, n): which of them each batch holds.
        lengths
            Shape (batches,): of their shortest tours.
        ridge
            Pull towards the fit of all orders: weight of a squared difference beside a batch's.
        """
        count = len(orders)
        first, second = np.triu_indices(count, 1)
        facts = np.hstack([rows, -1.0 * (rows[:, first] & rows[:, second])])
        pairs = self.pairs[np.ix_(orders, orders)]
        known = np.concatenate([self.alone[orders], pairs[first, second]])
        # Fewer batches than coefficients: ridge regression in its dual form.
        kernel = np.asarray(np.matmul(facts, facts.T)) + ridge * np.eye(len(rows))
        missed = lengths - np.asarray(np.matmul(facts, known))
        known = known + np.asarray(np.matmul(facts.T, np.linalg.solve(kernel, missed)))
        savings = np.zeros((count, count))
        savings[first, second] = savings[second, first] = known[count:]
        return known[:count], savings

    def savings(self, plans: Iterable[Iterable[Batch]]) -> Floats:
        """Return what each pair saves on a common trip, shape (orders, orders).

        Parameters
        ----------
        plans
            The best so far: what their batches save more or less than the fit says is shared
            among the pairs of each, and a pair gets the mean of its shares.
        """
        count = len(self._orders.weights)
        total, times = np.zeros((count, count)), np.zeros((count, count))
        for batch in (batch for plan in plans for batch in plan if len(batch) > 1):
            pairs = len(batch) * (len(batch) - 1) / 2
            expected = float(np.dot(self._fitted, self._facts(batch)))
            at = np.ix_(batch, batch)
            total[at] += (expected - self._length(batch)) / pairs
            times[at] += 1.0
        learnt = total / np.maximum(times, 1.0)
        found = learnt - self._fitted[1] * self._saved - self._fitted[2]
        # Plans have about as many pairs, so only differences between pairs matter.
        level = float(found[np.triu_indices(count, 1)].mean()) if count > 1 else 0.0
        found = found - level
        np.fill_diagonal(found, 0.0)
        return np.asarray(found)

    def _random_batch(self, rng: np.random.Generator) -> Batch:
        room, batch = int(self._orders.capacities[0]), []
        for order in rng.permutation(len(self._orders.weights)).tolist():
            if self._orders.weights[order] <= room:
                batch.append(order)
                room -= int(self._orders.weights[order])
        return tuple(sorted(batch))

    def _facts(self, batch: Batch) -> list[float]:
        at = list(batch)
        saved = float(self._saved[np.ix_(at, at)].sum()) / 2.0
        alone = float(self._orders.alone[at].sum())
        return [alone, saved, len(at) * (len(at) - 1) / 2, 1.0]
