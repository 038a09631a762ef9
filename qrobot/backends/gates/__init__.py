"""Gate-model machinery that needs no SDK: exact QAOA states, angles, circuits, tables' rows."""

from qrobot.backends.gates.circuits import one_hot_program, subspace_program
from qrobot.backends.gates.circuits_braket import to_braket
from qrobot.backends.gates.circuits_qiskit import to_qiskit
from qrobot.backends.gates.counting import Spectrum, spectrum
from qrobot.backends.gates.feasible import FeasibleSet, feasible_set
from qrobot.backends.gates.form import Form, bits_of, diagonal
from qrobot.backends.gates.program import Gate, Program
from qrobot.backends.gates.row import GateRow, paper_qubits
from qrobot.backends.gates.rows import grover_row, one_hot_row, penalty_row, subspace_row
from qrobot.backends.gates.simulator import DiagonalQAOA
from qrobot.backends.gates.subspace import SubspaceQAOA, expected_best, one_hot
from qrobot.backends.gates.tune import Tuning, ramp, sharpen, tune

__all__ = [
    "DiagonalQAOA",
    "FeasibleSet",
    "Form",
    "Gate",
    "GateRow",
    "Program",
    "Spectrum",
    "SubspaceQAOA",
    "Tuning",
    "bits_of",
    "diagonal",
    "expected_best",
    "feasible_set",
    "grover_row",
    "one_hot",
    "one_hot_program",
    "one_hot_row",
    "paper_qubits",
    "penalty_row",
    "ramp",
    "sharpen",
    "spectrum",
    "subspace_program",
    "subspace_row",
    "to_braket",
    "to_qiskit",
    "tune",
]
