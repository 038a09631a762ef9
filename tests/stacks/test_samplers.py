"""What every sampler of every SDK has to do, on its local device."""

from __future__ import annotations

import json

import dimod
import numpy as np
import pytest
from stacks.pickings import table2_model
from stacks.stacks import SAMPLERS, load, random_model, samplers, small_model

from qrobot.backends import capabilities, get, names
from qrobot.backends.gate import make_ansatz, terms
from qrobot.backends.gate.engine import PlainEngine, StateEngine
from qrobot.backends.gate.form import Form, diagonal
from qrobot.backends.testing import SamplerConformance
from qrobot.errors import BackendError, InputError, MissingExtraError
from qrobot.jobs import PARAMETERS

QUICK = {
    "vqe": {"evaluations": 4, "starts": 1, "seed": 1},
    "qaoa": {"evaluations": 4, "seed": 1},
    "tabu": {"moves": 50, "num_restarts": 2},
}
"""Parameters that make a search short; everything else stays as it is by default."""


def quick(name):
    """Return a sampler of the registry that searches little."""
    sampler = get(name)
    given = QUICK.get(name.rpartition("-")[2], {})
    sample = sampler.sample
    sampler.sample = lambda bqm, **parameters: sample(bqm, **(given | parameters))
    return sampler


def local_samplers():
    """Return every local sampler of the registry, skipped where its extra is absent."""
    for name in names():
        try:
            found = capabilities(name)
        except MissingExtraError as error:
            yield pytest.param(name, marks=pytest.mark.skip(reason=str(error)))
            continue
        if found.kind == "sampler" and found.local:
            yield name


CHECKS = [check for check in dir(SamplerConformance) if check.startswith("test_")]


@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize("name", list(local_samplers()))
def test_the_conformance_suite(name, check):
    """With `dimod.testing` inside: ``test_passes_the_tests_of_dimod``."""

    class Suite(SamplerConformance):
        def make(self):
            return quick(name)

    if name.endswith("vqe") and "ground_state" in check:
        Suite.parameters = {"evaluations": 60}  # two passes over the parameters
    getattr(Suite(), check)()


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
    engine = sampler.engine(ansatz.circuit, options)
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
    from qrobot.backends.gate import Options

    return Options(seed=1, ansatz="qaoa" if sampler.algorithm == "qaoa" else "hardware")


@pytest.mark.parametrize("name", samplers())
def test_too_many_qubits_are_refused_before_allocating(name):
    for qubits, amount in ((45, "PiB"), (1000, r"10\^303 b"), (20_000, r"10\^6022 b")):
        bqm = dimod.BinaryQuadraticModel(dict.fromkeys(range(qubits), 1.0), {}, 0.0, "BINARY")
        with pytest.raises(BackendError, match=rf"{qubits} qubits.*{amount}"):
            load(name)().sample(bqm)


@pytest.mark.parametrize("name", samplers())
def test_local_devices_bill_nothing_and_take_the_limits_of_a_job(name):
    sampler, bqm = load(name)(), small_model()
    assert set(PARAMETERS) <= set(sampler.parameters)
    assert not sampler.runs_remotely()
    assert sampler.estimate(bqm, num_reads=10).usd == 0.0
    dry = sampler.sample(bqm, dry_run=True)
    assert len(dry) == 0
    assert dry.info["remote"]["estimate"]["usd"] == 0.0
    assert "local" in dry.info["remote"]["estimate"]["basis"]
    found = sampler.sample(
        bqm, num_reads=9, evaluations=2, starts=1, timeout=60, max_cost=0, wait=False,
        context={"a": 1},
    )  # fmt: skip
    assert len(found) == 9
    assert "remote" not in found.info
    for wrong in (
        {"timeout": 0}, {"timeout": "soon"}, {"max_cost": -1}, {"max_cost": float("nan")},
        {"wait": 1}, {"dry_run": "no"}, {"context": 3},
    ):  # fmt: skip
        with pytest.raises(InputError, match=next(iter(wrong))):
            sampler.sample(bqm, **wrong)


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
