"""The gate model without an SDK: circuits, ansätze, exact states, objectives, angle searches.

`state` holds the simulators: diagonal QAOA, the subspace of the plans, and any circuit. The
samplers in the folders of the vendors build on `VariationalSampler`.
"""

from qrobot.backends.gate.ansatz import Ansatz, make_ansatz, ramp
from qrobot.backends.gate.circuit import Circuit, CircuitFacts, Gate, circuit_facts, qasm
from qrobot.backends.gate.constrained import subspace_circuit
from qrobot.backends.gate.counting import Spectrum, spectrum
from qrobot.backends.gate.engine import Engine, JobEngine, RemoteEngine, StateEngine
from qrobot.backends.gate.feasible import FeasibleSet, feasible_set
from qrobot.backends.gate.form import Form, Term, bits_of, diagonal, terms
from qrobot.backends.gate.sampler import VariationalSampler
from qrobot.backends.gate.search import Options
from qrobot.backends.gate.state.diagonal import DiagonalQAOA
from qrobot.backends.gate.state.subspace import SubspaceQAOA, expected_best, one_hot
from qrobot.backends.gate.tune import Tuning, sharpen, tune

__all__ = [
    "Ansatz",
    "Circuit",
    "CircuitFacts",
    "DiagonalQAOA",
    "Engine",
    "FeasibleSet",
    "Form",
    "Gate",
    "JobEngine",
    "Options",
    "RemoteEngine",
    "Spectrum",
    "StateEngine",
    "SubspaceQAOA",
    "Term",
    "Tuning",
    "VariationalSampler",
    "bits_of",
    "circuit_facts",
    "diagonal",
    "expected_best",
    "feasible_set",
    "make_ansatz",
    "one_hot",
    "qasm",
    "ramp",
    "sharpen",
    "spectrum",
    "subspace_circuit",
    "terms",
    "tune",
]
