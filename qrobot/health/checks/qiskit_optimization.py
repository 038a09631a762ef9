"""Qiskit Optimization: a knapsack to a QUBO, and its ground state back to a packing."""

import itertools

from qrobot.health import known
from qrobot.health.check import Check

WORTH, WEIGHT, ROOM = (4, 3, 6), (2, 1, 3), 4


def answer() -> list[float]:
    """Return the worth of the packing found, and its weight's excess."""
    from qiskit_optimization import QuadraticProgram
    from qiskit_optimization.algorithms import MinimumEigenOptimizer
    from qiskit_optimization.minimum_eigensolvers import NumPyMinimumEigensolver

    program = QuadraticProgram()
    for k in range(len(WORTH)):
        program.binary_var(f"x{k}")
    program.maximize(linear={f"x{k}": value for k, value in enumerate(WORTH)})
    program.linear_constraint({f"x{k}": w for k, w in enumerate(WEIGHT)}, "<=", ROOM, "room")
    found = MinimumEigenOptimizer(NumPyMinimumEigensolver()).solve(program)
    chosen = [round(float(bit)) for bit in found.x]
    worth, weight = known.sum_of_chosen(WORTH, chosen), known.sum_of_chosen(WEIGHT, chosen)
    return [found.fval, worth, max(0, weight - ROOM)]


def expected() -> list[float]:
    """Return the best of all packings, twice, and no excess."""
    best = max(
        known.sum_of_chosen(WORTH, bits)
        for bits in itertools.product((0, 1), repeat=len(WORTH))
        if known.sum_of_chosen(WEIGHT, bits) <= ROOM
    )
    return [best, best, 0]


CHECK = Check(
    __name__,
    title="a knapsack through a QUBO",
    group="gate model",
    imports=("qiskit_optimization", "qiskit_optimization.algorithms"),
    distributions=("qiskit-optimization", "qiskit"),
    source="all packings, in plain Python",
    tolerance=1e-6,
    extra="qiskit",
)
