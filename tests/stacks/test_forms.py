"""One model, one Ising form, in every SDK: the energies of dimod on all assignments."""

from __future__ import annotations

import itertools

import dimod
import numpy as np
import pytest
from stacks.figures_energies import (
    SDKS,
    all_bits,
    by_dimod,
    random_bits,
    relative,
    small_cases,
    wide_case,
)
from stacks.pickings import table2_model
from stacks.stacks import needs, random_model, small_model

from qrobot.backends.gate import form
from qrobot.models import to_ising

STACKS = [pytest.param(sdk, marks=needs(sdk)) for sdk in SDKS]


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


@pytest.mark.parametrize("sdk", STACKS)
@pytest.mark.parametrize("bqm", cases())
def test_operators_have_the_energies_of_dimod(sdk, bqm):
    bits, energies = assignments(bqm)
    np.testing.assert_allclose(SDKS[sdk](bqm, bits), energies, rtol=0, atol=1e-9)


@pytest.mark.parametrize("sdk", STACKS)
@pytest.mark.parametrize("name", small_cases())
def test_operators_of_picking_models_on_all_assignments(sdk, name):
    model = small_cases()[name]
    assert model.num_variables <= 12
    bits = all_bits(model.num_variables)
    found, expected = SDKS[sdk](model.bqm, bits), by_dimod(model, bits)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("sdk", STACKS)
def test_operators_of_two_robots_and_four_items(sdk):
    model = wide_case()
    assert model.num_variables == 48
    bits = random_bits(48)
    assert len(bits) == 10_000
    found, expected = SDKS[sdk](model.bqm, bits), by_dimod(model, bits)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("sdk", STACKS)
def test_a_flipped_sign_is_seen_and_comes_from_one_place(sdk, monkeypatch):
    """With the annealer's convention every SDK is wrong by twice the fields, and only so."""
    model = small_cases()["reduced K=1 n=2, paper slack"]
    bits = all_bits(model.num_variables)
    monkeypatch.setattr(form, "to_ising", lambda bqm, _: to_ising(bqm, "annealer"))
    wrong = SDKS[sdk](model.bqm, bits)
    fields = (2 * bits - 1) @ to_ising(model.bqm).h
    assert np.abs(fields).max() > 1
    np.testing.assert_allclose(wrong - by_dimod(model, bits), -2 * fields, rtol=0, atol=1e-9)


def prepared():
    """Return a picking model, and a few assignments that are not their own mirror image."""
    model = small_cases()["reduced K=1 n=2, paper slack"]
    return model, np.vstack([np.eye(10, dtype=int)[:1], random_bits(10, 4, seed=1)])


@needs("qiskit")
def test_qiskits_expectation_of_prepared_states():
    from qiskit.quantum_info import Statevector

    from qrobot.backends.qiskit.sampler import sparse_pauli_op

    model, bits = prepared()
    operator = sparse_pauli_op(model.bqm)
    states = ["".join(map(str, row[::-1])) for row in bits]  # Qiskit writes qubit 0 last
    found = [Statevector.from_label(s).expectation_value(operator).real for s in states]
    assert relative(np.array(found), by_dimod(model, bits)) <= 1e-9


@needs("pennylane")
def test_pennylanes_expectation_of_prepared_states():
    import pennylane as qml

    from qrobot.backends.pennylane.sampler import hamiltonian

    model, bits = prepared()
    operator, device = hamiltonian(model.bqm), qml.device("default.qubit", wires=10)

    @qml.qnode(device)
    def circuit(row):
        qml.BasisState(row, wires=range(10))
        return qml.expval(operator)

    assert relative(np.array([circuit(row) for row in bits]), by_dimod(model, bits)) <= 1e-9


@needs("braket")
def test_brakets_expectation_of_prepared_states():
    """Word by word: the local simulator takes no sum, and no coefficient."""
    from braket.circuits import Circuit
    from braket.circuits.observables import TensorProduct
    from braket.devices import LocalSimulator

    from qrobot.backends.braket.sampler import observable

    model, bits = prepared()
    words = observable(model.bqm).summands
    found = []
    for row in bits:
        circuit = Circuit()
        for qubit, bit in enumerate(row):
            circuit = circuit.x(qubit) if bit else circuit.i(qubit)
        for word in words:
            plain = [type(f)(f.targets[0]) for f in getattr(word, "factors", [word])]
            circuit.expectation(TensorProduct(plain) if len(plain) > 1 else plain[0])
        values = LocalSimulator().run(circuit, shots=0).result().values
        found.append(sum(w.coefficient * v for w, v in zip(words, values, strict=True)))
    assert relative(np.array(found), by_dimod(model, bits)) <= 1e-9
