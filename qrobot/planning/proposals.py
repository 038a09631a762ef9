"""The loop of a sampler and exact tours: it proposes batches, which are priced and repaired.

Each round has two models (`qrobot.models.batches`). The assignment has the savings of a surrogate
that learns from the best plans (`qrobot.planning.surrogate`). Its reads are judged and priced as
they are; then each is repaired and improved by a fixed number of moves of the compiled annealing.
The batches of the best plans so far are the columns of the selection, whose reads are judged,
priced and repaired in the same way.

What proposes is exchanged for the control: `RandomSource` deals orders and draws batches at random,
and everything else is the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import dimod
import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import OnBest, Stop
from qrobot.backends.classical.batching.aisles import first_fit
from qrobot.backends.classical.batching.annealing import anneal, place
from qrobot.backends.classical.batching.state import new_state
from qrobot.backends.classical.orders import Batch, Trips, lengths_of, orders_of, tie_of
from qrobot.errors import InputError
from qrobot.models.batches import Assignment, BatchModel, Partitions, Selection
from qrobot.models.layout import MAX_VARIABLES
from qrobot.planning.surrogate import Surrogate
from qrobot.problem import AisleWarehouse, Instance

__all__ = ["BatchLoop", "RandomSource", "SamplerSource", "Source", "Tally"]

READS = 10
"""Proposals of a round from each model, unless the caller says so."""

STEPS, MOVES = 40, 1_000
"""Repair of a proposal: temperatures, and moves at each."""

WARM, COLD = 0.02, 0.002
"""First and last temperature of the repair, as shares of a mean trip."""

DEARER, CHEAPER = 1.3, 0.9
"""How the price of overload changes where a plan has some, and where it has none."""

SPARE_TRIPS = 2
"""Trips of the repair more than a first packing needs."""

PLANS, COLUMNS = 40, 400
"""Best plans that are kept, and batches of them in the selection."""

COMPARED = 100
"""Proposals whose distances to each other are measured."""


class Source(Protocol):
    """What proposes."""

    def propose(
        self, model: BatchModel, scale: float, reads: int, stop: Stop, seed: int
    ) -> Partitions:
        """Return reads of a model whose usual energies are of this scale."""


class SamplerSource:
    """Proposals of a sampler.

    Parameters
    ----------
    ask
        Samples a model: told the scale of its energies, the number of reads, a stop and a seed.
    """

    def __init__(self, ask: Callable[[BatchModel, float, int, Stop, int], dimod.SampleSet]) -> None:
        self._ask = ask

    def propose(
        self, model: BatchModel, scale: float, reads: int, stop: Stop, seed: int
    ) -> Partitions:
        """Return the sampler's reads, each as often as it occurred."""
        samples = self._ask(model, scale, reads, stop, seed)
        found = model.decode_all(samples)
        times = samples.record.num_occurrences.astype(np.int64)
        return Partitions(
            *(
                np.repeat(part, times, axis=0)
                for part in (found.trips, found.missing, found.repeated, found.overload)
            )
        )


class RandomSource:
    """Random proposals: the control."""

    def propose(
        self,
        model: BatchModel,
        scale: float,  # noqa: ARG002
        reads: int,
        stop: Stop,  # noqa: ARG002
        seed: int,
    ) -> Partitions:
        """Return random partitions."""
        return model.draw(reads, np.random.default_rng(seed))


@dataclass(slots=True)
class Tally:
    """What the proposals of a model were by themselves, and what repair made of them.

    Parameters
    ----------
    variables
        Of the largest model.
    lengths
        Of the proposals that are plans as they are.
    repaired
        Of all that repair made plans of.
    proposals
        How many there were.
    partitions, repaired_partitions
        The first `COMPARED` of each.
    """

    variables: int = 0
    proposals: int = 0
    lengths: list[float] = field(default_factory=list)
    repaired: list[float] = field(default_factory=list)
    partitions: list[Ints] = field(default_factory=list)
    repaired_partitions: list[Ints] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        return {
            "variables": self.variables,
            "proposals": self.proposals,
            "plans": len(self.lengths),
            "best": min(self.lengths, default=None),
            "mean": float(np.mean(self.lengths)) if self.lengths else None,
            "repaired": len(self.repaired),
            "repaired_best": min(self.repaired, default=None),
            "repaired_mean": float(np.mean(self.repaired)) if self.repaired else None,
            "repaired_spread": float(np.std(self.repaired)) if self.repaired else None,
            "diversity": mean_distance(self.partitions),
            "repaired_diversity": mean_distance(self.repaired_partitions),
        }


