"""Batches of whole orders as binary quadratic models: orders to trips, or batches to a plan.

**Assignment** has x[o,t]: order o is on trip t. The tour past a batch is not quadratic, so its
length is replaced by a surrogate that adds over pairs, the lengths of trips for each order alone
less what each pair saves on a common trip:

    E = sum_o alone[o] - sum_t sum_{i<j} saving[i,j] x[i,t] x[j,t]
        + A sum_o (1 - sum_t x[o,t])^2 + B sum_t (load[t] + slack[t] - capacity[t])^2

A plan that fits has the surrogate of its length as its energy. The slack of a trip reaches the room
that all trips together leave free: no plan leaves more on one of them.

**Selection** has c[k]: batch k of a given list is a trip, at its exact length:

    E = sum_k length[k] c[k] + A sum_o (1 - sum_{k holds o} c[k])^2

A plan has its length as its energy. Robots are not in this energy: a read whose batches need more
or larger robots than there are is counted as overloaded. Under `safe` weights
the state of least energy is the best plan, where there is one; `measured` ones are smaller, so that
an annealer can move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._arrays import Bools, Floats, Ints
from qrobot.models.slack import slack_bits, slack_coefficients

__all__ = ["Assignment", "BatchModel", "Partitions", "Selection"]

Rows = npt.NDArray[np.int8]


@dataclass(frozen=True, slots=True)
class Partitions:
    """What reads say: which orders share a trip, and what is broken.

    Parameters
    ----------
    trips
        Shape (reads, orders): a trip of each order; -1 on none, the first of several.
    missing, repeated
        Shape (reads,): orders on no trip, and on several.
    overload
        Shape (reads,): units of weight above the capacities.
    """

    trips: Ints
    missing: Ints
    repeated: Ints
    overload: Ints

    @property
    def feasible(self) -> Bools:
        """Which reads are plans, shape (reads,)."""
        return np.asarray(self.missing + self.repeated + self.overload == 0)


class BatchModel(Protocol):
    """A binary quadratic model whose reads are partitions of orders."""

    @property
    def bqm(self) -> dimod.BinaryQuadraticModel:
        """The model."""

    def decode_all(self, samples: dimod.SampleSet) -> Partitions:
        """Judge all samples of a set."""

    def draw(self, count: int, rng: np.random.Generator) -> Partitions:
        """Return random proposals, the control of a sampler."""


class Assignment:
    """Orders to trips.

    Parameters
    ----------
    weights
        Shape (orders,): whole units.
    capacities
        Shape (trips,).
    alone
        Shape (orders,): length of a trip for each order alone.
    savings
        Shape (orders, orders), symmetric: what a pair saves on a common trip.
    assign, capacity
        The weights A and B; the safe ones where left out.
    """

    def __init__(
        self,
        weights: Ints,
        capacities: Ints,
        alone: Floats,
        savings: Floats,
        assign: float | None = None,
        capacity: float | None = None,
    ) -> None:
        self.weights, self.capacities, self.alone = weights, capacities, alone
        self.savings = np.where(np.eye(len(weights), dtype=bool), 0.0, savings)
        safe = self.safe(self.savings)
        self.assign = safe[0] if assign is None else assign
        self.capacity = safe[1] if capacity is None else capacity
        self.order, self.trip = np.nonzero(weights[:, None] <= capacities[None, :])
        spare = int(capacities.sum() - weights.sum())
        self.slack = [
            slack_coefficients(max(0, min(int(room), spare))) if room < weights.sum() else None
            for room in capacities
        ]

    @staticmethod
    def safe(savings: Floats) -> tuple[float, float]:
        """Return weights under which the least energy is a plan, where there is one.

        No state saves more than half of the sum of all savings (by their amounts: those of a
        surrogate may be negative) and, for each time that an order is on one trip more, half of
        what that order saves with all others.
        """
        gained = np.abs(savings).sum(axis=1)
        most = float(gained.sum()) / 2.0
        margin = max(1.0, 0.01 * most)
        return most + float(gained.max(initial=0.0)) / 2.0 + margin, most + margin

    @staticmethod
    def measured(weights: Ints, savings: Floats, capacity: int) -> tuple[float, float]:
        """Return weights near to what breaking a constraint gains."""
        gain = Assignment.usual_gain(weights, savings, capacity)
        return 3.0 * gain, 0.4 * gain / max(1.0, float(weights.mean()))

    @staticmethod
    def usual_gain(weights: Ints, savings: Floats, capacity: int) -> float:
        """Return what an order gains among the best mates that fit: a scale of energies."""
        mates = max(1, round(capacity / max(1.0, float(weights.mean()))) - 1)
        best = -np.sort(-np.abs(savings), axis=1)[:, :mates]
        return max(float(best.sum(axis=1).mean()), 1e-9)

    @cached_property
    def labels(self) -> list[str]:
        """Names of the variables: ``x[o,t]`` and ``slack[t,b]``; t counts from 1."""
        named = [
            f"x[{o},{t + 1}]" for o, t in zip(self.order.tolist(), self.trip.tolist(), strict=True)
        ]
        for t, bits in enumerate(self.slack):
            named += [f"slack[{t + 1},{b}]" for b in range(0 if bits is None else len(bits))]
        return named

    @cached_property
    def bqm(self) -> dimod.BinaryQuadraticModel:
        """The model: binary, in the order of `labels`."""
        size = len(self.labels)
        q = np.zeros((size, size))
        offset = float(self.alone.sum())
        for order in range(len(self.weights)):
            at = np.flatnonzero(self.order == order)
            offset += _square(q, at, np.ones(len(at)), 1.0, self.assign)
        begin = len(self.order)
        for t, bits in enumerate(self.slack):
            at = np.flatnonzero(self.trip == t)
            here = self.order[at]
            # Both halves of the symmetric matrix: each pair counts once.
            q[np.ix_(at, at)] -= self.savings[np.ix_(here, here)] / 2.0
            if bits is None:
                continue
            own = np.arange(begin, begin + len(bits))
            begin += len(bits)
            factors = np.concatenate([self.weights[here], bits]).astype(np.float64)
            room = float(self.capacities[t])
            offset += _square(q, np.concatenate([at, own]), factors, room, self.capacity)
        return _model(q, offset, self.labels)

    def decode_all(self, samples: dimod.SampleSet) -> Partitions:
        """Judge all samples of a set."""
        rows = _matrix(samples, self.labels)
        on = np.zeros((len(rows), len(self.weights), len(self.capacities)), dtype=bool)
        on[:, self.order, self.trip] = rows[:, : len(self.order)] > 0
        times = on.sum(axis=2)
        loads = np.einsum("rot,o->rt", on.astype(np.int64), self.weights)
        return Partitions(
            trips=np.where(times > 0, on.argmax(axis=2), -1),
            missing=(times == 0).sum(axis=1),
            repeated=(times > 1).sum(axis=1),
            overload=np.maximum(loads - self.capacities, 0).sum(axis=1),
        )

    def encode(self, trips: Ints) -> dict[str, int]:
        """Return the sample in which each order is on one trip, its slack as it should be."""
        values = (self.trip == trips[self.order]).astype(int).tolist()
        for t, bits in enumerate(self.slack):
            if bits is not None:
                left = int(self.capacities[t] - self.weights[trips == t].sum())
                values += slack_bits(left, bits).tolist()
        return dict(zip(self.labels, values, strict=True))

    def draw(self, count: int, rng: np.random.Generator) -> Partitions:
        """Return orders dealt in random sequence to random trips that have room, else to any."""
        trips = np.zeros((count, len(self.weights)), dtype=np.int64)
        room = np.tile(self.capacities, (count, 1))
        reads = np.arange(count)
        for orders in rng.permuted(np.tile(np.arange(len(self.weights)), (count, 1)), axis=1).T:
            fits = room >= self.weights[orders, None]
            chosen = (rng.random(room.shape) + fits).argmax(axis=1)
            trips[reads, orders] = chosen
            room[reads, chosen] -= self.weights[orders]
        none = np.zeros(count, dtype=np.int64)
        over = np.maximum(-room, 0).sum(axis=1)
        return Partitions(trips=trips, missing=none, repeated=none, overload=over)


class Selection:
    """Batches to a plan: a set partition.

    Parameters
    ----------
    batches
        The orders of each.
    lengths
        Shape (batches,): of their tours.
    weights, capacities
        As of `Assignment`.
    cover
        The weight A; the safe one where left out.
    """

    def __init__(
        self,
        batches: Sequence[Sequence[int]],
        lengths: Floats,
        weights: Ints,
        capacities: Ints,
        cover: float | None = None,
    ) -> None:
        self.lengths, self.weights = lengths, weights
        self.capacities = np.sort(capacities)[::-1]
        self.holds = np.zeros((len(batches), len(weights)), dtype=np.int64)
        for k, batch in enumerate(batches):
            self.holds[k, list(batch)] = 1
        self.labels = [f"c[{k}]" for k in range(len(batches))]
        self.cover = self.safe() if cover is None else cover

    def _dearest(self) -> Floats:
        """Return the most that each order costs in a batch, by equal shares."""
        shares = self.lengths / np.maximum(1, self.holds.sum(axis=1))
        return np.asarray((self.holds * shares[:, None]).max(axis=0, initial=0.0))

    def safe(self) -> float:
        """Return a weight that no plan of these batches costs: one order left out is dearer."""
        return float(self._dearest().sum()) + 1.0

    def measured(self) -> float:
        """Return a weight at which leaving out a batch never pays."""
        return float(self._dearest().max(initial=1e-9))

    @cached_property
    def bqm(self) -> dimod.BinaryQuadraticModel:
        """The model: binary, in the order of `labels`."""
        q = self.cover * np.asarray(np.matmul(self.holds, self.holds.T), dtype=np.float64)
        size = self.holds.sum(axis=1)
        q[np.diag_indices(len(q))] += self.lengths - 2.0 * self.cover * size
        return _model(q, self.cover * len(self.weights), self.labels)

    def decode_all(self, samples: dimod.SampleSet) -> Partitions:
        """Judge all samples of a set."""
        return self._judge(_matrix(samples, self.labels))

    def _judge(self, chosen: Rows) -> Partitions:
        times = np.asarray(np.matmul(chosen.astype(np.int64), self.holds))
        trips = np.full(times.shape, -1, dtype=np.int64)
        over = np.zeros(len(chosen), dtype=np.int64)
        loads = np.asarray(np.matmul(self.holds, self.weights))
        for read, row in enumerate(chosen):
            taken = np.flatnonzero(row)
            for number, k in enumerate(taken.tolist()):
                trips[read, (self.holds[k] > 0) & (trips[read] < 0)] = number
            heavy = np.sort(loads[taken])[::-1]
            room = np.zeros(len(heavy), dtype=np.int64)
            room[: len(self.capacities)] = self.capacities[: len(heavy)]
            over[read] = np.maximum(heavy - room, 0).sum()
        return Partitions(
            trips=trips,
            missing=(times == 0).sum(axis=1),
            repeated=(times > 1).sum(axis=1),
            overload=over,
        )

    def encode(self, chosen: Sequence[int]) -> dict[str, int]:
        """Return the sample in which the batches of these numbers are trips."""
        return {label: int(k in set(chosen)) for k, label in enumerate(self.labels)}

    def draw(self, count: int, rng: np.random.Generator) -> Partitions:
        """Return batches taken in random sequence as long as they share no order."""
        rows = np.zeros((count, len(self.labels)), dtype=np.int8)
        for row in rows:
            free = np.ones(len(self.weights), dtype=bool)
            for k in rng.permutation(len(self.labels)).tolist():
                own = self.holds[k] > 0
                if free[own].all():
                    row[k], free[own] = 1, False
        return self._judge(rows)


def _square(q: Floats, at: npt.NDArray[np.intp], factors: Floats, sum_: float, by: float) -> float:
    """Add ``by (factors x - sum)^2`` to a matrix; return its constant."""
    q[np.ix_(at, at)] += by * np.outer(factors, factors)
    q[at, at] -= 2.0 * by * sum_ * factors
    return by * sum_ * sum_


def _model(q: Floats, offset: float, labels: list[str]) -> dimod.BinaryQuadraticModel:
    rows, columns = np.nonzero(np.triu(q, 1))
    return dimod.BinaryQuadraticModel.from_numpy_vectors(
        q.diagonal().copy(),
        (rows, columns, 2.0 * q[rows, columns]),
        offset,
        "BINARY",
        variable_order=labels,
    )


def _matrix(samples: dimod.SampleSet, labels: list[str]) -> Rows:
    """Return samples as 0 and 1 in the order of the labels."""
    where = {label: k for k, label in enumerate(samples.variables)}
    columns = [where[label] for label in labels]
    return np.asarray(samples.record.sample[:, columns] > 0, dtype=np.int8)
