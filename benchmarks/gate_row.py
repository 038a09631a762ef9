"""Rows of the paper's tables by gate-model methods, each beside its random control.

Nothing is repaired or polished, and no search is told where the optimum is: angles are tuned on
the mean cost or on the mean of the best share, then the exact state says how probable the
optimum is.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from qrobot.backends.gate.counting import spectrum
from qrobot.backends.gate.feasible import FeasibleSet, feasible_set
from qrobot.backends.gate.form import Form
from qrobot.backends.gate.state.diagonal import DiagonalQAOA
from qrobot.backends.gate.state.subspace import SubspaceQAOA, expected_best, one_hot
from qrobot.backends.gate.tune import SHARPER, Tuning, sharpen
from qrobot.errors import InputError
from qrobot.models import PickingModel
from qrobot.problem import Instance

__all__ = ["GateRow", "grover_row", "one_hot_row", "paper_qubits", "penalty_row", "subspace_row"]

Units = tuple[Sequence[float], Sequence[float]]


@dataclass(frozen=True, slots=True)
class GateRow:
    """What a gate-model method says about an instance by itself.

    Parameters
    ----------
    method
        ``penalty``, ``swap``, ``swap-all``, ``grover`` (enumerated or counted) or ``one-hot``.
    items, robots, capacity
        n, K and the largest capacity M in units of weight.
    qubits
        Qubits of the paper's penalty form: K n (n + 1) + K ceil(log2 M).
    states
        States that were simulated, or that amplitudes were counted for.
    layers, evaluations, seconds
        p, runs of the circuit in the search, and seconds for everything: building, searching
        and the final state.
    distance
        Of the optimum.
    probability, uniform
        Of reading an optimal plan in one shot, and the control: the same for a uniformly random
        state (of all bit strings for the penalty form, of all feasible plans otherwise).
    feasible, feasible_uniform
        Probability that one shot is a feasible plan, and the same for the control.
    mean
        Mean distance of the feasible shots.
    shots
        Shots that the next fields speak of.
    seen, seen_uniform
        Probability that an optimal plan is among the shots, and the same for the control.
    best, best_uniform
        Expected best distance of the shots and of the control's; ``None`` where shots may all
        be infeasible.
    gammas, betas
        Angles; gammas in units of one over the spread of the cost, so that they carry over to
        other instances.
    """

    method: str
    items: int
    robots: int
    capacity: int
    qubits: int
    states: int
    layers: int
    evaluations: int
    seconds: float
    distance: float
    probability: float
    uniform: float
    feasible: float
    feasible_uniform: float
    mean: float
    shots: int
    seen: float
    seen_uniform: float
    best: float | None
    best_uniform: float | None
    gammas: tuple[float, ...]
    betas: tuple[float, ...]

    @property
    def gain(self) -> float:
        """How many times more probable the optimum is than in the control."""
        return self.probability / self.uniform

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, the gain included."""
        return {**asdict(self), "gain": self.gain}


def paper_qubits(instance: Instance) -> int:
    """Return K n (n + 1) + the sum over robots of ceil(log2 M): the paper's tables 2 and 3."""
    n = instance.size
    bits = sum(max(int(room) - 1, 0).bit_length() for room in instance.capacities)
    return len(instance.capacities) * n * (n + 1) + bits


def penalty_row(
    model: PickingModel,
    *,
    layers: int = 1,
    alphas: Sequence[float] = (0.1, 0.01),
    evaluations: int = 12,
    shots: int = 1000,
    precision: str = "double",
    threads: int | None = 1,
    engine: str = "auto",
) -> GateRow:
    """Return the row of penalty-form QAOA on a reduced model.

    An assignment counts as optimal when it is the bit string of an optimal plan: both
    directions of a tour, each with the one value of the slack that makes its load exact, and
    for several robots each way to hand out the trips, waiting at the end.

    Parameters
    ----------
    model
        In the reduced encoding.
    layers, evaluations, alphas
        As in `sharpen`; the first angles come from the closed form of the mean.
    precision, threads, engine
        As in `DiagonalQAOA`.
    shots
        For `seen`.
    """
    if model.encoding != "reduced":
        raise InputError(f"the {model.encoding} encoding has no row", field="encoding")
    began = time.perf_counter()
    form = Form.from_bqm(model.bqm)
    qaoa = DiagonalQAOA(form, precision=precision, threads=threads, engine=engine)
    found = sharpen(qaoa, layers, evaluations=evaluations, alphas=alphas)
    qaoa.run(found.gammas, found.betas)
    seconds = time.perf_counter() - began
    plans = feasible_set(model.instance)
    at = {label: k for k, label in enumerate(form.variables)}

    def index(state: int) -> int:
        return sum(1 << at[label] for label in plans.assignment(state, model.slack))

    indices = np.array([index(k) for k in range(plans.size)], dtype=np.intp)
    p = qaoa.probabilities(indices)
    # A read is feasible whatever its slack bits say: they come last and are summed over.
    places = model.layout.places
    slacks = np.arange(1 << (form.qubits - places), dtype=np.intp) << places
    any_slack = np.array(
        [qaoa.probabilities((i & ((1 << places) - 1)) + slacks).sum() for i in indices]
    )
    total = qaoa.diagonal.size
    return _row(
        "penalty", plans, found, seconds, shots, qaoa.spread,
        states=total,
        probability=float(p[plans.optimal].sum()),
        uniform=len(plans.optimal) / total,
        feasible=float(any_slack.sum()),
        feasible_uniform=plans.size * len(slacks) / total,
        mean=float(any_slack @ plans.costs / any_slack.sum()),
    )  # fmt: skip


