"""QAOA whose mixer never leaves the plans: backends ``qaoa-swap`` and ``qaoa-grover``.

Instance in, routes out: the state lives on the plans themselves and is simulated exactly, so
every read is a plan. What is said of the reads is raw; the best of them is the answer.
"""

from __future__ import annotations

import numpy as np

from qrobot.backends.base import Capabilities, OnBest, PlanReads, Routes, Search, Stop
from qrobot.errors import InfeasibleError
from qrobot.problem.instance import Instance

__all__ = ["GroverPlanner", "SwapPlanner"]


READS = 1000
LAYERS = 2
EVALUATIONS = 60
"""Runs of the circuit for each share of the distribution, when no limit of work is given."""

SHARES = (1.0, 0.1)


class _ConstrainedPlanner:
    """Tunes the angles, then reads the final state.

    A unit of work is one run of the circuit in the search. Up to 20 million sequences (ten
    items for one robot); more are refused before anything is allocated.
    """

    mixer: str
    name: str
    capabilities = Capabilities(kind="planner", control=True)

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,  # noqa: ARG002 - the state begins as all plans alike
        on_best: OnBest | None = None,
    ) -> Search:
        if not instance.size:
            return Search(routes=[], optimal=True)
        from qrobot.backends.classical.exact.packing import no_way
        from qrobot.backends.gate.feasible import feasible_set
        from qrobot.backends.gate.resources import few_threads
        from qrobot.backends.gate.state.subspace import SubspaceQAOA
        from qrobot.backends.gate.tune import sharpen

        try:
            plans = feasible_set(instance)
        except InfeasibleError as error:
            return Search(infeasible=error.reason)
        if not np.isfinite(plans.lengths(np.arange(plans.size))).any():
            return Search(infeasible=no_way(instance))
        qaoa = SubspaceQAOA.of(plans, self.mixer)
        limit = EVALUATIONS if stop.max_work is None else max(1, stop.max_work // len(SHARES))
        most = min(limit, EVALUATIONS)
        with few_threads(int(plans.size).bit_length()):
            found = sharpen(qaoa, LAYERS, evaluations=most, alphas=SHARES, stop=stop)
            p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
        rng = np.random.default_rng(seed)
        reads = rng.choice(plans.size, READS, p=p / p.sum())
        lengths = plans.lengths(reads)
        routes = [route for route in plans.routes(int(reads[lengths.argmin()])) if route]
        if on_best is not None:
            on_best(routes, float(lengths.min()))
        optimal = plans.optimal
        told = PlanReads(
            encoding=f"{plans.size} plans",
            # One-hot over robots, steps and nodes, as `subspace_program` has them.
            variables=plans.capacities.size * instance.size * (instance.size + 1),
            lengths=lengths,
            random_lengths=plans.lengths(rng.integers(0, plans.size, READS)),
            energy=float(plans.costs[reads].min()),
            details={
                "mixer": self.mixer,
                "layers": LAYERS,
                "evaluations": found.evaluations,
                "gammas": list(found.gammas),
                "betas": list(found.betas),
                "states": plans.size,
                "ground_probability": float(p[optimal].sum()),
                "ground_probability_uniform": optimal.size / plans.size,
            },
        )
        return Search(routes=routes, work=found.evaluations, reads=told)


class SwapPlanner(_ConstrainedPlanner):
    """Exchanges of neighbouring positions mix."""

    name, mixer = "qaoa-swap", "swap"


class GroverPlanner(_ConstrainedPlanner):
    """A phase on the mean of all plans mixes."""

    name, mixer = "qaoa-grover", "grover"
