"""Circuits as plain data: one description that every SDK's translator reads.

A rotation is exp(-i angle P / 2) with P one of X, Y, Z or ZZ, and its angle is
``scale * parameters[slot]``: several rotations may share a parameter. Qubit k is variable k.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

__all__ = ["ENTANGLERS", "FIXED", "ROTATIONS", "Circuit", "Gate"]

Floats = npt.NDArray[np.float64]

ROTATIONS = ("rx", "ry", "rz", "rzz")
FIXED = ("h", "cz")
ENTANGLERS = ("rzz", "cz")


@dataclass(frozen=True, slots=True)
class Gate:
    """One gate.

    Parameters
    ----------
    name
        One of `ROTATIONS` or `FIXED`.
    qubits
        What it acts on: two for `ENTANGLERS`, else one.
    slot, scale
        Of a rotation: which parameter it turns by, and times what.
    """

    name: str
    qubits: tuple[int, ...]
    slot: int = -1
    scale: float = 1.0


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
    """

    qubits: int
    gates: tuple[Gate, ...]
    size: int

    @cached_property
    def rotations(self) -> tuple[Gate, ...]:
        """The gates that turn by an angle, in sequence: angle k belongs to rotation k."""
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

    def turned(self, angles: Floats) -> Iterator[tuple[Gate, float]]:
        """Yield each gate with its angle (0 for those that have none)."""
        left = iter(angles)
        for gate in self.gates:
            yield gate, float(next(left)) if gate.slot >= 0 else 0.0

    def pull_back(self, by_angle: Floats) -> Floats:
        """Return derivatives by parameter from derivatives by angle, shape (size,)."""
        slots, scales = self._map
        found = np.zeros(self.size)
        np.add.at(found, slots, by_angle * scales)
        return found
