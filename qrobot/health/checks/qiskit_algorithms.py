"""Qiskit Algorithms: the ground state of two coupled spins, exactly and by VQE."""

import math

from qrobot.health.check import Check

FIELD = 0.6


def answer() -> list[float]:
    """Return the lowest eigenvalue of ``-ZZ - g (X1 + X2)`` by matrix and by VQE."""
    from qiskit.circuit.library import n_local
    from qiskit.primitives import StatevectorEstimator
    from qiskit.quantum_info import SparsePauliOp
    from qiskit_algorithms import VQE, NumPyMinimumEigensolver
    from qiskit_algorithms.optimizers import SLSQP

    energy = SparsePauliOp(["ZZ", "XI", "IX"], [-1.0, -FIELD, -FIELD])
    exact = NumPyMinimumEigensolver().compute_minimum_eigenvalue(energy)
    ansatz = n_local(2, "ry", "cx", reps=1)
    vqe = VQE(StatevectorEstimator(), ansatz, SLSQP(), initial_point=[0.5, 0.6, 0.7, 0.8])
    found = vqe.compute_minimum_eigenvalue(energy)
    return [float(exact.eigenvalue.real), float(found.eigenvalue.real)]


def expected() -> list[float]:
    """Return the closed form: in the even sector the matrix is ``[[-1, -2g], [-2g, 1]]``."""
    return [-math.sqrt(1 + 4 * FIELD**2)] * 2


CHECK = Check(
    __name__,
    title="a ground state, exact and by VQE",
    group="gate model",
    imports=("qiskit_algorithms", "qiskit_algorithms.optimizers"),
    distributions=("qiskit-algorithms", "qiskit"),
    source="closed form of the two-site transverse-field Ising model",
    tolerance=1e-5,
    extra="qiskit",
)
