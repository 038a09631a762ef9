"""One picking model in docplex, dimod, Qiskit, PennyLane and Braket: are energies equal?

    PYTHONPATH=tests python -m stacks.figures_energies

On all assignments of models of up to 12 qubits, and on 10,000 random ones at K = 2, n = 4.
Every operator is evaluated by what its SDK says it is: the matrices of Qiskit and PennyLane
where they fit, the matrix of every word of Braket's sum, otherwise the SDK's own words.
``relative`` is the largest difference to dimod over the largest energy.
"""

from __future__ import annotations

import argparse
import importlib.util
from fractions import Fraction

import numpy as np
import pytest
from stacks.pickings import table2

from qrobot.models import PickingModel, build_model
from qrobot.problem import (
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Point,
    Robot,
    Warehouse,
)

FITS = 12
"""Qubits of a matrix that is evaluated as a whole."""

needs_docplex = pytest.mark.skipif(
    not all(map(importlib.util.find_spec, ("docplex", "qiskit_optimization"))),
    reason="docplex or qiskit-optimization is not installed: pip install 'qrobot[docplex]'",
)


def picking(
    weights: list[int],
    robots: list[int],
    lots: list[list[int]],
    matrix: list[list[float]] | None = None,
) -> Instance:
    """Return an instance of whole weights; lots are the items of each order, from 0."""
    places = [(3.0, 4.0), (-1.0, 6.5), (8.0, -2.25), (-5.5, -3.0)]
    where = [Node(k + 1) if matrix else Point(*places[k]) for k in range(len(weights))]
    floor: Warehouse = OpenFloor(depot_x=0.0, depot_y=0.0)
    if matrix:
        floor = DistanceTable(matrix=tuple(map(tuple, matrix)), depot_node=0)
    return Instance(
        warehouse=floor,
        items=tuple(
            Item(f"i{k}", Fraction(w), place)
            for k, (w, place) in enumerate(zip(weights, where, strict=True))
        ),
        orders=tuple(Order(f"o{o}", tuple(f"i{k}" for k in lot)) for o, lot in enumerate(lots)),
        robots=tuple(Robot(f"R{k}", Fraction(room)) for k, room in enumerate(robots)),
        name="energies",
    )


def small_cases() -> dict[str, PickingModel]:
    """Return models of up to 12 qubits; between them they have every term of the formulas."""
    unfair = [[0, 9, 1.5], [1, 0, 40], [2.25, 33, 0]]  # asymmetric; over the depot is shorter
    return {
        "reduced K=1 n=2, paper slack": build_model(table2(2), "reduced", "paper"),
        "reduced K=2 n=2, whole order, no slack": build_model(
            picking([1, 0], [1, 1], [[0, 1]]), "reduced", "paper"
        ),
        "full K=2 n=1, no slack": build_model(picking([1], [1, 1], [[0]]), "full", "paper"),
        "full K=1 n=1, exact slack": build_model(picking([1], [5], [[0]]), "full", "exact"),
        "reduced K=1 n=2, asymmetric, detours": build_model(
            picking([2, 3], [6], [[0], [1]], unfair), "reduced", "exact"
        ),
    }


def wide_case(encoding: str = "reduced") -> PickingModel:
    """Return a model of two robots and four items in two orders: 48 qubits (reduced)."""
    return build_model(picking([3, 4, 5, 2], [15, 9], [[0, 1], [2, 3]]), encoding)


def all_bits(qubits: int) -> np.ndarray:
    """Return all assignments, shape (2**qubits, qubits); variable k is bit k of the row."""
    return (np.arange(2**qubits)[:, None] >> np.arange(qubits)) & 1


def random_bits(qubits: int, count: int = 10_000, seed: int = 0) -> np.ndarray:
    """Return random assignments, as many of few ones as of many."""
    rng = np.random.default_rng(seed)
    return (rng.random((count, qubits)) < rng.random((count, 1))).astype(np.int64)


