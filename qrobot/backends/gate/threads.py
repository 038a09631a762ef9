"""How many threads small states may use.

Threads of OpenMP and BLAS wait for each other by spinning: on a busy machine a state of a few
qubits takes ten times longer on all cores than on one, and gains nothing on an idle one.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

__all__ = ["PARALLEL", "few_threads"]

PARALLEL = 20
"""Qubits from which on more than one thread pays."""


def few_threads(qubits: int) -> AbstractContextManager[object]:
    """Return a context in which numpy, OpenMP and BLAS use one thread for a small state.

    Parameters
    ----------
    qubits
        Of the state; from `PARALLEL` on the libraries decide.
    """
    if qubits >= PARALLEL:
        return nullcontext()
    from threadpoolctl import threadpool_limits

    limited: AbstractContextManager[object] = threadpool_limits(limits=1)
    return limited
