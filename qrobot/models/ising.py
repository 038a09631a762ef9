"""The same energies in spins, under both sign conventions; the one place that converts.

The paper and dimod write x = (1 + s) / 2: spin +1 is x = 1. Gate machines measure Pauli Z,
which is +1 on the state 0 that stands for x = 0: x = (1 - z) / 2, so z = -s. Couplings are
the same under both, fields change their sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints

__all__ = ["Convention", "Ising", "ising_of", "to_ising"]

Convention = Literal["annealer", "gate"]


@dataclass(frozen=True, eq=False)
class Ising:
    """offset + sum of h[i] s[i] + sum of J[k] s[rows[k]] s[columns[k]], s in {-1, +1}.

    Parameters
    ----------
    h
        Fields, shape (N,).
    rows, columns, J
        Couplings, each pair once, shape (couplings,).
    offset
        The constant.
    labels
        Names of the variables.
    convention
        ``annealer``: spin +1 is x = 1. ``gate``: spin +1 (Z on state 0) is x = 0.
    """

    h: Floats
    rows: Ints
    columns: Ints
    J: Floats
    offset: float
    labels: tuple[str, ...]
    convention: Convention

    def energies(self, spins: npt.NDArray[np.integer]) -> Floats:
        """Return the energies of assignments, shape (..., N) of -1 and +1."""
        pairs = spins[..., self.rows] * spins[..., self.columns]
        return np.asarray(self.offset + spins @ self.h + pairs @ self.J, dtype=np.float64)

    def binaries(self, spins: npt.NDArray[np.integer]) -> npt.NDArray[np.int8]:
        """Return the 0/1 values that spins stand for."""
        sign = 1 if self.convention == "annealer" else -1
        return ((1 + sign * spins) // 2).astype(np.int8)

    def flipped(self) -> Ising:
        """Return the same energies under the other convention."""
        other: Convention = "gate" if self.convention == "annealer" else "annealer"
        return Ising(-self.h, self.rows, self.columns, self.J, self.offset, self.labels, other)


def to_ising(bqm: dimod.BinaryQuadraticModel, convention: Convention = "annealer") -> Ising:
    """Return the Ising form of a binary quadratic model.

    Parameters
    ----------
    bqm
        Binary or spin.
    convention
        Of the spins.
    """
    labels = list(bqm.variables)
    vectors = bqm.binary.to_numpy_vectors(variable_order=labels)
    linear, (rows, columns, quadratic), offset = vectors
    names = tuple(str(label) for label in labels)
    return ising_of(linear, rows, columns, quadratic, offset, labels=names, convention=convention)


def ising_of(
    linear: npt.ArrayLike,
    rows: npt.ArrayLike,
    columns: npt.ArrayLike,
    quadratic: npt.ArrayLike,
    offset: float,
    *,
    labels: tuple[str, ...] = (),
    convention: Convention = "annealer",
) -> Ising:
    """Return the Ising form of binary coefficients: (N,) linear ones, and each pair once."""
    first, second = np.asarray(rows, dtype=np.int64), np.asarray(columns, dtype=np.int64)
    quarter = np.asarray(quadratic, dtype=np.float64) / 4
    h = np.asarray(linear, dtype=np.float64) / 2
    constant = float(offset) + float(h.sum()) + float(quarter.sum())
    np.add.at(h, first, quarter)
    np.add.at(h, second, quarter)
    annealer = Ising(h, first, second, quarter, constant, labels, "annealer")
    return annealer if convention == "annealer" else annealer.flipped()
