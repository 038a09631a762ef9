"""The Ising form of a model as a list of Z words: what every SDK's operator is made of.

The sign conventions of annealers and gate computers are converted in one place,
`qrobot.models.ising`; here z = +1 on state 0, which stands for x = 0.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from qrobot.backends.sampler import check_finite
from qrobot.models.ising import to_ising

__all__ = ["Term", "terms"]


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
