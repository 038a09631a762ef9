"""Programs as Qiskit circuits."""

from __future__ import annotations

from typing import Any

from qrobot.backends.gates.program import Program
from qrobot.errors import MissingExtraError

__all__ = ["to_qiskit"]


def to_qiskit(program: Program, *, measure: bool = False) -> Any:
    """Return a `qiskit.QuantumCircuit`; qubit k of the program is qubit k of the circuit.

    Parameters
    ----------
    program
        What to translate.
    measure
        Whether to measure every qubit at the end.

    Raises
    ------
    MissingExtraError
        When Qiskit is not installed.
    """
    try:
        from qiskit import QuantumCircuit
        from qiskit.circuit import library
    except ImportError:
        raise MissingExtraError("a Qiskit circuit", "qiskit") from None
    classes = {
        "x": library.XGate,
        "h": library.HGate,
        "swap": library.SwapGate,
        "rx": library.RXGate,
        "ry": library.RYGate,
        "rz": library.RZGate,
        "phase": library.PhaseGate,
    }
    circuit = QuantumCircuit(program.qubits)
    for gate in program.gates:
        turned = gate.name in ("rx", "ry", "rz", "phase")
        made = classes[gate.name](*([gate.angle] if turned else []))
        if gate.controls:
            # Qiskit reads the control state with the first control as its lowest bit.
            state = sum(value << k for k, value in enumerate(gate.control_values))
            made = made.control(len(gate.controls), ctrl_state=state, annotated=False)
        circuit.append(made, [*gate.controls, *gate.targets])
    if measure:
        circuit.measure_all()
    return circuit
