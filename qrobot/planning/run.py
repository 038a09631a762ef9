"""One run of `solve`: the best plan so far and its bound, the clock, the record, who listens."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends import Planner, Routes, Search, Stop
from qrobot.backends.base import OnBest, PlanReads
from qrobot.errors import BackendError, QRobotError
from qrobot.plan.dealing import Seats, assign, cost
from qrobot.plan.objective import DISTANCE, Objective
from qrobot.planning.result import SamplerReport, Timing
from qrobot.problem import Instance

__all__ = ["TIE", "Best", "Progress", "Record", "Run", "plan_fits", "seats_fit"]


TIE = 1e-11
"""Relative: distances closer than this are equal, and the fewer trips win."""


@dataclass(frozen=True, slots=True)
class Progress:
    """What a listener is told while `solve` works.

    Parameters
    ----------
    step
        The part that works now, such as ``pyvrp``.
    elapsed
        Seconds since the start.
    cost
        Cost of the best plan so far, or ``None``.
    bound
        Lower bound so far.
    objective
        What the cost is, such as ``distance``.
    """

    step: str
    elapsed: float
    cost: float | None
    bound: float
    objective: str = "distance"


class Best:
    """The best plan so far and the bound, by an objective.

    Parameters
    ----------
    instance
        The question.
    objective
        What a plan costs.
    on_best
        Told the routes and their distance whenever a better plan is kept.
    seated
        Whether it is part of the plan who makes which trip, though it costs the same; costs are
        then compared and bounded in full, not by their metres alone.
    """

    def __init__(
        self,
        instance: Instance,
        objective: Objective = DISTANCE,
        on_best: OnBest | None = None,
        *,
        seated: bool = False,
    ) -> None:
        self.instance = instance
        self.objective = objective
        # One rate for all robots: a shortest plan is a cheapest one.
        self.shortest_is_best = objective.common_rate(instance) is not None
        self.by_distance = self.shortest_is_best and not seated  # distances are compared then
        self.routes: Routes | None = None
        self.seats: Seats | None = None  # where it matters who makes which trip, and when
        self.cost = self.length = float("inf")
        self.bound = 0.0
        self.proven = False
        self._on_best = on_best

    def offer(
        self,
        routes: Sequence[Sequence[int]],
        _cost: float | None = None,
        *,
        seats: Seats | None = None,
    ) -> None:
        """Keep routes when they are valid and better: cheaper, or as cheap with fewer trips.

        Where metres are not all that counts, of plans of one cost the shorter is better.
        `seats` say who makes each route, in which sequence; by default `dealing.assign` does.
        """
        kept = [[int(v) for v in route] for route in routes if len(route)]
        if not plan_fits(self.instance, kept):
            return
        if seats is not None and not seats_fit(self.instance, kept, seats):
            return
        length = self.instance.length(kept)
        if math.isinf(length):
            return  # it takes a forbidden way
        if self.by_distance:
            value, seats = length, None
        else:
            seats = seats or assign(self.instance, kept, self.objective)
            value = cost(self.instance, kept, self.objective, seats)
            if math.isinf(value):
                return  # it is back after a deadline
        if self.routes is None or self._is_better(value, length, len(kept)):
            self.routes, self.seats, self.cost, self.length = kept, seats, value, length
            if self._on_best is not None:
                self._on_best(kept, length)

    def _is_better(self, value: float, length: float, trips: int) -> bool:
        """Return whether a plan is better than the one that is kept."""
        pairs = (
            [(value, self.cost)]
            if self.by_distance
            else [(value, self.cost), (length, self.length)]
        )
        for new, old in pairs:
            slack = TIE * max(abs(new), 1e-300)
            if new < old - slack or new > old + slack:
                return new < old
        return trips < len(self.routes or [])

    def raise_bound(self, distance: float) -> None:
        """Keep a larger bound of distances; whole distances lift it to the next whole number.

        A policy may take ways that are not the shortest between stops, and not whole.
        """
        d = self.instance.stop_distances
        if self.instance.routing == "exact" and bool((d == np.round(d)).all()):
            distance = float(np.ceil(distance - 1e-6))
        if not self.by_distance:
            distance = self.objective.bound(self.instance, distance)
        self.bound = max(self.bound, distance)

    def take_bound(self, found: Search, given: Mapping[str, Any]) -> None:
        """Keep a planner's bound, of what it was `given` to make small."""
        if given:
            self.bound = max(self.bound, found.bound)
        else:
            self.raise_bound(found.bound)

    def as_cost(self, value: float) -> float:
        """Return a cost or bound of this class, maybe a distance, as the objective counts."""
        return self.objective.bound(self.instance, value) if self.by_distance else value

    def aim(self, planner: Planner) -> dict[str, Any]:
        """Return the objective as an argument of `search`, where a planner must be told."""
        able = self.objective.optimised_by(planner.capabilities.objectives, self.instance)
        return {"objective": self.objective} if able and not self.shortest_is_best else {}

    @property
    def finished(self) -> bool:
        """Whether nothing is left to gain: proven optimal, by search or by bound."""
        if self.routes is not None and self.cost <= self.bound * (1 + TIE):
            self.proven = True
        return self.proven


@dataclass(slots=True)
class Record:
    """What is told of a run: which steps, how much work, where the time went, facts to know."""

    steps: list[str] = field(default_factory=list)
    work: dict[str, int] = field(default_factory=dict)
    timing: Timing = field(default_factory=Timing)
    notes: list[str] = field(default_factory=list)
    sampler: SamplerReport | None = None
    reads: tuple[Floats, Floats | None] | None = None
    """Distances of the reads that are plans, and of the random ones."""


