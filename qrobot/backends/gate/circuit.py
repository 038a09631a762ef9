"""Circuits as plain data: one description that every SDK's translator reads.

Rotations are exp(-i angle P / 2) with P one of X, Y, Z or ZZ; ``phase`` is diag(1, exp(i angle)).
An angle is fixed, or ``scale * parameters[slot]``: several gates may share a parameter. Qubit k is
variable k, and bit k of a state's index.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats

__all__ = ["TURNING", "Circuit", "Gate"]


TURNING = ("rx", "ry", "rz", "rzz", "phase")
"""Gates that take an angle; ``h``, ``x``, ``cz`` and ``swap`` take none."""


@dataclass(frozen=True, slots=True)
class Gate:
    """One gate.

    Parameters
    ----------
    name
        One of `TURNING`, or ``h``, ``x``, ``cz``, ``swap``.
    qubits
        What it acts on: two for ``rzz``, ``cz`` and ``swap``, else one.
    slot, scale
        Of an angle that is searched: which parameter it turns by, and times what.
    angle
        Of a turn that is fixed (``slot`` is -1), in radians.
    controls, values
        The gate acts where each control qubit has its value; no values: all 1.
    """

    name: str
    qubits: tuple[int, ...]
    slot: int = -1
    scale: float = 1.0
    angle: float = 0.0
    controls: tuple[int, ...] = ()
    values: tuple[int, ...] = ()

    @property
    def control_values(self) -> tuple[int, ...]:
        """Value of each control qubit."""
        return self.values or (1,) * len(self.controls)

    def inverse(self) -> Gate:
        """Return the gate that undoes this one."""
        return self.times(-1.0)

    def times(self, factor: float) -> Gate:
        """Return the same gate with its angle times a factor."""
        return replace(self, angle=self.angle * factor, scale=self.scale * factor)


@dataclass(frozen=True, eq=False)
class Circuit:
    """Gates in sequence on qubits that start in |0>.

    Parameters
    ----------
    qubits
        Number of qubits.
    gates
        In sequence.
    size
        Number of parameters.
    labels
        What each qubit stands for: a variable of the model, or ``ancilla``; may be left out.
    """

    qubits: int
    gates: tuple[Gate, ...]
    size: int = 0
    labels: tuple[str, ...] = ()

    @cached_property
    def rotations(self) -> tuple[Gate, ...]:
        """The gates whose angle is searched, in sequence: angle k belongs to rotation k."""
        return tuple(gate for gate in self.gates if gate.slot >= 0)

    @cached_property
    def _map(self) -> tuple[npt.NDArray[np.intp], Floats]:
        slots = np.array([gate.slot for gate in self.rotations], dtype=np.intp)
        return slots, np.array([gate.scale for gate in self.rotations], dtype=np.float64)

    def angles(self, parameters: Floats) -> Floats:
        """Return the angle of each rotation, shape (rotations,)."""
        slots, scales = self._map
        found: Floats = parameters[slots] * scales
        return found

    def turned(self, angles: Iterable[float] = ()) -> Iterator[tuple[Gate, float]]:
        """Yield each gate with its angle (0 for those that have none)."""
        left = iter(angles)
        for gate in self.gates:
            yield gate, next(left) if gate.slot >= 0 else gate.angle

    def pull_back(self, by_angle: Floats) -> Floats:
        """Return derivatives by parameter from derivatives by angle, shape (size,)."""
        slots, scales = self._map
        found = np.zeros(self.size)
        np.add.at(found, slots, by_angle * scales)
        return found

    def index(self, ones: Iterable[str]) -> int:
        """Return the index of the basis state in which exactly these labels are 1."""
        at = {label: k for k, label in enumerate(self.labels)}
        return sum(1 << at[label] for label in ones)
