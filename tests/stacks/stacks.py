"""Samplers of the SDKs that are installed; the others' tests are skipped with a reason."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

import dimod
import numpy as np
import pytest

MODULES = {"qiskit": "qiskit_aer", "pennylane": "pennylane_lightning", "braket": "braket.devices"}


def needs(sdk: str) -> pytest.MarkDecorator:
    """Return the mark that skips when an SDK is absent."""
    try:
        found = importlib.util.find_spec(MODULES[sdk]) is not None
    except ModuleNotFoundError:
        found = False
    return pytest.mark.skipif(
        not found, reason=f"{sdk} is not installed: pip install 'qrobot[{sdk}]'"
    )


def small_model() -> dimod.BinaryQuadraticModel:
    """Return three spins with a single ground state and an offset."""
    return dimod.BinaryQuadraticModel(
        {"a": 1, "b": -1, "c": 0.3},
        {("a", "b"): 1, ("b", "c"): -2, ("a", "c"): 1.0},
        0.5,
        "SPIN",
    )


def random_model(qubits: int, seed: int) -> dimod.BinaryQuadraticModel:
    """Return a dense binary model with normal coefficients and an offset."""
    rng = np.random.default_rng(seed)
    return dimod.BinaryQuadraticModel(
        dict(enumerate(rng.normal(size=qubits))),
        {(i, j): rng.normal() for j in range(qubits) for i in range(j)},
        rng.normal(),
        "BINARY",
    )


SAMPLERS = {
    "qiskit-vqe": "QiskitVQE",
    "qiskit-qaoa": "QiskitQAOA",
    "pennylane-vqe": "PennyLaneVQE",
    "pennylane-qaoa": "PennyLaneQAOA",
    "braket-vqe": "BraketVQE",
    "braket-qaoa": "BraketQAOA",
}


def load(name: str) -> Any:
    """Return the class of a sampler; its SDK is not imported."""
    module = importlib.import_module(f"qrobot.backends.{name.partition('-')[0]}.sampler")
    return getattr(module, SAMPLERS[name])


def samplers(algorithm: str = "") -> list[Any]:
    """Return all samplers (of an algorithm) as parameters, skipped where the SDK is absent."""
    names = [name for name in SAMPLERS if name.endswith(algorithm)]
    return [pytest.param(name, marks=needs(name.partition("-")[0])) for name in names]
