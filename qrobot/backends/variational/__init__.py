"""What the gate samplers on Qiskit, PennyLane and Braket share; it needs none of them."""

from qrobot.backends.gates.circuit import Circuit, Gate
from qrobot.backends.variational.ansatz import Ansatz, make_ansatz
from qrobot.backends.variational.engine import Engine, StateEngine
from qrobot.backends.variational.ising import Term, terms
from qrobot.backends.variational.options import Options
from qrobot.backends.variational.remote import JobEngine, RemoteEngine
from qrobot.backends.variational.sampler import VariationalSampler

__all__ = [
    "Ansatz",
    "Circuit",
    "Engine",
    "Gate",
    "JobEngine",
    "Options",
    "RemoteEngine",
    "StateEngine",
    "Term",
    "VariationalSampler",
    "make_ansatz",
    "terms",
]
