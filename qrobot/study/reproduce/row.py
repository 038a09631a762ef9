"""What a gate-model method says about an instance by itself, beside its random control."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from qrobot.backends.gate.tune import Tuning
from qrobot.problem import Instance

__all__ = ["GateRow", "make_row", "paper_qubits"]


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


def make_row(
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
