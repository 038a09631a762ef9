"""What simulates a layer: compiled code, or numpy where numba is absent."""

from __future__ import annotations

from typing import Protocol

from qrobot import _jit as jit
from qrobot._arrays import Floats, Reals
from qrobot._extras import missing
from qrobot._machine import usable_cores
from qrobot.errors import InputError

__all__ = ["ENGINES", "Engine", "Floats", "Reals", "make_engine", "thread_count"]


ENGINES = ("auto", "numba", "numpy")

SMALL = 16
"""From so many qubits on, ``auto`` takes numba: a layer takes numpy milliseconds below, importing
numba takes seconds."""


class Engine(Protocol):
    """Layers and sums on a state of 2**n amplitudes, kept as real and imaginary parts.

    One layer is exp(-i beta (X_0 + .. + X_(n-1))) exp(-i gamma D) with the diagonal D; index
    bit k belongs to qubit k.
    """

    name: str

    def begin(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        """Set the state to one layer applied to the uniform superposition."""
        ...

    def layer(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        """Apply one layer."""
        ...

    def undo(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        """Apply the inverse of one layer."""
        ...

    def overlap(self, lr: Reals, li: Reals, re: Reals, im: Reals) -> float:
        """Return the imaginary part of <l| X_0 + .. + X_(n-1) |state>."""
        ...

    def moments(self, re: Reals, im: Reals, diagonal: Reals) -> tuple[float, float]:
        """Return the sums of probability, and of probability times D."""
        ...

    def histogram(
        self, re: Reals, im: Reals, diagonal: Reals, lowest: float, width: float, bins: int
    ) -> tuple[Floats, Floats]:
        """Return probability, and probability times D, in bins of D that start at `lowest`."""
        ...


def thread_count(threads: int | None) -> int:
    """Return a number of threads: ``None`` takes what this process may use.

    Raises
    ------
    InputError
        When the number is not positive.
    """
    if threads is None:
        return usable_cores()
    if threads < 1:
        raise InputError(f"{threads} threads are too few", field="threads", advice="use 1 or more")
    return threads


def make_engine(name: str = "auto", threads: int | None = 1, qubits: int = 64) -> Engine:
    """Return an engine by name.

    Parameters
    ----------
    name
        ``numba``, ``numpy``, or ``auto``: numba where it is installed and worth its import.
    threads
        Of the compiled engine; numpy's matrix products use as many as its library likes.
    qubits
        What it is for: small states are done before numba is imported.

    Raises
    ------
    InputError
        When no engine has that name.
    MissingExtraError
        When numba is asked for and absent.
    """
    if name not in ENGINES:
        raise InputError(
            f"{name!r} is not an engine", field="engine", advice=f"use one of: {', '.join(ENGINES)}"
        )
    count = thread_count(threads)
    if name == "numba" and not jit.available():
        raise missing("engine numba", "numba")
    if name == "numba" or (name == "auto" and qubits >= SMALL and jit.available()):
        from qrobot.backends.gate.state.compiled import CompiledEngine

        return CompiledEngine(count)
    from qrobot.backends.gate.state.plain import PlainEngine

    return PlainEngine()
