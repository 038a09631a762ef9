"""A circuit as a plain list of gates, independent of any SDK, and its state.

The ansatz circuits are built once, here, and translated to Qiskit and Braket by
`circuits_qiskit` and `circuits_braket`. Qubit k is bit k of an index (the lowest bit is qubit 0).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from qrobot.backends.gates import memory

__all__ = ["Gate", "Program", "two_level"]

ROTATIONS = ("rx", "ry", "rz", "phase")
NAMES = ("x", "h", "swap", *ROTATIONS)


@dataclass(frozen=True, slots=True)
class Gate:
    """One gate.

    Parameters
    ----------
    name
        ``x``, ``h``, ``swap``, ``rx``, ``ry``, ``rz`` (each exp(-i angle / 2 ..)) or ``phase``
        (diag(1, exp(i angle))).
    targets
        One qubit, two for ``swap``.
    angle
        Of a rotation.
    controls, values
        The gate acts where each control qubit has its value; no values: all 1.
    """

    name: str
    targets: tuple[int, ...]
    angle: float = 0.0
    controls: tuple[int, ...] = ()
    values: tuple[int, ...] = ()

    @property
    def control_values(self) -> tuple[int, ...]:
        """Value of each control qubit."""
        return self.values or (1,) * len(self.controls)

    def inverse(self) -> Gate:
        """Return the gate that undoes this one."""
        return replace(self, angle=-self.angle)


@dataclass(slots=True)
class Program:
    """Gates on labelled qubits, beginning in |0..0>.

    Parameters
    ----------
    labels
        What each qubit stands for: a variable of the model, or ``ancilla``.
    gates
        In sequence.
    """

    labels: tuple[str, ...]
    gates: list[Gate] = field(default_factory=list)

    @property
    def qubits(self) -> int:
        """Number of qubits."""
        return len(self.labels)

    def add(
        self, name: str, *targets: int, angle: float = 0.0, controls: Sequence[int] = ()
    ) -> None:
        """Append a gate whose controls must all be 1."""
        self.gates.append(Gate(name, targets, angle, tuple(controls)))

    def extend(self, gates: Iterable[Gate]) -> None:
        """Append gates."""
        self.gates.extend(gates)

    def index(self, ones: Iterable[str]) -> int:
        """Return the index of the basis state in which exactly these labels are 1."""
        at = {label: k for k, label in enumerate(self.labels)}
        return sum(1 << at[label] for label in ones)

    def state(self) -> npt.NDArray[np.complex128]:
        """Return the state by applying every gate, shape (2**qubits,)."""
        what = f"the state of a circuit of {self.qubits} qubits"
        memory.require(40 << self.qubits, what, qubits=self.qubits)
        state = np.zeros(1 << self.qubits, dtype=np.complex128)
        state[0] = 1.0
        shaped = state.reshape((2,) * self.qubits)  # axis 0 is the highest qubit
        for gate in self.gates:
            self._apply(shaped, gate)
        return state

    def _apply(self, shaped: npt.NDArray[np.complex128], gate: Gate) -> None:
        where: list[int | slice] = [slice(None)] * self.qubits
        for qubit, value in zip(gate.controls, gate.control_values, strict=True):
            where[self.qubits - 1 - qubit] = value

        def part(*bits: int) -> tuple[int | slice, ...]:
            chosen = list(where)
            for qubit, bit in zip(gate.targets, bits, strict=True):
                chosen[self.qubits - 1 - qubit] = bit
            return tuple(chosen)

        if gate.name == "swap":
            a, b = part(0, 1), part(1, 0)
            held = shaped[a].copy()
            shaped[a] = shaped[b]
            shaped[b] = held
            return
        zero, one = part(0), part(1)
        m = _matrix(gate)
        first, second = np.copy(shaped[zero]), np.copy(shaped[one])
        shaped[zero] = m[0][0] * first + m[0][1] * second
        shaped[one] = m[1][0] * first + m[1][1] * second


def _matrix(gate: Gate) -> tuple[tuple[complex, complex], tuple[complex, complex]]:
    c, s = math.cos(gate.angle / 2), math.sin(gate.angle / 2)
    if gate.name == "x":
        return (0, 1), (1, 0)
    if gate.name == "h":
        r = math.sqrt(0.5)
        return (r, r), (r, -r)
    if gate.name == "rx":
        return (c, -1j * s), (-1j * s, c)
    if gate.name == "ry":
        return (c, -s), (s, c)
    if gate.name == "rz":
        return (c - 1j * s, 0), (0, c + 1j * s)
    return (1, 0), (0, cmath.exp(1j * gate.angle))


def two_level(a: Mapping[int, int], b: Mapping[int, int], name: str, angle: float) -> list[Gate]:
    """Return gates that rotate between two basis states and leave all others alone.

    Parameters
    ----------
    a, b
        Value of each qubit; they differ somewhere. The rotation sees `a` as |0>, `b` as |1>.
    name, angle
        The rotation: ``rx`` or ``ry``.
    """
    differ = [q for q in a if a[q] != b[q]]
    pivot, rest = differ[0], differ[1:]
    # Where the pivot is as in b, flip the rest: b then differs from a in the pivot alone.
    flips = [Gate("x", (q,), controls=(pivot,), values=(b[pivot],)) for q in rest]
    others = tuple(q for q in a if q != pivot)
    if name == "ry" and a[pivot] == 1:
        angle = -angle
    turn = Gate(name, (pivot,), angle, others, tuple(a[q] for q in others))
    return [*flips, turn, *reversed(flips)]
