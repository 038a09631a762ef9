"""Qiskit Finance: a portfolio as an Ising model, and a normal distribution in amplitudes."""

import numpy as np

from qrobot.health import known
from qrobot.health.check import Check

RETURNS = (0.12, 0.07, 0.21)
COVARIANCES = ((0.05, 0.01, -0.02), (0.01, 0.04, 0.03), (-0.02, 0.03, 0.09))
RISK, BUDGET, PENALTY = 0.5, 2, 10.0
MEAN, VARIANCE, BOUNDS, QUBITS = 1.1, 0.6, (0.0, 2.0), 3


def answer() -> list[float]:
    """Return the energies of all portfolios, and the probabilities of the distribution."""
    from qiskit.quantum_info import Statevector
    from qiskit_finance.applications.optimization import PortfolioOptimization
    from qiskit_finance.circuit.library import NormalDistribution
    from qiskit_optimization.converters import QuadraticProgramToQubo

    program = PortfolioOptimization(
        np.array(RETURNS), np.array(COVARIANCES), RISK, BUDGET
    ).to_quadratic_program()
    ising, offset = QuadraticProgramToQubo(penalty=PENALTY).convert(program).to_ising()
    energies = ising.to_matrix().diagonal().real + offset
    normal = NormalDistribution(QUBITS, mu=MEAN, sigma=VARIANCE, bounds=BOUNDS)
    return [*energies.tolist(), *Statevector(normal).probabilities().tolist()]


def expected() -> list[float]:
    """Return risk less returns plus the square of the budget's miss; the bell, normalized."""
    chosen = (1 - known.all_spins(len(RETURNS))) // 2
    risk = np.einsum("si,ij,sj->s", chosen, np.array(COVARIANCES), chosen)
    energies = RISK * risk - chosen @ np.array(RETURNS)
    energies = energies + PENALTY * (chosen.sum(axis=1) - BUDGET) ** 2
    bell = np.exp(-((np.linspace(*BOUNDS, 2**QUBITS) - MEAN) ** 2) / (2 * VARIANCE))
    return [*energies.tolist(), *(bell / bell.sum()).tolist()]


CHECK = Check(
    __name__,
    title="a portfolio and a normal distribution",
    group="gate model",
    imports=("qiskit_finance.applications.optimization", "qiskit_finance.circuit.library"),
    distributions=("qiskit-finance", "qiskit-optimization", "qiskit"),
    source="all portfolios and the closed form of the bell, in numpy",
    extra="science",
)
