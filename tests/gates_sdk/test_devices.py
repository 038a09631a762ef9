"""Devices beyond the default ones, offline: Aer, fake IBM backends, PennyLane's others, AWS."""

from __future__ import annotations

import dimod
import numpy as np
import pytest
from gates_sdk.stacks import load, needs, random_model, small_model

from qrobot.backends.gates.form import Form
from qrobot.backends.variational import Options, make_ansatz, terms
from qrobot.backends.variational.devices import DEVICES
from qrobot.backends.variational.engine import PlainEngine
from qrobot.errors import BackendError, CredentialsError, InputError

SECRET = "planted-secret-0123456789"


@needs("qiskit")
@pytest.mark.parametrize("kind", ["hardware", "problem"])
def test_aer_agrees_with_numpy(kind):
    """Whole states, with truncation off: see qiskit-aer#2442."""
    bqm = random_model(5, 8)
    ansatz = make_ansatz(kind, Form.from_bqm(bqm), terms(bqm), 2)
    engine = load("qiskit-vqe")().engine(ansatz, Options(device="aer"), {})
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


@needs("qiskit")
def test_fake_ibm_hardware_runs_the_transpiled_circuit():
    fake = pytest.importorskip("qiskit_ibm_runtime.fake_provider", reason="the ibm extra is absent")
    found = load("qiskit-qaoa")().sample(small_model(), mode=fake.FakeManilaV2(), seed=1)
    info = found.info
    assert info["device"] == "fake_manila"
    assert info["trained"] == "local"
    assert len(info["jobs"]) == 1
    assert set(info["gates"]) <= {"rz", "sx", "x", "cx", "measure", "barrier"}
    assert found.aggregate().first.energy == pytest.approx(-5.2)
    share = float((np.abs(found.record.energy + 5.2) < 1e-9).mean())
    assert share > 2 / 8
    large = dimod.BinaryQuadraticModel(dict.fromkeys(range(6), 1.0), {}, 0.0, "BINARY")
    with pytest.raises(BackendError, match=r"6 qubits.*fake_manila has 5"):
        load("qiskit-qaoa")().sample(large, mode=fake.FakeManilaV2())


@needs("qiskit")
def test_an_account_that_is_refused_tells_no_token(monkeypatch):
    runtime = pytest.importorskip("qiskit_ibm_runtime", reason="the ibm extra is absent")

    def refuse(*_args, **_options):
        raise AttributeError(f"no instance for token {SECRET}")

    monkeypatch.setattr(runtime, "QiskitRuntimeService", refuse)
    with pytest.raises(CredentialsError) as caught:
        load("qiskit-vqe")().sample(small_model(), device="ibm:moon", evaluations=0)
    assert SECRET not in str(caught.value)
    assert caught.value.__suppress_context__
    with pytest.raises(InputError, match="mode"):
        load("qiskit-vqe")().sample(small_model(), mode="ibm")


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


@needs("braket")
@pytest.mark.parametrize("device", [DEVICES["SV1"], DEVICES["Garnet"]])
def test_a_managed_device_runs_the_same_circuit(device):
    """A stand-in for AwsDevice on the local simulator; chips get CNOTs for ZZ."""
    from braket.devices import LocalSimulator

    seen = []

    class Stand:
        arn, name = device, "stand"

        def run(self, circuit, shots, **options):
            seen.append((str(circuit), options))
            return LocalSimulator().run(circuit, shots=shots)

    found = load("braket-qaoa")().sample(
        small_model(), device=Stand(), seed=1, run_options={"inputs": {}}
    )
    assert found.info["device"] == device
    assert found.info["trained"] == "local"
    assert len(seen) == 1  # nothing but the reads is billed
    assert ("ZZ" in seen[0][0]) == device.endswith("sv1")
    assert float((np.abs(found.record.energy + 5.2) < 1e-9).mean()) > 2 / 8


@needs("braket")
def test_a_device_that_fails_tells_no_secret():
    class Broken:
        arn, name = DEVICES["SV1"], "broken"

        def run(self, *_args, **_options):
            raise RuntimeError(f"signature {SECRET}")

    with pytest.raises(BackendError, match="RuntimeError") as caught:
        load("braket-vqe")().sample(small_model(), device=Broken(), evaluations=0)
    assert SECRET not in str(caught.value)
    assert caught.value.__suppress_context__


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
