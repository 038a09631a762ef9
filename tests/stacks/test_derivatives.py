"""Ways to derive on PennyLane's devices: each works, with one answer, or is refused."""

from __future__ import annotations

import dimod
import numpy as np
import pytest

from qrobot.backends import get
from qrobot.errors import BackendError, InputError

pytest.importorskip("pennylane", reason="pennylane is not installed")
pytestmark = pytest.mark.filterwarnings("ignore")

ALLOWED = {
    "lightning.qubit": {"adjoint", "parameter-shift"},
    "default.qubit": {"adjoint", "backprop", "parameter-shift"},
    "default.mixed": {"parameter-shift"},
}


def sample(**options):
    bqm = dimod.BinaryQuadraticModel(
        {0: 1.0, 1: -1.0, 2: 0.5}, {(0, 1): 1.0, (1, 2): -2.0}, 0.0, "BINARY"
    )
    given = {"seed": 0, "evaluations": 4, "starts": 1, "optimizer": "adam", "num_reads": 5}
    return get("pennylane-vqe").sample(bqm, **(given | options))


@pytest.mark.parametrize("method", ["adjoint", "backprop", "parameter-shift", "guess"])
@pytest.mark.parametrize("device", ALLOWED)
def test_every_method_on_every_device(device: str, method: str) -> None:
    if method not in ALLOWED[device]:
        with pytest.raises(
            InputError, match=f"'{method}' is not (a way to derive on device|one of)"
        ):
            sample(device=device, diff_method=method)
        return
    if device == "default.mixed":  # measured there: another objective
        assert sample(device=device, diff_method=method).info["history"]
        return
    for alpha in (1.0, 0.3):
        expected = sample(device="lightning.qubit", alpha=alpha).info["history"]
        found = sample(device=device, diff_method=method, alpha=alpha).info["history"]
        np.testing.assert_allclose(found, expected, atol=1e-8)


def test_shots_have_no_adjoint() -> None:
    with pytest.raises(InputError, match="with shots; use parameter-shift"):
        sample(diff_method="adjoint", shots=10)


@pytest.mark.parametrize("backend", ["pennylane-vqe", "qiskit-vqe", "braket-vqe"])
def test_options_that_a_device_refuses_are_one_error_of_ours(backend: str) -> None:
    sdk = {"pennylane": "pennylane", "qiskit": "qiskit_aer", "braket": "braket.devices"}
    pytest.importorskip(sdk[backend.partition("-")[0]])
    with pytest.raises((BackendError, InputError)):
        get(backend).sample(
            dimod.BinaryQuadraticModel({0: 1.0}, {}, 0.0, "BINARY"),
            device_options={"nonsense_option": 3},
            num_reads=2,
            evaluations=1,
        )
