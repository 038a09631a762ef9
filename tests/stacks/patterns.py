"""A model and a circuit that read differently in any other sequence of qubits."""

from __future__ import annotations

import dimod
import numpy as np

PATTERN = {"w": 1, "z": 0, "x": 0, "y": 1, "v": 1}
"""Reads differently backwards, and when dimod sorts the labels."""

TURNED = {"layers": 0, "evaluations": 0, "initial_parameters": [np.pi, 0.0, 0.0, np.pi, np.pi]}
"""The hardware ansatz without entanglers, turned to `PATTERN`."""


def pattern_model(vartype="BINARY"):
    """Return a model whose one ground state is `PATTERN`, at energy -3."""
    bqm = dimod.BinaryQuadraticModel("BINARY")
    for v, value in PATTERN.items():
        bqm.add_variable(v, 1.0 - 2.0 * value)
    assert list(bqm.variables) == list(PATTERN)
    bqm.add_interaction("w", "z", 1.0)
    return bqm.change_vartype(vartype, inplace=False)