def subspace_row(
    instance: Instance,
    mixer: str = "swap",
    *,
    layers: int = 1,
    alphas: Sequence[float] = (1.0, 0.1),
    evaluations: int = 40,
    shots: int = 1000,
    start: Units | None = None,
) -> GateRow:
    """Return the row of a mixer that keeps all constraints, on the enumerated plans.

    Parameters
    ----------
    instance
        The question.
    mixer
        ``swap``, ``swap-all`` or ``grover``.
    layers, evaluations, alphas
        As in `sharpen`.
    shots
        For `seen` and `best`.
    start
        Gammas (in units, `GateRow.gammas`) and betas of a smaller instance.
    """
    began = time.perf_counter()
    plans = feasible_set(instance)
    qaoa = SubspaceQAOA.of(plans, mixer)
    angles = None if start is None else ([g / qaoa.spread for g in start[0]], start[1])
    found = sharpen(qaoa, layers, evaluations=evaluations, alphas=alphas, start=angles)
    p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
    seconds = time.perf_counter() - began
    uniform = np.full(plans.size, 1.0 / plans.size)
    return _row(
        mixer, plans, found, seconds, shots, qaoa.spread,
        states=plans.size,
        probability=float(p[plans.optimal].sum()),
        uniform=len(plans.optimal) / plans.size,
        feasible=1.0,
        feasible_uniform=1.0,
        mean=float(p @ plans.costs),
        best=expected_best(plans.costs, p, shots),
        best_uniform=expected_best(plans.costs, uniform, shots),
    )  # fmt: skip


def one_hot_row(
    instance: Instance,
    *,
    layers: int = 1,
    alphas: Sequence[float] = (1.0, 0.1),
    evaluations: int = 40,
    shots: int = 1000,
    penalty: float | None = None,
) -> GateRow:
    """Return the row of the XY mixer, for one robot that can carry everything.

    Parameters
    ----------
    instance
        The question.
    layers, evaluations, alphas
        As in `sharpen`.
    shots
        For `seen`.
    penalty
        Of an item's visits beside one; the largest distance by default.
    """
    if len(instance.capacities) != 1:
        raise InputError("the one-hot row is for one robot", field="robots", advice="use swap")
    began = time.perf_counter()
    d = instance.distances
    qaoa, tours = one_hot(d, float(d.max()) if penalty is None else penalty)
    found = sharpen(qaoa, layers, evaluations=evaluations, alphas=alphas)
    p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
    seconds = time.perf_counter() - began
    plans, total = feasible_set(instance), len(p)
    least = float(plans.costs.min())
    optimal = tours & (qaoa.costs <= least + 1e-9 * max(least, 1e-300))
    return _row(
        "one-hot", plans, found, seconds, shots, qaoa.spread,
        states=total,
        probability=float(p[optimal].sum()),
        uniform=int(optimal.sum()) / total,
        feasible=float(p[tours].sum()),
        feasible_uniform=plans.size / total,
        mean=float(p[tours] @ qaoa.costs[tours] / p[tours].sum()),
    )  # fmt: skip


def grover_row(
    instance: Instance,
    *,
    layers: int = 1,
    alphas: Sequence[float] = SHARPER,
    evaluations: int = 200,
    shots: int = 1000,
) -> GateRow:
    """Return the row of the Grover mixer by counting: whole distances, up to 15 items.

    Parameters
    ----------
    instance
        The question; its distances must be whole.
    layers, evaluations, alphas
        As in `sharpen`.
    shots
        For `seen` and `best`.
    """
    began = time.perf_counter()
    counted = spectrum(instance)
    qaoa = counted.qaoa()
    found = sharpen(qaoa, layers, evaluations=evaluations, alphas=alphas)
    p = qaoa.probabilities(np.array(found.gammas), np.array(found.betas))
    seconds = time.perf_counter() - began
    uniform = counted.counts / counted.size
    return _measured(
        instance, "grover", found, seconds, shots, qaoa.spread,
        distance=float(counted.levels[0]),
        states=counted.size,
        probability=float(p[0]),
        uniform=counted.optimal / counted.size,
        feasible=1.0,
        feasible_uniform=1.0,
        mean=float(p @ counted.levels),
        best=expected_best(counted.levels, p, shots),
        best_uniform=expected_best(counted.levels, uniform, shots),
    )  # fmt: skip


def _row(method: str, plans: FeasibleSet, *arguments: Any, **values: Any) -> GateRow:
    return _measured(
        plans.instance, method, *arguments, distance=float(plans.costs.min()), **values
    )


def _measured(
    instance: Instance,
    method: str,
    found: Tuning,
    seconds: float,
    shots: int,
    spread: float,
    *,
    probability: float,
    uniform: float,
    best: float | None = None,
    best_uniform: float | None = None,
    **values: Any,
) -> GateRow:
    """Return a row from what a method measured; `values` are the fields that it knows."""
    return GateRow(
        method=method,
        items=instance.size,
        robots=len(instance.capacities),
        capacity=int(instance.capacities.max()),
        qubits=paper_qubits(instance),
        layers=len(found.gammas),
        evaluations=found.evaluations,
        seconds=seconds,
        probability=probability,
        uniform=uniform,
        shots=shots,
        seen=-float(np.expm1(shots * np.log1p(-min(probability, 1.0 - 1e-16)))),
        seen_uniform=-float(np.expm1(shots * np.log1p(-min(uniform, 1.0 - 1e-16)))),
        best=best,
        best_uniform=best_uniform,
        gammas=tuple(g * spread for g in found.gammas),
        betas=found.betas,
        **values,
    )
