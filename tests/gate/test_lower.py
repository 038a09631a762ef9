"""Gates taken apart do the same, without any other qubit."""

from __future__ import annotations

import numpy as np
import pytest

from qrobot.backends.gate.circuit import Circuit, Gate, lowered
from qrobot.backends.gate.state.general import state

ALLOWED = {("x", 1), ("x", 2), ("phase", 1), ("swap", 1)}


@pytest.mark.parametrize("name", ["x", "rx", "ry", "rz", "phase", "swap"])
@pytest.mark.parametrize("qubits", range(2, 9))
def test_any_number_of_controls(name: str, qubits: int) -> None:
    rng = np.random.default_rng(qubits)
    width = 2 if name == "swap" else 1
    for count in range(qubits - width + 1):
        drawn = rng.permutation(qubits).tolist()
        gates: list[Gate] = []
        for axis in ("ry", "rz"):
            angles = rng.uniform(0.3, 2.0, qubits)
            gates += [Gate(axis, (q,), angle=float(a)) for q, a in enumerate(angles)]
        controls = tuple(drawn[width : width + count])
        values = tuple(rng.integers(0, 2, count).tolist())
        angle = 0.7 if name not in ("x", "swap") else 0.0
        targets = tuple(drawn[:width])
        gates.append(Gate(name, targets, angle=angle, controls=controls, values=values))
        circuit = Circuit(qubits, tuple(gates))
        found = lowered(circuit)
        np.testing.assert_allclose(state(found), state(circuit), atol=1e-12)
        for gate in found.gates:
            assert not gate.controls or (gate.name, len(gate.controls)) in ALLOWED
            assert set(gate.control_values) <= {1}


def test_many_controls_stay_affordable() -> None:
    controls = tuple(range(40))
    circuit = Circuit(41, (Gate("ry", (40,), angle=0.3, controls=controls),))
    assert len(lowered(circuit).gates) < 16 * 40**2  # quadratic, not exponential