class Run:
    """One call of `solve`: its limits, the best plan, and the record of what was done.

    Parameters
    ----------
    instance
        The question.
    stop
        Deadline, work limit and interrupts of the whole run.
    seed
        Of every random choice.
    listener
        Told about every new step and every better plan.
    objective, on_best, seated
        As of `Best`.
    """

    def __init__(
        self,
        instance: Instance,
        stop: Stop,
        seed: int,
        listener: Callable[[Progress], None] | None = None,
        *,
        objective: Objective = DISTANCE,
        on_best: OnBest | None = None,
        seated: bool = False,
    ) -> None:
        self.instance = instance
        self.stop = stop
        self.seed = seed
        self.best = Best(instance, objective, self._tell_best, seated=seated)
        self.record = Record(notes=list(instance.notes))
        self.infeasible: str | None = None
        self.out_of_time = False
        self.check_seconds = 0.0  # kept back for the check of the plan
        self._listener, self._on_best = listener, on_best
        self._begun = time.perf_counter()

    @property
    def elapsed(self) -> float:
        """Seconds since the run began, whatever the deadline counts from."""
        return time.perf_counter() - self._begun

    @property
    def finished(self) -> bool:
        """Whether nothing is left to gain: proven optimal, or that there is no plan."""
        return self.infeasible is not None or self.best.finished

    def _tell_best(self, routes: Sequence[Sequence[int]], length: float) -> None:
        if self._on_best is not None:
            self._on_best(routes, length)
        self.tell()

    def tell(self) -> None:
        """Report progress to the listener."""
        if self._listener is not None:
            best = self.best
            step = self.record.steps[-1] if self.record.steps else "start"
            found = best.as_cost(best.cost) if best.routes is not None else None
            bound = best.as_cost(best.bound)
            self._listener(Progress(step, self.elapsed, found, bound, best.objective.name))

    def begin(self, step: str) -> None:
        """Note that a step begins; a step that goes on is named once."""
        if not self.record.steps or self.record.steps[-1] != step:
            self.record.steps.append(step)
        self.tell()

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the time of a block to a part of the timing."""
        begun = time.perf_counter()
        try:
            yield
        finally:
            timing = self.record.timing
            setattr(timing, part, getattr(timing, part) + time.perf_counter() - begun)

    def plan(self, planner: Planner, stop: Stop) -> Search:
        """Let a planner search, starting from the best plan so far, and keep what it finds.

        Raises
        ------
        BackendError
            When the planner fails.
        """
        self.begin(planner.name)
        best, aim = self.best, self.best.aim(planner)
        with self.timed("run"):
            try:
                found = planner.search(
                    self.instance,
                    stop=stop,
                    seed=self.seed,
                    start=best.routes,
                    on_best=best.offer,
                    **aim,
                )
            except Exception as error:
                ours = isinstance(error, QRobotError)
                text = str(error) if ours else f"{type(error).__name__}: {error}"
                if best.routes is not None:
                    # A plan that is there already must not be lost to a later step.
                    self.record.notes.append(f"backend {planner.name} failed ({text})")
                    return Search()
                if ours:
                    raise
                raise BackendError(f"backend {planner.name} failed: {text}") from error
        if found.reads is not None:
            self._tell_reads(planner.name, found.reads)
        work = self.record.work
        work[planner.name] = work.get(planner.name, 0) + found.work
        if found.routes is not None:
            best.offer(found.routes, seats=found.seats)
        if found.infeasible is not None and best.routes is None:
            self.infeasible = found.infeasible
        best.take_bound(found, aim)
        if found.optimal and best.routes is not None and (best.shortest_is_best or aim):
            best.proven = True
            best.bound = max(best.bound, best.cost)
        self.tell()
        return found

    def _tell_reads(self, name: str, reads: PlanReads) -> None:
        """Report the reads of a planner that samples plans."""
        # Those that take a forbidden way are not plans.
        (lengths, feasible), (random, random_feasible) = (
            (every[np.isfinite(every)], float(np.isfinite(every).mean()))
            for every in (reads.lengths, reads.random_lengths)
        )
        self.record.reads = (lengths, random)
        self.record.sampler = SamplerReport(
            backend=name,
            encoding=reads.encoding,
            variables=reads.variables,
            reads=len(reads.lengths),
            feasible_fraction=feasible,
            best=float(lengths.min()) if lengths.size else None,
            mean=float(lengths.mean()) if lengths.size else None,
            energy=reads.energy,
            random_feasible_fraction=random_feasible,
            random_best=float(random.min()) if random.size else None,
            of_plans=True,
            details=dict(reads.details),
        )


def seats_fit(instance: Instance, routes: Routes, seats: Seats) -> bool:
    """Return whether the robots that are to make routes can carry them, in so many trips."""
    if len(set(seats)) != len(routes):
        return False
    return all(
        turn < instance.robots[r].trips
        and sum(int(instance.weights[v - 1]) for v in route) <= instance.capacities[r]
        for (r, turn), route in zip(seats, routes, strict=True)
    )


def plan_fits(instance: Instance, routes: Routes) -> bool:
    """Return whether routes collect everything once, whole, within capacities and trips."""
    nodes = sorted(v for route in routes for v in route)
    if nodes != list(range(1, instance.size + 1)):
        return False
    capacities = instance.vehicle_capacities
    if len(routes) > len(capacities):
        return False
    owner = instance.order_of_node
    trips_of_order = {(int(owner[v]), t) for t, route in enumerate(routes) for v in route}
    if len(trips_of_order) != len(instance.orders):
        return False
    loads = sorted((sum(int(instance.weights[v - 1]) for v in r) for r in routes), reverse=True)
    return all(load <= room for load, room in zip(loads, capacities.tolist(), strict=False))
