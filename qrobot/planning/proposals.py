"""The loop of a sampler and exact tours: it proposes batches, which are priced and repaired.

A round has three kinds of models (`qrobot.models.batches`). The assignment of all orders has the
savings of a surrogate that learns from the best plans (`qrobot.planning.surrogate`). Assignments of
two or three trips of a good plan (`qrobot.planning.neighbourhoods`) have savings fitted to batches
of just their orders. The selection has the batches of the best plans as columns. Reads are judged
and priced by exact tours as they are; then they are repaired and improved by a fixed number of
moves of the compiled annealing, of a neighbourhood only the best one.

What proposes is exchanged for the control: `RandomSource` deals orders and draws batches at random,
and everything else is the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
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
from qrobot.planning.neighbourhoods import Neighbourhood, Neighbourhoods
from qrobot.planning.surrogate import Surrogate
from qrobot.planning.tally import COMPARED, Tally
from qrobot.problem import AisleWarehouse, Instance

__all__ = ["BatchLoop", "RandomSource", "SamplerSource", "Source"]

READS = 10
"""Proposals of a round from each model, unless the caller says so."""

PARTS = 100
"""Neighbourhoods of a round."""

USUAL = 5.0
"""Mean rank of the plan whose neighbourhood is taken."""

STEPS, MOVES, FEW = 40, 1_000, 100
"""Repair of a proposal: temperatures, and moves at each; few where a good plan is near."""

WARM, COLD = 0.02, 0.002
"""First and last temperature of the repair, as shares of a mean trip."""

DEARER, CHEAPER = 1.3, 0.9
"""How the price of overload changes where a plan has some, and where it has none."""

SPARE_TRIPS = 2
"""Trips of the repair more than a first packing needs."""

PLANS, COLUMNS = 40, 400
"""Best plans that are kept, and batches of them in the selection."""


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
    repairs
        Whether proposals are repaired; without, plans are the source's own.

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
        *,
        repairs: bool = True,
    ) -> None:
        assert isinstance(instance.warehouse, AisleWarehouse)
        self.source, self.seed, self._on_best, self.repairs = source, seed, on_best, repairs
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
        self.assignment, self.neighbourhood, self.selection = Tally(), Tally(), Tally()
        self.surrogate = Surrogate(orders, self._length, self.rng)
        self._parts = Neighbourhoods(orders, self.surrogate, self._length, self.rng)

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
        stop, reads = stop.within(max_work=most), reads or READS
        while True:
            self._ask(self.assignment, self._assignment(), reads, stop)
            if not self.plans:
                self._pack()
            for _ in range(PARTS if self.plans else 0):
                if stop(self.work):
                    break
                self._ask_part(reads, stop)
            if self.plans and not stop(self.work):
                self._ask(self.selection, self._selection(), reads, stop)
            self.rounds += 1
            if stop(self.work) or self.rounds == rounds:
                break

    def _pack(self) -> None:
        """Begin from a first packing, if it has no overload."""
        first, orders = first_fit(self.orders), self.orders
        loads = np.bincount(first, orders.weights, len(orders.capacities))
        if (loads <= orders.capacities).all():
            self._keep(self._batches(first))

    def _ask_part(self, reads: int, stop: Stop) -> None:
        """Let a few trips of a good plan be dealt out anew."""
        plans = self._best_plans()
        at = min(int(self.rng.geometric(1.0 / USUAL)) - 1, len(plans) - 1)
        part = self._parts.draw(plans[at])
        self._ask(self.neighbourhood, self._parts.model(part), reads, stop, part)

    def _ask(
        self,
        tally: Tally,
        made: tuple[BatchModel, float],
        reads: int,
        stop: Stop,
        part: Neighbourhood | None = None,
    ) -> None:
        """Take proposals, price those that are plans, then repair: all, or of a part the best."""
        model, scale = made
        if stop.max_work is not None:
            reads = min(reads, max(1, stop.max_work - self.work))
        seed = int(self.rng.integers(2**31 - 1))
        found = self.source.propose(model, scale, reads, stop, seed)
        proposed = found.trips if part is None else part.completed(found.trips)
        tally.variables = max(tally.variables, model.bqm.num_variables)
        tally.proposals += len(proposed)
        self.work += len(proposed)
        tally.partitions += list(proposed[: max(0, COMPARED - len(tally.partitions))])
        # All are priced before any is changed.
        lengths = np.full(len(proposed), np.inf)
        before = self.best
        for read in np.flatnonzero(found.feasible).tolist():
            lengths[read] = self._keep(self._batches(proposed[read]))
        tally.lengths += lengths[found.feasible].tolist()
        tally.better += self.best < before - 1e-9
        if part is not None:
            broken = found.overload + len(self.orders.weights) * (found.missing + found.repeated)
            proposed = proposed[np.lexsort((lengths, broken))[:1]]
        for trips in proposed if self.repairs else ():
            if stop() and self.plans:
                break
            self._repair(tally, trips, MOVES if part is None else FEW)

    def _repair(self, tally: Tally, trips: Ints, moves: int) -> None:
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
            _, over = anneal(orders, state, moves, heat, -np.inf)
            price = state.figures[0] * (DEARER if over else CHEAPER)
            usual = scale / max(1, int(orders.capacities[0]))
            state.figures[0] = min(max(price, 0.02 * usual), 20.0 * usual)
        if state.best[0] < 0:
            return
        made, before = state.best.copy(), self.best
        tally.repaired.append(self._keep(self._batches(made)))
        tally.repaired_better += self.best < before - 1e-9
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
            "neighbourhood": self.neighbourhood.to_dict(),
            "selection": self.selection.to_dict(),
        }
