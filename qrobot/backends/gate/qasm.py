"""Circuits as OpenQASM 3: what they cost a machine, and the one of an instance as a file.

The language: A. Cross et al., "OpenQASM 3", ACM Transactions on Quantum Computing 3 (2022) 12. Only
gates of its standard library are written, of one and two qubits.
"""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from qrobot._files import write_text_atomic
from qrobot.backends.gate.circuit import TURNING, Circuit, Gate, elementary
from qrobot.backends.gate.constrained_circuits import subspace_circuit
from qrobot.backends.gate.feasible import feasible_set
from qrobot.backends.gate.state.subspace import SubspaceQAOA, check_mixer
from qrobot.backends.gate.tune import sharpen
from qrobot.errors import InputError
from qrobot.problem import Instance

__all__ = ["CircuitFacts", "circuit_facts", "export_circuit", "qasm"]


NAMES = {"phase": "p"}
CONTROLLED = {"x": "cx", "phase": "cp"}


@dataclass(frozen=True, slots=True)
class CircuitFacts:
    """What a circuit costs in gates of one and two qubits, before any routing.

    Parameters
    ----------
    qubits
        Number of qubits.
    gates, two_qubit_gates
        How many gates, and how many of them act on two qubits.
    depth
        Layers of gates, each as early as its qubits are free.
    """

    qubits: int
    gates: int
    two_qubit_gates: int
    depth: int


def circuit_facts(circuit: Circuit) -> CircuitFacts:
    """Return what a circuit costs in gates of one and two qubits."""
    free = [0] * circuit.qubits
    gates = elementary(circuit).gates
    for gate in gates:
        touched = (*gate.controls, *gate.qubits)
        layer = 1 + max(free[q] for q in touched)
        for q in touched:
            free[q] = layer
    pairs = sum(len(gate.controls) + len(gate.qubits) == 2 for gate in gates)
    return CircuitFacts(circuit.qubits, len(gates), pairs, max(free, default=0))


def qasm(circuit: Circuit, comment: str = "") -> str:
    """Return a circuit without open parameters as an OpenQASM 3 program that measures every qubit.

    Parameters
    ----------
    circuit
        Its rotations have fixed angles.
    comment
        Lines that stand on top.

    Raises
    ------
    ValueError
        When an angle is still to be searched.
    """
    if circuit.rotations:
        raise ValueError("a circuit with open parameters cannot be written: fix its angles first")
    lines = [f"// {line}" for line in comment.splitlines()]
    lines += ["OPENQASM 3.0;", 'include "stdgates.inc";', ""]
    lines += [f"// q[{k}]: {label}" for k, label in enumerate(circuit.labels)]
    lines += [f"qubit[{circuit.qubits}] q;", f"bit[{circuit.qubits}] c;"]
    lines += [line for gate in elementary(circuit).gates for line in _statements(gate)]
    return "\n".join([*lines, "c = measure q;"]) + "\n"


def _statements(gate: Gate) -> list[str]:
    name = CONTROLLED[gate.name] if gate.controls else NAMES.get(gate.name, gate.name)
    qubits = [f"q[{q}]" for q in (*gate.controls, *gate.qubits)]
    if name == "rzz":  # not in the standard library
        flip = f"cx {qubits[0]}, {qubits[1]};"
        return [flip, f"rz({gate.angle!r}) {qubits[1]};", flip]
    angle = f"({float(gate.angle)!r})" if gate.name in TURNING else ""
    return [f"{name}{angle} {', '.join(qubits)};"]


EVALUATIONS = 200
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
    ansatz = SubspaceQAOA.of(plans, mixer)
    found = sharpen(ansatz, layers, evaluations=EVALUATIONS, alphas=(1.0, 0.1))
    probabilities = ansatz.probabilities(np.array(found.gammas), np.array(found.betas))
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