def mean_distance(partitions: list[Ints]) -> float | None:
    """Return the mean distance of all pairs of partitions, None where there is no pair.

    The distance is the share of pairs of orders on one trip in either that are not in both.
    """
    if len(partitions) < 2:
        return None
    rows, columns = np.triu_indices(partitions[0].size, 1)
    shared = np.array([(p[rows] == p[columns]) & (p[rows] >= 0) for p in partitions], dtype=float)
    both = np.asarray(np.matmul(shared, shared.T))
    sizes = both.diagonal()
    either = np.maximum(sizes[:, None] + sizes[None, :] - both, 1.0)
    return float(1.0 - (both / either)[np.triu_indices(len(partitions), 1)].mean())


class BatchLoop:
    """One run of the loop.

    Parameters
    ----------
    instance
        Whole orders in aisles.
    seed
        Of every random choice.
    source
        What proposes.
    on_best
        Told the routes and the length of every better plan.
    variables
        Most that a model may have.

    Raises
    ------
    InputError
        When the assignment has more.
    """

    def __init__(
        self,
        instance: Instance,
        seed: int,
        source: Source,
        on_best: OnBest | None = None,
        variables: int = MAX_VARIABLES,
    ) -> None:
        assert isinstance(instance.warehouse, AisleWarehouse)
        self.source, self.seed, self._on_best = source, seed, on_best
        orders = orders_of(instance)
        self.trips = Trips(instance)
        packed = len(np.unique(first_fit(orders)))
        self.slots = orders.capacities[:packed]
        least = packed * len(orders.weights)
        if least > variables:
            raise InputError(
                f"{len(orders.weights)} orders on {packed} trips need a model of more than {least} "
                f"binary variables, the sampler takes {variables}",
                field="backend",
                advice="use backend auto, or plan fewer orders at a time",
            )
        self.columns = min(COLUMNS, variables)
        if (orders.capacities == orders.capacities[0]).all():
            orders = orders._replace(capacities=orders.capacities[: packed + SPARE_TRIPS])
        self.orders = orders
        self.state = new_state(orders, tie_of(instance.warehouse, orders), seed, 1)
        self.rng = np.random.default_rng(seed)
        self._known: dict[Batch, float] = {}
        self.plans: dict[frozenset[Batch], float] = {}
        self.best = math.inf
        self.work = self.rounds = 0
        self.assignment, self.selection = Tally(), Tally()
        self.surrogate = Surrogate(orders, self._length, self.rng)

    def run(
        self,
        stop: Stop,
        reads: int | None = None,
        rounds: int | None = None,
        most: int | None = None,
    ) -> None:
        """Propose until `stop`, or until so many rounds or proposals; one is a unit of work.

        There is a proposal even when time is up.
        """
        stop = stop.within(max_work=most)
        while True:
            self._round(self.assignment, self._assignment(), reads or READS, stop)
            if self.plans and not stop(self.work):
                self._round(self.selection, self._selection(), reads or READS, stop)
            self.rounds += 1
            if stop(self.work) or self.rounds == rounds:
                break

    def _round(self, tally: Tally, made: tuple[BatchModel, float], reads: int, stop: Stop) -> None:
        model, scale = made
        if stop.max_work is not None:
            reads = min(reads, max(1, stop.max_work - self.work))
        seed = int(self.rng.integers(2**31 - 1))
        found = self.source.propose(model, scale, reads, stop, seed)
        tally.variables = max(tally.variables, model.bqm.num_variables)
        tally.proposals += len(found.trips)
        self.work += len(found.trips)
        room = COMPARED - len(tally.partitions)
        tally.partitions += list(found.trips[: max(0, room)])
        # All are priced before any is changed.
        for trips in found.trips[found.feasible]:
            tally.lengths.append(self._keep(self._batches(trips)))
        for trips in found.trips:
            if stop() and self.plans:
                break
            self._repair(tally, trips)

    def _repair(self, tally: Tally, trips: Ints) -> None:
        """Make a plan of a proposal by a fixed number of moves, through priced overload."""
        orders, state = self.orders, self.state
        start = self._completed(trips)
        state.best[:] = -1
        state.figures[1] = np.inf
        # A proposal is repaired the same whichever came before it.
        state.random[0] = np.uint64(2 * (self.seed + len(tally.repaired)) + 1)
        place(orders, state, start)
        scale = float(state.length.sum()) / max(1, int((state.size > 0).sum()))
        state.figures[0] = scale / max(1, int(orders.capacities[0]))
        for step in range(STEPS):
            heat = scale * WARM * (COLD / WARM) ** (step / (STEPS - 1))
            _, over = anneal(orders, state, MOVES, heat, -np.inf)
            price = state.figures[0] * (DEARER if over else CHEAPER)
            usual = scale / max(1, int(orders.capacities[0]))
            state.figures[0] = min(max(price, 0.02 * usual), 20.0 * usual)
        if state.best[0] < 0:
            return
        made = state.best.copy()
        tally.repaired.append(self._keep(self._batches(made)))
        if len(tally.repaired_partitions) < COMPARED:
            tally.repaired_partitions.append(made)

    def _completed(self, trips: Ints) -> Ints:
        """Return trips of all orders: those on none go where there is the most room."""
        numbers = {trip: k for k, trip in enumerate(np.unique(trips[trips >= 0]).tolist())}
        count = len(self.orders.capacities)
        made = np.array([numbers.get(trip, -1) for trip in trips.tolist()], dtype=np.int64)
        made[made >= count] = -1
        weights = self.orders.weights
        loads = np.array([weights[made == k].sum() for k in range(count)])
        # The heaviest batch on the largest robot.
        place_of = np.argsort(np.argsort(-loads, kind="stable"), kind="stable")
        made = np.where(made >= 0, place_of[made], -1)
        room = self.orders.capacities - np.sort(loads)[::-1]
        for order in sorted(np.flatnonzero(made < 0).tolist(), key=lambda o: -weights[o]):
            made[order] = int(np.argmax(room))
            room[made[order]] -= weights[order]
        return made

    def _batches(self, trips: Ints) -> frozenset[Batch]:
        return frozenset(
            tuple(np.flatnonzero(trips == trip).tolist()) for trip in np.unique(trips).tolist()
        )

    def _length(self, batch: Batch) -> float:
        known = self._known.get(batch)
        if known is None:
            words = np.bitwise_or.reduce(self.orders.masks[list(batch)], axis=0)
            known = self._known[batch] = float(lengths_of(self.orders.layout, words[None])[0])
        return known

    def _keep(self, plan: frozenset[Batch]) -> float:
        """Keep a plan among the best; return its length by exact tours."""
        length = sum(self._length(batch) for batch in sorted(plan))
        self.plans[plan] = length
        if len(self.plans) > 2 * PLANS:
            self.plans = {best: self.plans[best] for best in self._best_plans()[:PLANS]}
        if length < self.best - 1e-9:
            self.best = length
            if self._on_best is not None:
                self._on_best(self.trips.routes(sorted(plan)), length)
        return length

    def _assignment(self) -> tuple[BatchModel, float]:
        weights, room = self.orders.weights, int(self.slots[0])
        savings = self.surrogate.savings(self._best_plans()[:PLANS])
        gain = Assignment.usual_gain(weights, savings, room)
        penalties = Assignment.measured(weights, savings, room)
        model = Assignment(weights, self.slots, self.surrogate.alone, savings, *penalties)
        return model, 4.0 * gain

    def _best_plans(self) -> list[frozenset[Batch]]:
        return sorted(self.plans, key=lambda plan: (self.plans[plan], sorted(plan)))

    def _selection(self) -> tuple[BatchModel, float]:
        columns: dict[Batch, None] = {}
        for plan in self._best_plans():
            if len(columns) >= self.columns:
                break
            columns.update(dict.fromkeys(sorted(plan)))
        batches = list(columns)[: self.columns]
        lengths: Floats = np.array([self._length(batch) for batch in batches])
        model = Selection(batches, lengths, self.orders.weights, self.orders.capacities)
        model.cover = model.measured()
        return model, float(lengths.mean())

    def facts(self) -> Mapping[str, Any]:
        """Return the figures of both models."""
        return {
            "rounds": self.rounds,
            "best": None if math.isinf(self.best) else self.best,
            "assignment": self.assignment.to_dict(),
            "selection": self.selection.to_dict(),
        }
