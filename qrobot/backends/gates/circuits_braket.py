"""Programs as Amazon Braket circuits."""

from __future__ import annotations

from typing import Any

from qrobot.backends.gates.lower import lowered
from qrobot.backends.gates.program import Program
from qrobot.errors import MissingExtraError

__all__ = ["to_braket"]

CONTROLLED = {
    ("x", 1): "cnot",
    ("x", 2): "ccnot",
    ("swap", 1): "cswap",
    ("phase", 1): "cphaseshift",
}


def to_braket(program: Program) -> Any:
    """Return a `braket.circuits.Circuit`; qubit k of the program is qubit k of the circuit.

    Braket writes qubit 0 first: it is the highest bit of a state's index and the first
    character of a bit string. No control modifiers are used: managed devices refuse them.

    Raises
    ------
    MissingExtraError
        When the Braket SDK is not installed.
    """
    try:
        from braket.circuits import Circuit
    except ImportError:
        raise MissingExtraError("a Braket circuit", "braket") from None
    circuit = Circuit()
    for qubit in range(program.qubits):
        circuit.i(qubit)  # so that every qubit is there, used or not
    plain = {"phase": "phaseshift"}
    for gate in lowered(program).gates:
        name = plain.get(gate.name, gate.name)
        if gate.controls:
            name = CONTROLLED[gate.name, len(gate.controls)]
        angle = [gate.angle] if gate.name in ("rx", "ry", "rz", "phase") else []
        getattr(circuit, name)(*gate.controls, *gate.targets, *angle)
    return circuit
