"""QAOA whose mixer never leaves the plans: backends ``qaoa-swap`` and ``qaoa-grover``.

Instance in, routes out: the state lives on the plans themselves and is simulated exactly, so
every read is a plan. What is said of the reads is raw; the best of them is the answer.

The same as circuits: start states, phases and mixers. For one robot everything is polynomial in n:
the uniform superposition of all tours takes n (n - 1) controlled swaps a row, an exchange of two
steps n controlled swaps and one ancilla. For several robots, capacity couples everything; there the
circuits rotate between the bit strings of the enumerated plans one by one, which is exact and fit
for tiny cases only.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot._files import write_text_atomic
from qrobot.backends.base import Capabilities, OnBest, PlanReads, Routes, Search, Stop
from qrobot.backends.gate.circuit import Circuit, Gate, circuit_facts, qasm
from qrobot.backends.gate.feasible import FeasibleSet, feasible_set, slack_label, x_label
from qrobot.backends.gate.resources import few_threads
from qrobot.backends.gate.state.subspace import SubspaceQAOA, check_mixer, transpositions
from qrobot.backends.gate.tune import Tuning, sharpen
from qrobot.errors import InfeasibleError, InputError
from qrobot.models.slack import Slack, slack_coefficients
from qrobot.problem.instance import Instance

__all__ = ["GroverPlanner", "SwapPlanner", "export_circuit", "subspace_circuit", "two_level"]


READS = 1000
LAYERS = 2
EVALUATIONS = 60
"""Runs of the circuit for each share of the distribution, when no limit of work is given."""

SHARES = (1.0, 0.1)


def _tuned(
    plans: FeasibleSet,
    mixer: str,
    layers: int,
    evaluations: int,
    stop: Callable[[], bool] | None = None,
) -> tuple[Tuning, Floats]:
    """Return good angles, and the probability of each plan with them."""
    qaoa = SubspaceQAOA.of(plans, mixer)
    with few_threads(int(plans.size).bit_length()):
        found = sharpen(qaoa, layers, evaluations=evaluations, alphas=SHARES, stop=stop)
        return found, qaoa.probabilities(np.array(found.gammas), np.array(found.betas))


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
        try:
            plans = feasible_set(instance)
        except InfeasibleError as error:
            return Search(infeasible=error.reason)
        if not np.isfinite(plans.lengths(np.arange(plans.size))).any():
            from qrobot.backends.classical.exact.packing import no_way

            return Search(infeasible=no_way(instance))
        limit = EVALUATIONS if stop.max_work is None else max(1, stop.max_work // len(SHARES))
        most = min(limit, EVALUATIONS)
        found, p = _tuned(plans, self.mixer, LAYERS, most, stop)
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


def subspace_circuit(
    feasible: FeasibleSet,
    mixer: str,
    gammas: Sequence[float],
    betas: Sequence[float],
    *,
    slack: Slack | None = None,
) -> Circuit:
    """Return the circuit of `SubspaceQAOA.of(feasible, mixer)`.

    Parameters
    ----------
    feasible
        The plans; for several robots each costs gates of its own.
    mixer
        ``swap``, ``swap-all`` or ``grover``.
    gammas, betas
        One of each a layer.
    slack
        Kind of the model's slack; ``None`` leaves the slack qubits out.
    """
    check_mixer(mixer)
    instance = feasible.instance
    n, robots = instance.size, len(feasible.capacities)
    labels = [
        x_label(t, i, p) for p in range(robots) for t in range(1, n + 1) for i in range(n + 1)
    ]
    if slack is not None:
        for p, room in enumerate(feasible.capacities.tolist()):
            labels += [slack_label(k, p) for k in range(len(slack_coefficients(room, slack)))]
    ancilla = len(labels)
    alone = robots == 1
    if alone and mixer != "grover":
        labels.append("ancilla")
    at = {label: k for k, label in enumerate(labels)}
    if alone:
        start = _tour_start(at, n)
        constant = feasible.assignment(0, slack) - feasible.assignment(0)
        start += [Gate("x", (at[label],)) for label in sorted(constant)]
    else:
        strings = _strings(feasible, at, slack)
        start = _explicit_start(strings)
    gates = list(start)
    pairs = transpositions(
        feasible.sequences.shape[1], "all" if mixer == "swap-all" else "adjacent"
    )
    for gamma, beta in zip(gammas, betas, strict=True):
        gates += _distance_phase(instance.distances, at, n, robots, gamma)
        if mixer == "grover":
            gates += _grover(start, ancilla, beta)
        elif alone:
            for a, b in pairs:
                gates += _exchange_steps(at, n, a + 1, b + 1, ancilla, beta)
        else:
            for a, b in pairs:
                gates += _exchange_plans(strings, feasible.swapped(a, b), beta)
    return Circuit(len(labels), tuple(gates), labels=tuple(labels))


def _w_state(row: Sequence[int]) -> list[Gate]:
    """Return gates that spread one excitation evenly over the qubits of a row."""
    gates = [Gate("x", (row[0],))]
    for k, (here, there) in enumerate(pairwise(row)):
        keep = 1 / math.sqrt(len(row) - k)
        gates += [
            Gate("ry", (there,), angle=2 * math.acos(keep), controls=(here,)),
            Gate("x", (here,), controls=(there,)),
        ]
    return gates


def _tour_start(at: dict[str, int], n: int) -> list[Gate]:
    """Return gates for the uniform superposition of all n! tours.

    Item k = 1, 2, .. goes to one of the steps 1..k (a W state of its column); the item that
    held that step moves to step k, by swaps controlled on the column.
    """
    gates: list[Gate] = []
    for k in range(1, n + 1):
        # The W state begins at step k, where the item stands if nothing moves.
        gates += _w_state([at[x_label(t, k)] for t in range(k, 0, -1)])
        for t in range(1, k):
            for i in range(1, k):
                swapped = (at[x_label(t, i)], at[x_label(k, i)])
                gates.append(Gate("swap", swapped, controls=(at[x_label(t, k)],)))
    return gates


def _strings(
    feasible: FeasibleSet, at: dict[str, int], slack: Slack | None
) -> list[dict[int, int]]:
    found = []
    for index in range(feasible.size):
        ones = feasible.assignment(index, slack)
        found.append({k: int(label in ones) for label, k in at.items()})
    return found


def _explicit_start(strings: Sequence[dict[int, int]]) -> list[Gate]:
    """Return gates for the uniform superposition of bit strings, one rotation each."""
    first, count = strings[0], len(strings)
    gates = [Gate("x", (q,)) for q, value in first.items() if value]
    for k, other in enumerate(strings[1:]):
        angle = 2 * math.asin(1 / math.sqrt(count - k))
        gates += two_level(first, other, "ry", angle)
    return gates


def _distance_phase(d: Floats, at: dict[str, int], n: int, robots: int, gamma: float) -> list[Gate]:
    """Return exp(-i gamma distance) on the variables that are there."""
    gates: list[Gate] = []

    def turn(length: float, *labels: str) -> None:
        if length and all(label in at for label in labels):
            last, *controls = (at[label] for label in labels)
            gates.append(Gate("phase", (last,), angle=-gamma * length, controls=tuple(controls)))

    for p in range(robots):
        for i in range(n + 1):
            turn(d[0, i], x_label(1, i, p))
            turn(d[i, 0], x_label(n, i, p))
            for t in range(1, n):
                for j in range(n + 1):
                    turn(d[i, j], x_label(t, i, p), x_label(t + 1, j, p))
    return gates


def _grover(start: Sequence[Gate], qubits: int, beta: float) -> list[Gate]:
    """Return exp(-i beta |s><s|): undo the start, turn |0..0>, start again."""
    back = [gate.inverse() for gate in reversed(start)]
    return [*back, *_basis_phase(dict.fromkeys(range(qubits), 0), -beta), *start]


def _basis_phase(state: Mapping[int, int], angle: float) -> list[Gate]:
    """Return a phase on one basis state alone."""
    others = tuple(q for q in state if q != 0)
    values = tuple(state[q] for q in others)
    flip = [] if state[0] else [Gate("x", (0,))]
    return [*flip, Gate("phase", (0,), angle=angle, controls=others, values=values), *flip]


def _exchange_steps(
    at: dict[str, int], n: int, a: int, b: int, ancilla: int, beta: float
) -> list[Gate]:
    """Return exp(-i beta S), S exchanging two steps: the ancilla reads S, turns, and is freed."""
    swaps = [
        Gate("swap", (at[x_label(a, i)], at[x_label(b, i)]), controls=(ancilla,))
        for i in range(1, n + 1)
    ]
    h = Gate("h", (ancilla,))
    read = [h, *swaps, h]
    return [*read, Gate("rz", (ancilla,), angle=2 * beta), *read]


def _exchange_plans(
    strings: Sequence[dict[int, int]], partner: npt.NDArray[np.intp], beta: float
) -> list[Gate]:
    """Return exp(-i beta S), S exchanging plans with their partners, one rotation each."""
    gates: list[Gate] = []
    for k, other in enumerate(partner.tolist()):
        if k < other:
            gates += two_level(strings[k], strings[other], "rx", 2 * beta)
        elif k == other:
            gates += _basis_phase(strings[k], -beta)
    return gates


def two_level(a: Mapping[int, int], b: Mapping[int, int], name: str, angle: float) -> list[Gate]:
    """Return gates that rotate between two basis states and leave all others alone.

    Parameters
    ----------
    a, b
        Value of each qubit; they differ somewhere. The rotation sees `a` as |0>, `b` as |1>.
    name, angle
        The rotation: ``rx`` or ``ry``.
    """
    differ = [q for q in a if a[q] != b[q]]
    pivot, rest = differ[0], differ[1:]
    # Where the pivot is as in b, flip the rest: b then differs from a in the pivot alone.
    flips = [Gate("x", (q,), controls=(pivot,), values=(b[pivot],)) for q in rest]
    others = tuple(q for q in a if q != pivot)
    if name == "ry" and a[pivot] == 1:
        angle = -angle
    values = tuple(a[q] for q in others)
    turn = Gate(name, (pivot,), angle=angle, controls=others, values=values)
    return [*flips, turn, *reversed(flips)]


CIRCUIT_EVALUATIONS = 200
"""Of the search for angles; each is one exact state among the plans."""


def export_circuit(
    instance: Instance, path: str | os.PathLike[str], mixer: str = "swap", layers: int = 1
) -> dict[str, Any]:
    """Write the circuit that `qaoa-swap` or `qaoa-grover` simulates as OpenQASM 3.

    Measuring it gives plans only: qubit k is the variable that the file's comments name, of the
    `reduced` encoding without slack.

    Parameters
    ----------
    instance
        The question; all its plans are listed to search the angles, so it must be small.
    path
        File to write.
    mixer
        One of `MIXERS`.
    layers
        Layers of phase and mixer.

    Returns
    -------
    dict
        What was written, plain data: qubits, gates of one and two qubits, depth, angles, and the
        probability of measuring an optimal plan, beside that of a uniformly random plan.

    Raises
    ------
    InputError
        When the mixer or the number of layers is of no use.
    BackendError
        When there are too many plans.
    """
    check_mixer(mixer)
    if layers < 1:
        raise InputError(f"{layers} layers are too few", field="layers", advice="use 1 or more")
    plans = feasible_set(instance)
    found, probabilities = _tuned(plans, mixer, layers, CIRCUIT_EVALUATIONS)
    circuit = subspace_circuit(plans, mixer, found.gammas, found.betas)
    optimal = plans.optimal
    report: dict[str, Any] = {
        "mixer": mixer,
        "layers": layers,
        **asdict(circuit_facts(circuit)),
        "gammas": [float(gamma) for gamma in found.gammas],
        "betas": [float(beta) for beta in found.betas],
        "plans": plans.size,
        "optimum_probability": float(probabilities[optimal].sum()),
        "random_plan_probability": optimal.size / plans.size,
    }
    comment = (
        f"{instance.name or 'an instance'}: {plans.size} plans, mixer {mixer}, {layers} layer(s); "
        f"an optimal plan is measured with probability {report['optimum_probability']:.3g}.\n"
        "x[t,i,p]: robot p is at item i (0: the depot) at step t."
    )
    write_text_atomic(path, qasm(circuit, comment))
    return report
