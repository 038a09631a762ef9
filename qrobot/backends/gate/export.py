"""A constraint-preserving circuit of an instance, with its angles searched, as a file."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from qrobot._files import write_text_atomic
from qrobot.backends.gate.feasible import feasible_set
from qrobot.backends.gate.preserving_circuits import subspace_circuit
from qrobot.backends.gate.qasm import circuit_facts, qasm
from qrobot.backends.gate.state.subspace import SubspaceQAOA
from qrobot.backends.gate.tune import sharpen
from qrobot.errors import InputError
from qrobot.problem import Instance

__all__ = ["MIXERS", "export_circuit"]

MIXERS = ("swap", "swap-all", "grover")

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
    if mixer not in MIXERS:
        raise InputError(
            f"{mixer!r} is not a mixer", field="mixer", mend=f"use one of {', '.join(MIXERS)}"
        )
    if layers < 1:
        raise InputError(f"{layers} layers are too few", field="layers", mend="use 1 or more")
    plans = feasible_set(instance)
    ansatz = SubspaceQAOA.of(plans, mixer)
    found = sharpen(ansatz, layers, evaluations=EVALUATIONS, alphas=(1.0, 0.1))
    probabilities = ansatz.probabilities(np.array(found.gammas), np.array(found.betas))
    circuit = subspace_circuit(plans, mixer, found.gammas, found.betas)
    facts = circuit_facts(circuit)
    optimal = plans.optimal
    report: dict[str, Any] = {
        "mixer": mixer,
        "layers": layers,
        "qubits": facts.qubits,
        "gates": facts.gates,
        "two_qubit_gates": facts.two_qubit_gates,
        "depth": facts.depth,
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
