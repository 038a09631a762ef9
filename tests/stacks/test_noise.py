"""Noise: the exact distribution is that of all trajectories, or it is refused."""

from __future__ import annotations

import dimod
import numpy as np
import pytest

from qrobot.backends import get
from qrobot.errors import BackendError, InputError

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")
noise = pytest.importorskip("qiskit_aer.noise", reason="qiskit-aer is not installed")

ANGLES = {"evaluations": 0, "initial_parameters": [0.7, 0.4]}


def model() -> dimod.BinaryQuadraticModel:
    return dimod.BinaryQuadraticModel(
        {0: 1.0, 1: -1.0, 2: 0.5}, {(0, 1): 1.0, (1, 2): -2.0}, 0.0, "BINARY"
    )


def noisy(rate: float = 0.05):
    made = noise.NoiseModel()
    made.add_all_qubit_quantum_error(noise.depolarizing_error(rate, 2), ["cx"])
    made.add_all_qubit_quantum_error(noise.depolarizing_error(rate / 2, 1), ["sx", "x"])
    return made


def sample(noise_model, **options):
    return get("qiskit-qaoa").sample(
        model(), device="aer", device_options={"noise_model": noise_model}, **ANGLES, **options
    )


def test_the_exact_state_under_noise_is_no_single_trajectory() -> None:
    exact = {
        sample(noisy(), num_reads=10, seed=seed).info["ground_probability"] for seed in range(3)
    }
    assert len(exact) == 1
    shots = 40_000
    read = sample(noisy(), num_reads=shots, seed=3, shots=shots).record.energy
    share, p = float((read <= read.min() + 1e-9).mean()), exact.pop()
    assert abs(share - p) < 5 * np.sqrt(p * (1 - p) / shots)


def test_a_model_without_noise_is_the_pure_state() -> None:
    pure = get("qiskit-qaoa").sample(model(), device="statevector", num_reads=1, **ANGLES)
    ideal = sample(noise.NoiseModel(), num_reads=1)
    assert ideal.info["ground_probability"] == pytest.approx(pure.info["ground_probability"])
    faint = sample(noisy(1e-9), num_reads=1)
    assert faint.info["ground_probability"] == pytest.approx(
        pure.info["ground_probability"], abs=1e-6
    )


def test_readout_errors_want_shots() -> None:
    model = noisy()
    model.add_all_qubit_readout_error(noise.ReadoutError([[0.9, 0.1], [0.1, 0.9]]))
    with pytest.raises(InputError, match=r"readout errors.*give shots"):
        sample(model, num_reads=1)
    assert len(sample(model, num_reads=10, shots=10)) <= 10


def test_a_density_matrix_that_does_not_fit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qrobot.backends.gate.resources.available_memory", lambda: 1000)
    with pytest.raises(BackendError, match=r"density matrix of 3 qubits .* give shots"):
        sample(noisy(), num_reads=1)


@pytest.mark.parametrize("given", ["x", {}, 3, ["depolarizing"]])
@pytest.mark.parametrize("shots", [None, 10])
def test_what_is_not_a_noise_model_is_refused(given: object, shots: int | None) -> None:
    with pytest.raises(InputError, match=r"noise_model: .* is not a noise model of Aer"):
        sample(given, num_reads=1, shots=shots)


def of_method(method: str, **options):
    return get("qiskit-qaoa").sample(
        model(), device="aer", device_options={"method": method}, num_reads=1, **ANGLES, **options
    )


@pytest.mark.parametrize("method", ["automatic", "density_matrix", "matrix_product_state"])
def test_methods_of_aer_have_one_answer(method: str) -> None:
    pure = get("qiskit-qaoa").sample(model(), device="statevector", num_reads=1, **ANGLES)
    assert of_method(method).info["ground_probability"] == pytest.approx(
        pure.info["ground_probability"]
    )


@pytest.mark.parametrize("method", ["stabilizer", "unitary", "superop", "magic", 3])
def test_methods_without_exact_probabilities_are_refused(method: str) -> None:
    with pytest.raises(InputError, match=r"method: .* gives no exact probabilities"):
        of_method(method)