def by_dimod(model: PickingModel, bits: np.ndarray) -> np.ndarray:
    """Return the energies of the vectorised model."""
    return np.asarray(model.bqm.energies((bits, model.variables)))


def by_docplex(model: PickingModel, bits: np.ndarray) -> np.ndarray:
    """Return the energies of docplex -> QuadraticProgram -> penalties."""
    from qrobot.models.docplex import bqm_from_docplex, picking_docplex

    made = picking_docplex(model.instance, model.encoding, model.slack)
    bqm = bqm_from_docplex(made, model.penalties)
    return np.asarray(bqm.energies((bits, model.variables)))


def by_qiskit(bqm, bits: np.ndarray) -> np.ndarray:
    """Return a SparsePauliOp's values: Qiskit's qubit 0 is the lowest bit of an index."""
    from qrobot.backends.qiskit.sampler import sparse_pauli_op

    made, qubits = sparse_pauli_op(bqm), bits.shape[1]
    assert not made.paulis.x.any()
    if qubits <= FITS:
        diagonal = made.to_matrix(sparse=True).diagonal().real
        return diagonal[bits @ (1 << np.arange(qubits))]
    return ((-1.0) ** (bits @ made.paulis.z.T.astype(np.int64))) @ made.coeffs.real


def by_pennylane(bqm, bits: np.ndarray) -> np.ndarray:
    """Return a Hamiltonian's values: PennyLane's wire 0 is the highest bit of an index."""
    from qrobot.backends.pennylane.sampler import hamiltonian

    made, qubits = hamiltonian(bqm), bits.shape[1]
    if qubits <= FITS:
        diagonal = made.sparse_matrix(wire_order=range(qubits)).diagonal().real
        return diagonal[bits @ (1 << np.arange(qubits)[::-1])]
    found = np.zeros(len(bits))
    for word, value in made.pauli_rep.items():
        assert set(word.values()) <= {"Z"}
        found += value * np.prod(1 - 2 * bits[:, list(word)], axis=1)
    return found


def by_braket(bqm, bits: np.ndarray) -> np.ndarray:
    """Return an observable's values: the first target of a word is its highest bit."""
    from qrobot.backends.braket.sampler import observable

    made, found = observable(bqm), np.zeros(len(bits))
    for word in getattr(made, "summands", [made]):
        matrix = word.to_matrix()  # the coefficient is in it
        diagonal = np.diag(matrix).real
        assert np.allclose(matrix, np.diag(diagonal))
        chosen = np.zeros(len(bits), dtype=np.int64)
        for qubit in word.targets:
            chosen = 2 * chosen + bits[:, int(qubit)]
        found += diagonal[chosen]
    return found


SDKS = {"qiskit": by_qiskit, "pennylane": by_pennylane, "braket": by_braket}


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest difference over the largest energy."""
    return float(np.abs(found - expected).max() / max(1.0, np.abs(expected).max()))


def main() -> None:
    """Print a row for each model and stack."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=10_000, help="assignments at K=2, n=4")
    count = parser.parse_args().random
    cases = {name: (model, all_bits(model.num_variables)) for name, model in small_cases().items()}
    for encoding in ("reduced", "full"):
        model = wide_case(encoding)
        cases[f"{encoding} K=2 n=4, orders of two"] = (
            model,
            random_bits(model.num_variables, count),
        )
    print("| model | qubits | assignments | largest energy | stack | difference | relative |")
    print("|---|---|---|---|---|---|---|")
    for name, (model, bits) in cases.items():
        expected = by_dimod(model, bits)
        found = {"docplex": by_docplex(model, bits)}
        found |= {sdk: by(model.bqm, bits) for sdk, by in SDKS.items()}
        for stack, energies in found.items():
            away, largest = np.abs(energies - expected).max(), np.abs(expected).max()
            print(
                f"| {name} | {bits.shape[1]} | {len(bits)} | {largest:.6g} | {stack} "
                f"| {away:.1e} | {relative(energies, expected):.1e} |"
            )


if __name__ == "__main__":
    main()
