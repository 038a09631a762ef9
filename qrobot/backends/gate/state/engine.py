"""What simulates a layer: compiled code, or numpy where numba is absent.

Numpy takes the mixers of five qubits at a time as real matrix products.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Protocol

import numpy as np
import numpy.typing as npt

from qrobot import _jit as jit
from qrobot._arrays import Floats, Reals
from qrobot._extras import missing
from qrobot._machine import usable_cores
from qrobot.errors import InputError

__all__ = ["LayerEngine", "make_engine", "thread_count"]


ENGINES = ("auto", "numba", "numpy")

SMALL = 16
"""From so many qubits on, ``auto`` takes numba: a layer takes numpy milliseconds below, importing
numba takes seconds."""


class LayerEngine(Protocol):
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


def make_engine(name: str = "auto", threads: int | None = 1, qubits: int = 64) -> LayerEngine:
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
    return _NumpyEngine()


GROUP = 5
"""Qubits of one matrix product (32 x 32): few passes, little arithmetic."""

CHUNK = 1 << 16
"""Amplitudes a piece, so that temporary arrays stay within the cache."""

COLUMNS = 256
"""Columns of one matrix product: small enough that the library uses one thread. Many small
products on several threads wait for each other, ten times longer on a busy machine."""


class _NumpyEngine:
    """Layers in numpy; its linear algebra library decides on threads."""

    name = "numpy"

    def begin(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        re.fill(re.size**-0.5)
        im.fill(0)
        self.layer(re, im, diagonal, gamma, beta)

    def layer(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        _phase(re, im, diagonal, gamma)
        _mix(re, im, beta)

    def undo(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        _mix(re, im, -beta)
        _phase(re, im, diagonal, -gamma)

    def overlap(self, lr: Reals, li: Reals, re: Reals, im: Reals) -> float:
        parts = []
        for q in range(re.size.bit_length() - 1):
            a, b, x, y = (one.reshape(-1, 2, 1 << q) for one in (lr, li, re, im))
            for mine, other in ((0, 1), (1, 0)):
                parts.append(_dot(a[:, mine], y[:, other]) - _dot(b[:, mine], x[:, other]))
        return math.fsum(parts)

    def moments(self, re: Reals, im: Reals, diagonal: Reals) -> tuple[float, float]:
        mass, energy = [], []
        for piece in _pieces(re.size):
            p = _probability(re[piece], im[piece])
            mass.append(float(p.sum()))
            energy.append(float((p * diagonal[piece].astype(np.float64)).sum()))
        return math.fsum(mass), math.fsum(energy)

    def histogram(
        self, re: Reals, im: Reals, diagonal: Reals, lowest: float, width: float, bins: int
    ) -> tuple[Floats, Floats]:
        mass, energy = np.zeros(bins), np.zeros(bins)
        for piece in _pieces(re.size):
            p, e = _probability(re[piece], im[piece]), diagonal[piece].astype(np.float64)
            k = np.clip(((e - lowest) * (1.0 / width)).astype(np.intp), 0, bins - 1)
            mass += np.bincount(k, p, bins)
            energy += np.bincount(k, p * e, bins)
        return mass, energy


def _pieces(size: int) -> list[slice]:
    return [slice(start, start + CHUNK) for start in range(0, size, CHUNK)]


def _probability(re: Reals, im: Reals) -> Floats:
    p: Floats = re.astype(np.float64) ** 2
    p += im.astype(np.float64) ** 2
    return p


def _dot(a: Reals, b: Reals) -> float:
    return float(np.einsum("ij,ij->", a, b, dtype=np.float64))


def _phase(re: Reals, im: Reals, diagonal: Reals, gamma: float) -> None:
    for piece in _pieces(re.size):
        angle = diagonal[piece] * re.dtype.type(gamma)
        c, s = np.cos(angle), np.sin(angle)
        r, i = re[piece].copy(), im[piece]
        re[piece] = r * c + i * s
        im[piece] = i * c - r * s


def _mix(re: Reals, im: Reals, beta: float) -> None:
    qubits, offset = re.size.bit_length() - 1, 0
    while offset < qubits:
        bits = min(GROUP, qubits - offset)
        even, odd = _matrices(bits, beta, re)
        if offset == 0:  # the group's index is the last axis: the matrices (symmetric) go right
            shape = (-1, min(COLUMNS, re.size >> bits), 1 << bits)
            for r, i in _parts(re.reshape(shape), im.reshape(shape)):
                r[...], i[...] = r @ even + i @ odd, i @ even - r @ odd
        else:
            shape = (-1, 1 << bits, 1 << offset)
            for r, i in _parts(re.reshape(shape), im.reshape(shape)):
                r[...], i[...] = even @ r + odd @ i, even @ i - odd @ r
        offset += bits


def _parts(re: Reals, im: Reals) -> Iterator[tuple[Reals, Reals]]:
    """Yield views of three axes that together hold all amplitudes, CHUNK of them or fewer."""
    columns = min(COLUMNS, re.shape[2])
    rows = max(1, CHUNK // (re.shape[1] * columns))
    for a in range(0, re.shape[0], rows):
        for b in range(0, re.shape[2], columns):
            yield re[a : a + rows, :, b : b + columns], im[a : a + rows, :, b : b + columns]


def _matrices(bits: int, beta: float, like: Reals) -> tuple[Reals, Reals]:
    """Return A and B with (cos beta I - i sin beta X) to the power of `bits` = A - i B."""
    one = np.array([[math.cos(beta), 0], [0, math.cos(beta)]], dtype=np.complex128)
    one -= 1j * math.sin(beta) * np.array([[0, 1], [1, 0]])
    whole: npt.NDArray[np.complex128] = np.ones((1, 1), dtype=np.complex128)
    for _ in range(bits):
        whole = np.kron(whole, one).astype(np.complex128)
    return whole.real.astype(like.dtype), (-whole.imag).astype(like.dtype)
