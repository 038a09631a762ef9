"""The circuits by numpy alone: what the SDKs are held against, and a path that needs none.

The state is an array of 2**n amplitudes; bit k of an index is qubit k.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qrobot.backends.variational.circuit import Circuit, Gate

__all__ = ["gradient", "state"]

Floats = npt.NDArray[np.float64]
State = npt.NDArray[np.complex128]


def state(circuit: Circuit, angles: Floats) -> State:
    """Return the state that a circuit makes, shape (2**qubits,)."""
    found = np.zeros(2**circuit.qubits, dtype=np.complex128)
    found[0] = 1.0
    for gate, angle in circuit.turned(angles):
        _apply(found, gate, angle)
    return found


def gradient(circuit: Circuit, angles: Floats, weights: Floats) -> tuple[float, Floats]:
    """Return the mean of a diagonal observable and its derivatives by the angles.

    Adjoint differentiation: T. Jones and J. Gacon, arXiv:2009.02823 (2020).

    Parameters
    ----------
    circuit, angles
        The state; one angle a rotation.
    weights
        Diagonal of the observable, shape (2**qubits,).
    """
    right = state(circuit, angles)
    left = weights * right
    value = float(np.vdot(right, left).real)
    slopes, at = np.empty(angles.size), angles.size
    for gate in reversed(circuit.gates):
        if gate.slot >= 0:
            at -= 1
            # d/dangle of exp(-i angle P / 2) is -i P / 2 times it, and both commute.
            slopes[at] = float(np.vdot(left, _generator(right, gate)).imag)
        angle = -float(angles[at]) if gate.slot >= 0 else 0.0
        _apply(right, gate, angle)
        _apply(left, gate, angle)
    return value, slopes


def _apply(state: State, gate: Gate, angle: float) -> None:
    """Apply one gate in place."""
    low = min(gate.qubits)
    if gate.name in ("rzz", "cz"):
        high = max(gate.qubits)
        view = state.reshape(-1, 2, 2 ** (high - low - 1), 2, 2**low)
        if gate.name == "cz":
            view[:, 1, :, 1] *= -1
            return
        same, other = np.exp(-0.5j * angle), np.exp(0.5j * angle)
        view[:, 0, :, 0] *= same
        view[:, 1, :, 1] *= same
        view[:, 0, :, 1] *= other
        view[:, 1, :, 0] *= other
        return
    view = state.reshape(-1, 2, 2**low)
    if gate.name == "rz":
        view[:, 0] *= np.exp(-0.5j * angle)
        view[:, 1] *= np.exp(0.5j * angle)
        return
    zero, one = view[:, 0].copy(), view[:, 1].copy()
    (a, b), (c, d) = _matrix(gate.name, angle)
    view[:, 0] = a * zero + b * one
    view[:, 1] = c * zero + d * one


def _matrix(name: str, angle: float) -> tuple[tuple[complex, complex], tuple[complex, complex]]:
    if name == "h":
        root = np.sqrt(0.5)
        return (root, root), (root, -root)
    cosine, sine = np.cos(angle / 2), np.sin(angle / 2)
    if name == "rx":
        return (cosine, -1j * sine), (-1j * sine, cosine)
    return (cosine, -sine), (sine, cosine)


def _generator(state: State, gate: Gate) -> State:
    """Return P times the state, P the Pauli word of a rotation."""
    found = state.copy()
    low = min(gate.qubits)
    if gate.name == "rzz":
        view = found.reshape(-1, 2, 2 ** (max(gate.qubits) - low - 1), 2, 2**low)
        view[:, 0, :, 1] *= -1
        view[:, 1, :, 0] *= -1
        return found
    view = found.reshape(-1, 2, 2**low)
    if gate.name == "rz":
        view[:, 1] *= -1
        return found
    view[:] = view[:, ::-1].copy()
    if gate.name == "ry":
        view[:, 0] *= -1j
        view[:, 1] *= 1j
    return found
