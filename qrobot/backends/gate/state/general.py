"""Any circuit by numpy alone: what the SDKs are held against, and a path that needs none.

The state is an array of 2**n amplitudes; bit k of an index is qubit k.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable

import numpy as np

from qrobot._arrays import Floats, States
from qrobot.backends.gate import resources
from qrobot.backends.gate.circuit import Circuit, Gate

__all__ = ["gradient", "state"]

Parts = list[States]
"""Views of a state, one for each value of a gate's qubits, where its controls hold."""


def state(circuit: Circuit, angles: Iterable[float] = ()) -> States:
    """Return the state that a circuit makes, shape (2**qubits,).

    Parameters
    ----------
    circuit
        What to apply to |0..0>.
    angles
        One a rotation whose angle is searched.

    Raises
    ------
    BackendError
        When the state does not fit into memory.
    """
    what = f"the state of a circuit of {circuit.qubits} qubits"
    resources.require(40 << circuit.qubits, what, qubits=circuit.qubits)
    found = np.zeros(2**circuit.qubits, dtype=np.complex128)
    found[0] = 1.0
    for gate, angle in circuit.turned(angles):
        _apply(found, gate, float(angle))
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
        angle = gate.angle
        if gate.slot >= 0:
            at -= 1
            angle = float(angles[at])
            # d/dangle of exp(-i angle P / 2) is -i P / 2 times it, and both commute.
            slopes[at] = _generator(_parts(left, gate), _parts(right, gate), gate.name).imag
        _apply(right, gate, -angle)
        _apply(left, gate, -angle)
    return value, slopes


def _parts(state: States, gate: Gate) -> Parts:
    """Return the views of a state by the values of a gate's qubits: 0, 1 or 00, 01, 10, 11."""
    shape: list[int] = []
    axis: dict[int, int] = {}
    above = state.size.bit_length() - 1
    for qubit in sorted((*gate.qubits, *gate.controls), reverse=True):
        axis[qubit] = len(shape) + 1
        shape += [1 << (above - 1 - qubit), 2]
        above = qubit
    view = state.reshape(*shape, 1 << above)
    where: list[int | slice] = [slice(None)] * view.ndim
    for qubit, value in zip(gate.controls, gate.control_values, strict=True):
        where[axis[qubit]] = value
    parts = []
    for bits in range(1 << len(gate.qubits)):
        for k, qubit in enumerate(reversed(gate.qubits)):
            where[axis[qubit]] = bits >> k & 1
        parts.append(view[tuple(where)])
    return parts


def _apply(state: States, gate: Gate, angle: float) -> None:
    """Apply one gate in place."""
    parts = _parts(state, gate)
    if gate.name == "swap":
        _, zero, one, _ = parts
        held = zero.copy()
        zero[...] = one
        one[...] = held
    elif (factors := _diagonal(gate.name, angle)) is not None:
        for part, factor in zip(parts, factors, strict=True):
            if factor != 1:
                np.multiply(part, factor, out=part)
    else:
        zero, one = parts
        (a, b), (c, d) = _matrix(gate.name, angle)
        held = zero.copy()
        zero *= a
        zero += b * one
        one *= d
        one += c * held


def _diagonal(name: str, angle: float) -> tuple[complex, ...] | None:
    """Return the factor of each part, or ``None`` for gates that are not diagonal."""
    if name == "rz":
        return cmath.exp(-0.5j * angle), cmath.exp(0.5j * angle)
    if name == "phase":
        return 1, cmath.exp(1j * angle)
    if name == "rzz":
        same, other = cmath.exp(-0.5j * angle), cmath.exp(0.5j * angle)
        return same, other, other, same
    return (1, 1, 1, -1) if name == "cz" else None


def _matrix(name: str, angle: float) -> tuple[tuple[complex, complex], tuple[complex, complex]]:
    cosine, sine = math.cos(angle / 2), math.sin(angle / 2)
    root = math.sqrt(0.5)
    return {
        "x": ((0, 1), (1, 0)),
        "h": ((root, root), (root, -root)),
        "rx": ((cosine, -1j * sine), (-1j * sine, cosine)),
        "ry": ((cosine, -sine), (sine, cosine)),
    }[name]


def _generator(left: Parts, right: Parts, name: str) -> complex:
    """Return <left| P |right>, P what the rotation turns about (for ``phase``: -2 |1><1|)."""

    def product(a: int, b: int) -> complex:
        return complex((left[a].conj() * right[b]).sum())

    if name == "rx":
        return product(0, 1) + product(1, 0)
    if name == "ry":
        return -1j * product(0, 1) + 1j * product(1, 0)
    if name == "rz":
        return product(0, 0) - product(1, 1)
    if name == "phase":
        return -2 * product(1, 1)
    return product(0, 0) - product(1, 1) - product(2, 2) + product(3, 3)
