"""Circuits as OpenQASM 3, and what they cost a machine.

The language: A. Cross et al., "OpenQASM 3", ACM Transactions on Quantum Computing 3 (2022) 12. Only
gates of its standard library are written, of one and two qubits.
"""

from __future__ import annotations

from dataclasses import dataclass

from qrobot.backends.gate.circuit import TURNING, Circuit, Gate
from qrobot.backends.gate.lower import elementary

__all__ = ["CircuitFacts", "circuit_facts", "qasm"]

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
