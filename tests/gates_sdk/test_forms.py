"""One model, one Ising form, in every SDK: the energies of dimod on all assignments."""

from __future__ import annotations

import itertools

import dimod
import numpy as np
import pytest
from gates_sdk.pickings import table2_model
from gates_sdk.stacks import needs, random_model, small_model


def cases():
    lonely = dimod.BinaryQuadraticModel({"a": 0.0, "b": 2.0, "c": 0.0}, {}, -1.0, "SPIN")
    return [
        pytest.param(small_model(), id="spins"),
        pytest.param(random_model(6, 3), id="binary"),
        pytest.param(lonely, id="zeros"),
        pytest.param(table2_model(2).bqm, id="table2"),
    ]


def assignments(bqm):
    """Return all assignments as bits, and dimod's energies of them."""
    bits = np.array(list(itertools.product((0, 1), repeat=bqm.num_variables)))
    values = bits if bqm.vartype is dimod.BINARY else 2 * bits - 1
    return bits, bqm.energies((values, list(bqm.variables)))


@needs("qiskit")
@pytest.mark.parametrize("bqm", cases())
def test_sparse_pauli_op(bqm):
    from qrobot.backends.qiskit import sparse_pauli_op

    operator = sparse_pauli_op(bqm)
    bits, energies = assignments(bqm)
    signs = (-1.0) ** (bits @ operator.paulis.z.T.astype(int))
    assert not operator.paulis.x.any()
    np.testing.assert_allclose(signs @ operator.coeffs.real, energies, atol=1e-9)
    if bqm.num_variables <= 6:
        index = bits @ (1 << np.arange(bqm.num_variables))
        diagonal = np.diag(operator.to_matrix()).real
        np.testing.assert_allclose(diagonal[index], energies, atol=1e-9)


@needs("pennylane")
@pytest.mark.parametrize("bqm", cases())
def test_pennylane_hamiltonian(bqm):
    import pennylane as qml

    from qrobot.backends.pennylane import hamiltonian

    made = hamiltonian(bqm)
    bits, energies = assignments(bqm)
    words = made.terms()
    z = 1 - 2 * bits
    wires = [[w for w in op.wires if "Z" in str(op)] for op in words[1]]
    found = sum(c * np.prod(z[:, w], axis=1) for c, w in zip(words[0], wires, strict=True))
    np.testing.assert_allclose(found, energies, atol=1e-9)
    if bqm.num_variables <= 6:
        matrix = qml.matrix(made, wire_order=range(bqm.num_variables))
        np.testing.assert_allclose(np.diag(matrix).real, energies, atol=1e-9)


@needs("braket")
@pytest.mark.parametrize("bqm", cases())
def test_braket_observable(bqm):
    from qrobot.backends.braket import observable

    made = observable(bqm)
    bits, energies = assignments(bqm)
    z, found = 1 - 2 * bits, np.zeros(len(bits))
    for word in getattr(made, "summands", [made]):
        factors = getattr(word, "factors", [word])
        qubits = [int(q) for f in factors if f.ascii_symbols[0] != "I" for q in f.targets]
        found += word.coefficient * np.prod(z[:, qubits], axis=1)
    np.testing.assert_allclose(found, energies, atol=1e-9)
