"""Local devices beyond the default ones: Aer, PennyLane's others, Braket's objects."""

from __future__ import annotations

import dimod
import numpy as np
import pytest
from stacks.stacks import load, needs, random_model, small_model

from qrobot.backends.braket.devices import DEVICES
from qrobot.backends.gate import Options, make_ansatz, terms
from qrobot.backends.gate.engine import PlainEngine
from qrobot.backends.gate.form import Form
from qrobot.errors import BackendError, InputError

SECRET = "planted-secret-0123456789"


@needs("qiskit")
@pytest.mark.parametrize("kind", ["hardware", "problem"])
def test_aer_agrees_with_numpy(kind):
    """Whole states, with truncation off: see qiskit-aer#2442."""
    bqm = random_model(5, 8)
    ansatz = make_ansatz(kind, Form.from_bqm(bqm), terms(bqm), 2)
    engine = load("qiskit-vqe")().engine(ansatz.circuit, Options(device="aer"))
    angles = ansatz.circuit.angles(ansatz.start(np.random.default_rng(4)))
    expected = PlainEngine(ansatz.circuit).probabilities(angles)
    np.testing.assert_allclose(engine.probabilities(angles), expected, atol=1e-9)


@needs("qiskit")
def test_aer_shots_follow_the_state():
    found = load("qiskit-vqe")().sample(
        small_model(), device="aer", shots=200, seed=2, evaluations=6, starts=1, num_reads=500
    )
    assert len(found) == 500
    assert len(found.info["history"]) == 6
    assert found.info["optimizer"] == "spsa"


@needs("pennylane")
@pytest.mark.parametrize("device", ["default.qubit", "braket.local.qubit"])
def test_other_pennylane_devices(device):
    if device.startswith("braket"):
        pytest.importorskip("braket.pennylane_plugin", reason="the plugin is absent")
    found = load("pennylane-vqe")().sample(
        small_model(), device=device, seed=0, evaluations=3, starts=1, optimizer="adam"
    )
    assert found.info["diff_method"] == "parameter-shift"
    assert found.info["history"][2] < found.info["history"][0]


@needs("pennylane")
def test_pennylane_shots():
    found = load("pennylane-qaoa")().sample(
        small_model(), seed=0, shots=100, evaluations=6, num_reads=300
    )
    assert len(found) == 300
    assert found.first.energy == pytest.approx(-5.2)


@needs("pennylane")
@pytest.mark.parametrize("device", ["lightning.qubit", "default.qubit", "braket.local.qubit"])
def test_pennylane_shots_are_in_the_sequence_of_the_variables(device):
    if device.startswith("braket"):
        pytest.importorskip("braket.pennylane_plugin", reason="the plugin is absent")
    bqm = dimod.BinaryQuadraticModel({"z": -1.0, "b": 1.0, "a": 1.0, "c": -2.0}, {}, "BINARY")
    found = load("pennylane-vqe")().sample(
        bqm, device=device, shots=5, num_reads=7, layers=0, evaluations=0,
        initial_parameters=[np.pi, 0.0, 0.0, np.pi],
    )  # fmt: skip
    assert found.record.energy.tolist() == [-3.0] * 7


@needs("braket")
def test_a_local_simulator_may_be_given_as_it_is():
    from braket.devices import LocalSimulator

    found = load("braket-qaoa")().sample(
        small_model(), device=LocalSimulator(), seed=1, evaluations=5, shots=50, num_reads=100
    )
    assert len(found) == 100
    assert "remote" not in found.info
    with pytest.raises(InputError, match="is not a Braket device"):
        load("braket-qaoa")().sample(small_model(), device=object())


@needs("braket")
def test_a_device_that_fails_tells_no_secret():
    class Broken:
        name = "broken"

        def run(self, *_args, **_options):
            raise RuntimeError(f"signature {SECRET}")

    with pytest.raises(BackendError, match="RuntimeError") as caught:
        load("braket-vqe")().sample(small_model(), device=Broken(), evaluations=0, shots=5)
    assert SECRET not in str(caught.value)
    assert caught.value.__context__ is None


@needs("braket")
def test_braket_names_are_those_of_the_sdk():
    from braket.devices import Devices

    current = {
        str(arn)
        for maker in ("Amazon", "IonQ", "IQM", "Rigetti", "AQT")
        for arn in getattr(Devices, maker, ())
        if not arn.name.startswith("_")
    }
    assert current == set(DEVICES.values())
