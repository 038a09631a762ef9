"""One run of `solve`: the best plan so far, the bound, the clock, and who listens."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends import Planner, Routes, Search, Stop
from qrobot.backends.base import OnBest
from qrobot.errors import BackendError, QRobotError
from qrobot.plan.assignment import cost
from qrobot.plan.objective import DISTANCE, Objective
from qrobot.planning.result import SamplerReport, Timing
from qrobot.problem import Instance

__all__ = ["Progress", "Run", "plan_fits"]


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


class Run:
    """The state that strategies work on.

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
    on_best
        Told the routes and their distance whenever a better plan is kept.
    objective
        What the plan costs.
    """

    def __init__(
        self,
        instance: Instance,
        stop: Stop,
        seed: int,
        listener: Callable[[Progress], None] | None = None,
        on_best: OnBest | None = None,
        objective: Objective = DISTANCE,
    ) -> None:
        self.instance = instance
        self.objective = objective
        # One rate for all robots: a shortest plan is a cheapest, so distances are compared.
        self.by_distance = objective.common_rate(instance) is not None
        self.stop = stop
        self.seed = seed
        self.routes: Routes | None = None
        self.cost = self.length = float("inf")
        self.bound = 0.0
        self.proven = False
        self.infeasible: str | None = None
        self.out_of_time = False
        self.check_seconds = 0.0  # kept back for the check of the plan
        self.steps: list[str] = []
        self.work: dict[str, int] = {}
        self.timing = Timing()
        self.sampler: SamplerReport | None = None
        self.reads: tuple[Floats, Floats | None] | None = None
        self.notes: list[str] = list(instance.notes)
        self._listener = listener
        self._on_best = on_best
        self._begun = time.perf_counter()

    @property
    def elapsed(self) -> float:
        """Seconds since the run began, whatever the deadline counts from."""
        return time.perf_counter() - self._begun

    def offer(self, routes: Sequence[Sequence[int]], _cost: float | None = None) -> None:
        """Keep routes when they are valid and better: shorter, or as short with fewer trips."""
        kept = [[int(v) for v in route] for route in routes if len(route)]
        if not plan_fits(self.instance, kept):
            return
        length = self.instance.length(kept)
        if math.isinf(length):
            return  # it takes a forbidden way
        value = length if self.by_distance else cost(self.instance, kept, self.objective)
        slack = TIE * max(abs(value), 1e-300)
        better = self.routes is None or value < self.cost - slack
        fewer = not better and value <= self.cost + slack and len(kept) < len(self.routes or [])
        if better or fewer:
            self.routes, self.cost, self.length = kept, value, length
            if self._on_best is not None:
                self._on_best(kept, length)
            self.tell()

    def raise_bound(self, distance: float) -> None:
        """Keep a larger bound of distances; whole distances lift it to the next whole number."""
        d = self.instance.stop_distances
        if bool((d == np.round(d)).all()):
            distance = float(np.ceil(distance - 1e-6))
        if not self.by_distance:
            distance = self.objective.bound(self.instance, distance)
        self.bound = max(self.bound, distance)

    def told(self, value: float) -> float:
        """Return a cost or bound of this run as the objective counts."""
        return self.objective.bound(self.instance, value) if self.by_distance else value

    def takes_objective(self, planner: Planner) -> dict[str, Any]:
        """Return the objective as an argument of `search`, where the planner must be told."""
        able = self.objective.optimised_by(planner.capabilities.objectives)
        return {"objective": self.objective} if able and not self.by_distance else {}

    def tell(self) -> None:
        """Report progress to the listener."""
        if self._listener is not None:
            step = self.steps[-1] if self.steps else "start"
            found = self.told(self.cost) if self.routes is not None else None
            bound = self.told(self.bound)
            self._listener(Progress(step, self.elapsed, found, bound, self.objective.name))

    def begin(self, step: str) -> None:
        """Note that a step begins; a step that goes on is named once."""
        if not self.steps or self.steps[-1] != step:
            self.steps.append(step)
        self.tell()

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the time of a block to a part of the timing."""
        begun = time.perf_counter()
        try:
            yield
        finally:
            setattr(self.timing, part, getattr(self.timing, part) + time.perf_counter() - begun)

    def plan(self, planner: Planner, stop: Stop) -> Search:
        """Let a planner search, starting from the best plan so far, and keep what it finds.

        Raises
        ------
        BackendError
            When the planner fails.
        """
        self.begin(planner.name)
        objective = self.takes_objective(planner)
        with self.timed("run"):
            try:
                found = planner.search(
                    self.instance,
                    stop=stop,
                    seed=self.seed,
                    start=self.routes,
                    on_best=self.offer,
                    **objective,
                )
            except Exception as error:
                ours = isinstance(error, QRobotError)
                text = str(error) if ours else f"{type(error).__name__}: {error}"
                if self.routes is not None:
                    # A plan that is there already must not be lost to a later step.
                    self.notes.append(f"backend {planner.name} failed ({text})")
                    return Search()
                if ours:
                    raise
                raise BackendError(f"backend {planner.name} failed: {text}") from error
        if (told := found.info.get("reads")) is not None:
            self._tell_reads(planner.name, told)
        self.work[planner.name] = self.work.get(planner.name, 0) + found.work
        if found.routes is not None:
            self.offer(found.routes)
        if found.infeasible is not None and self.routes is None:
            self.infeasible = found.infeasible
        if objective:
            self.bound = max(self.bound, found.bound)
        else:
            self.raise_bound(found.bound)
        if found.optimal and self.routes is not None and (self.by_distance or objective):
            self.proven = True
            self.bound = max(self.bound, self.cost)
        self.tell()
        return found

    def _tell_reads(self, name: str, told: Mapping[str, Any]) -> None:
        """Report the reads of a planner that samples plans."""
        both = (np.asarray(told[k], dtype=np.float64) for k in ("lengths", "random_lengths"))
        # Those that take a forbidden way are not plans.
        (lengths, feasible), (random, random_feasible) = (
            (all_[np.isfinite(all_)], float(np.isfinite(all_).mean())) for all_ in both
        )
        self.reads = (lengths, random)
        self.sampler = SamplerReport(
            backend=name,
            encoding=told["encoding"],
            variables=told["variables"],
            reads=len(told["lengths"]),
            feasible_fraction=feasible,
            best=float(lengths.min()) if lengths.size else None,
            mean=float(lengths.mean()) if lengths.size else None,
            energy=told["energy"],
            random_feasible_fraction=random_feasible,
            random_best=float(random.min()) if random.size else None,
            of_plans=True,
            details=dict(told["details"]),
        )

    @property
    def finished(self) -> bool:
        """Whether nothing is left to gain: proven optimal, by search or by bound."""
        if self.infeasible is not None:
            return True
        if self.routes is not None and self.cost <= self.bound * (1 + TIE):
            self.proven = True
        return self.proven


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
