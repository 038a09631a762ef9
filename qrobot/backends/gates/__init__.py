"""Gate-model machinery that needs no SDK: exact QAOA states, angles, circuits, tables' rows."""

from qrobot.backends.gates.circuit import Circuit, Gate
from qrobot.backends.gates.counting import Spectrum, spectrum
from qrobot.backends.gates.feasible import FeasibleSet, feasible_set
from qrobot.backends.gates.form import Form, bits_of, diagonal
from qrobot.backends.gates.preserving_circuits import one_hot_circuit, subspace_circuit
from qrobot.backends.gates.qasm import CircuitFacts, circuit_facts, qasm
from qrobot.backends.gates.row import GateRow, paper_qubits
from qrobot.backends.gates.rows import grover_row, one_hot_row, penalty_row, subspace_row
from qrobot.backends.gates.simulator import DiagonalQAOA
from qrobot.backends.gates.subspace import SubspaceQAOA, expected_best, one_hot
from qrobot.backends.gates.tune import Tuning, ramp, sharpen, tune

__all__ = [
    "Circuit",
    "CircuitFacts",
    "DiagonalQAOA",
    "FeasibleSet",
    "Form",
    "Gate",
    "GateRow",
    "Spectrum",
    "SubspaceQAOA",
    "Tuning",
    "bits_of",
    "circuit_facts",
    "diagonal",
    "expected_best",
    "feasible_set",
    "grover_row",
    "one_hot",
    "one_hot_circuit",
    "one_hot_row",
    "paper_qubits",
    "penalty_row",
    "qasm",
    "ramp",
    "sharpen",
    "spectrum",
    "subspace_circuit",
    "subspace_row",
    "tune",
]
