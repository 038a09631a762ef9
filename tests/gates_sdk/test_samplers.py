"""What every sampler of every SDK has to do, on its local device."""

from __future__ import annotations

import json
import unittest

import dimod
import dimod.testing
import numpy as np
import pytest
from gates_sdk.pickings import table2_model
from gates_sdk.stacks import SAMPLERS, load, random_model, samplers, small_model

from qrobot.backends.gates.form import Form, diagonal
from qrobot.backends.variational import make_ansatz, terms
from qrobot.backends.variational.engine import PlainEngine, StateEngine
from qrobot.errors import BackendError, InputError, MissingExtraError


def quick(name):
    """Return a factory of samplers that search little: dimod's tests want energies only."""

    class Quick(load(name)):
        def sample(self, bqm, **parameters):
            return super().sample(bqm, **({"evaluations": 2, "starts": 1, "seed": 1} | parameters))

    Quick.__name__ = name
    return Quick


@pytest.mark.parametrize("name", samplers())
def test_dimods_own_sampler_tests(name):
    factory = quick(name)

    @dimod.testing.load_sampler_bqm_tests(factory)
    class Case(unittest.TestCase):
        pass

    dimod.testing.assert_sampler_api(factory())
    result = unittest.TestResult()
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(Case)
    suite.run(result)
    assert suite.countTestCases() >= 30
    assert result.wasSuccessful(), [text for _, text in [*result.failures, *result.errors]]


@pytest.mark.parametrize("name", samplers())
def test_the_ground_state_of_a_small_model_is_sampled(name):
    found = load(name)().sample(small_model(), seed=3, num_reads=200, evaluations=10)
    assert found.first.energy == pytest.approx(-5.2)
    assert len(found) == 200
    info = found.info
    assert info["ground_probability"] > 2 * info["ground_probability_uniform"]
    assert len(info["history"]) == info["evaluations"] <= info["executions"]
    assert set(info["timing"]) == {"build", "optimise", "sample"}
    json.dumps(info)  # plain data


@pytest.mark.parametrize("name", samplers())
def test_one_seed_gives_one_answer(name):
    one, two = (
        load(name)().sample(random_model(4, 2), seed=7, num_reads=30, evaluations=4) for _ in "ab"
    )
    assert (one.record.sample == two.record.sample).all()
    assert one.info["parameters"] == two.info["parameters"]


@pytest.mark.parametrize("name", samplers())
@pytest.mark.parametrize("kind", ["qaoa", "hardware", "problem"])
def test_states_are_those_of_numpy(name, kind):
    """Gates, order of qubits and signs agree; so do derivatives."""
    sampler, bqm = load(name)(), random_model(4, 5)
    if sampler.algorithm == "qaoa" and kind != "qaoa":
        pytest.skip("one ansatz a sampler is enough")
    form = Form.from_bqm(bqm)
    ansatz = make_ansatz(kind, form, terms(bqm), 2)
    options = options_of(sampler)
    engine = sampler.engine(ansatz, options, {})
    assert isinstance(engine, StateEngine)
    angles = ansatz.circuit.angles(ansatz.start(np.random.default_rng(1)) + 0.3)
    plain = PlainEngine(ansatz.circuit)
    np.testing.assert_allclose(engine.probabilities(angles), plain.probabilities(angles), atol=1e-9)
    if name.startswith("pennylane"):
        weights = diagonal(form)
        value, slope = engine.slope(angles, weights)
        expected, by_angle = plain.slope(angles, weights)
        assert value == pytest.approx(expected, abs=1e-9)
        np.testing.assert_allclose(slope, by_angle, atol=1e-9)


def options_of(sampler):
    from qrobot.backends.variational import Options

    return Options(seed=1, ansatz="qaoa" if sampler.algorithm == "qaoa" else "hardware")


@pytest.mark.parametrize("name", samplers())
def test_too_many_qubits_are_refused_before_allocating(name):
    for qubits, amount in ((45, "PiB"), (3000, r"10\^\d+")):
        bqm = dimod.BinaryQuadraticModel(dict.fromkeys(range(qubits), 1.0), {}, 0.0, "BINARY")
        with pytest.raises(BackendError, match=rf"{qubits} qubits.*{amount}"):
            load(name)().sample(bqm)


@pytest.mark.parametrize("name", samplers())
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_is_not_finite_is_refused(name, value):
    with pytest.raises(InputError, match="finite"):
        load(name)().sample(dimod.BinaryQuadraticModel({"a": value}, {}, 0.0, "BINARY"))
    with pytest.raises(InputError, match="finite"):
        load(name)().sample(dimod.BinaryQuadraticModel({}, {"ab": value}, 0.0, "SPIN"))


@pytest.mark.parametrize("name", samplers())
def test_a_device_that_does_not_exist_is_refused(name):
    with pytest.raises(InputError, match=r"device|moon"):
        load(name)().sample(small_model(), device="moon")


@pytest.mark.parametrize("name", SAMPLERS)
def test_an_absent_sdk_is_one_sentence(name, monkeypatch):
    """Runs where the SDK is installed and where it is not."""
    import sys

    for module in ("qiskit", "pennylane", "braket", "braket.circuits"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=name.partition("-")[0]) as caught:
        load(name)().sample(small_model())
    assert "pip install 'qrobot[" in str(caught.value)


@pytest.mark.parametrize("name", samplers("vqe"))
def test_vqe_finds_the_optimum_of_the_papers_smallest_row(name):
    """Table 2, n = 2: ten times what uniform reads give, without repair."""
    model = table2_model(2)
    assert model.num_variables == 10
    found = load(name)().sample(model.bqm, seed=0, num_reads=1000)
    reads = model.decode_all(found)
    least = found.info["ground_energy"]
    share = float((np.abs(found.record.energy - least) < 1e-6).mean())
    assert share >= 10 * found.info["ground_probability_uniform"]
    assert reads is not None
