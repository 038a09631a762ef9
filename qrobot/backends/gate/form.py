"""A binary quadratic model as arrays, its Ising form, and its energies on all assignments.

Bit value 1 is state |1>, and Z is +1 on |0>: the binary variable is x = (1 - z) / 2.
`qrobot.models.ising` converts. `terms` gives the Ising form as the list of Z words that every
SDK makes its operator of.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.backends.gate.resources import aligned
from qrobot.backends.sampler import check_finite
from qrobot.models.ising import ising_of, to_ising

__all__ = ["Form", "Term", "below", "bits_of", "diagonal", "tail", "terms"]


LOW_BITS = 15
"""Qubits of one block of the diagonal: its energies stay within the cache."""


@dataclass(frozen=True, eq=False)
class Form:
    """offset + sum of linear[i] x_i + sum over i < j of quadratic[i, j] x_i x_j, x in {0, 1}.

    Parameters
    ----------
    variables
        Labels; variable k is qubit k, bit k of an index (the lowest bit is qubit 0).
    linear
        Shape (n,).
    quadratic
        Shape (n, n), zero on and below the main diagonal.
    offset
        Constant.
    """

    variables: tuple[Hashable, ...]
    linear: Floats
    quadratic: Floats
    offset: float

    @classmethod
    def from_bqm(cls, bqm: Any) -> Form:
        """Return the arrays of a dimod model of any vartype.

        Raises
        ------
        InputError
            When a coefficient is NaN or infinite.
        """
        check_finite(bqm)
        variables = tuple(bqm.variables)
        binary = bqm if bqm.vartype is dimod.BINARY else bqm.change_vartype("BINARY", inplace=False)
        linear, (rows, columns, values), offset = binary.to_numpy_vectors(variables)
        quadratic = np.zeros((len(variables), len(variables)))
        np.add.at(quadratic, (np.minimum(rows, columns), np.maximum(rows, columns)), values)
        return cls(variables, np.asarray(linear, dtype=np.float64), quadratic, float(offset))

    @property
    def qubits(self) -> int:
        """Number of variables."""
        return len(self.variables)

    @cached_property
    def ising(self) -> tuple[Floats, Floats, float]:
        """Fields h (n,), couplings J (n, n, symmetric) and constant of the form in Z."""
        rows, columns = np.nonzero(self.quadratic)
        values = self.quadratic[rows, columns]
        gate = ising_of(self.linear, rows, columns, values, self.offset, convention="gate")
        J = np.zeros_like(self.quadratic)
        J[rows, columns] = J[columns, rows] = gate.J
        return gate.h, J, gate.offset

    @cached_property
    def mean(self) -> float:
        """Mean energy of all assignments."""
        return self.ising[2]

    @cached_property
    def spread(self) -> float:
        """Standard deviation of the energy over all assignments: the natural unit of 1 / gamma."""
        h, J, _ = self.ising
        return float(np.sqrt((h**2).sum() + (J**2).sum() / 2))

    def energies(self, samples: npt.NDArray[Any]) -> Floats:
        """Return the energies of samples of shape (count, n), entries 0 and 1."""
        x = samples.astype(np.float64)
        found: Floats = self.offset + x @ self.linear + ((x @ self.quadratic) * x).sum(axis=1)
        return found


def bits_of(indices: npt.ArrayLike, qubits: int) -> npt.NDArray[np.int8]:
    """Return the samples that indices of basis states stand for, shape (count, qubits)."""
    wide = np.asarray(indices, dtype=np.uint64)[:, None]
    found: npt.NDArray[np.int8] = (
        (wide >> np.arange(qubits, dtype=np.uint64)) & np.uint64(1)
    ).astype(np.int8)
    return found


def diagonal(form: Form, dtype: npt.DTypeLike = np.float64, shift: float = 0.0) -> npt.NDArray[Any]:
    """Return the energies of all assignments, less `shift`: shape (2**n,).

    Each variable doubles what is known: the energies with it are those without it plus its
    field. High and low variables are separated, so that float64 blocks within the cache are
    made, shifted and only then rounded to `dtype`.
    """
    low = min(form.qubits, LOW_BITS)
    Q = form.quadratic
    inner = _doubled(0.0, form.linear[:low], Q[:low, :low])
    outer = _doubled(form.offset - shift, form.linear[low:], Q[low:, low:])
    high_bits = bits_of(np.arange(outer.size), form.qubits - low)
    fields = high_bits.astype(np.float64) @ Q[:low, low:].T
    found = aligned(outer.size * inner.size, dtype).reshape(outer.size, inner.size)
    block = np.empty(inner.size)
    for row, (base, field) in enumerate(zip(outer, fields, strict=True)):
        block[0] = base
        for k in range(low):
            np.add(block[: 1 << k], field[k], out=block[1 << k : 2 << k])
        np.add(block, inner, out=found[row], casting="same_kind")
    return found.reshape(-1)


def _doubled(offset: float, linear: Floats, quadratic: Floats) -> Floats:
    energies = np.empty(1 << len(linear))
    energies[0] = offset
    for k, own in enumerate(linear):
        upper = energies[1 << k : 2 << k]
        upper[0] = own  # the field on variable k, doubled over the variables below it ...
        for j in range(k):
            np.add(upper[: 1 << j], quadratic[j, k], out=upper[1 << j : 2 << j])
        upper += energies[: 1 << k]  # ... and the energy without it
    return energies


class Term(NamedTuple):
    """A coefficient times the product of Z over some qubits (none: the constant)."""

    coefficient: float
    qubits: tuple[int, ...]


def terms(bqm: Any) -> list[Term]:
    """Return the Ising form of a dimod model of any vartype; qubit k is the k-th variable.

    Returns
    -------
    list of Term
        The constant (always, and first), then fields, then couplings; zeros are left out.

    Raises
    ------
    InputError
        When a coefficient is NaN or infinite.
    """
    check_finite(bqm)
    gate = to_ising(bqm, "gate")
    found = [Term(float(gate.offset), ())]
    found += [Term(float(h), (i,)) for i, h in enumerate(gate.h) if h]
    pairs = zip(gate.rows, gate.columns, gate.J, strict=True)
    found += [Term(float(J), (min(int(i), int(j)), max(int(i), int(j)))) for i, j, J in pairs if J]
    return found


def tail(energies: Floats, probabilities: Floats, alpha: float) -> tuple[float, float]:
    """Return the mean of the lowest `alpha` of a distribution, and the energy where that ends.

    Parameters
    ----------
    energies, probabilities
        Of all states, in the sequence of rising energy.
    alpha
        Share of the distribution.
    """
    upto = np.cumsum(probabilities)
    share = alpha * float(upto[-1])
    cut = min(int(np.searchsorted(upto, share)), upto.size - 1)
    before = float(upto[cut - 1]) if cut else 0.0
    end = float(energies[cut])
    return (float(probabilities[:cut] @ energies[:cut]) + (share - before) * end) / share, end


def below(energies: Floats, end: float, alpha: float) -> Floats:
    """Return the diagonal whose mean has value and derivatives of the tail that ends at `end`.

    The tail's mean is the maximum over t of t - <(t - E)+> / alpha (R. T. Rockafellar and
    S. Uryasev, Journal of Risk 2 (2000) 21), so at a fixed distribution its slope is that with t
    held.
    """
    found: Floats = end + np.minimum(energies - end, 0.0) / alpha
    return found
