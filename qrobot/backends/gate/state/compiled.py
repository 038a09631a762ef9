"""The engine of compiled kernels: two passes over memory a layer up to 24 qubits."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from qrobot import _jit as jit
from qrobot._arrays import Floats, Reals
from qrobot.backends.gate.resources import pair

__all__ = ["CompiledEngine", "Passes", "passes"]

LOW_BITS = (12, 14)
"""Least and most qubits of the first pass: 64 to 256 KiB of complex128, within an L2 cache."""

HIGH_BITS = 10
"""Most qubits of one further pass."""

TILE_BYTES = 1 << 19
"""Of a tile, both parts: within an L2 cache, and its rows, 256 bytes, are runs of memory."""


@dataclass(frozen=True, slots=True)
class Passes:
    """How a layer goes over memory.

    Parameters
    ----------
    low
        Qubits of the first pass.
    high
        For each further pass its first qubit, its number of qubits and its tile's columns.
    """

    low: int
    high: tuple[tuple[int, int, int], ...]


def passes(qubits: int, itemsize: int = 8) -> Passes:
    """Return how a layer of so many qubits goes over memory; a number takes `itemsize` bytes."""
    tile = (TILE_BYTES // (2 * itemsize)).bit_length() - 1
    low = min(qubits, max(LOW_BITS[0], min(qubits - HIGH_BITS, LOW_BITS[1])))
    count = -(-(qubits - low) // HIGH_BITS)
    high, offset = [], low
    for left in range(count, 0, -1):
        bits = -(-(qubits - offset) // left)
        high.append((offset, bits, 1 << min(offset, tile - bits)))
        offset += bits
    return Passes(low, tuple(high))


def constants(gamma: float, qubits: int, dtype: np.dtype[Any]) -> Reals:
    """Return what the phase kernel needs, in the state's type."""
    magic = 1.5 * 2.0 ** (52 if dtype == np.float64 else 23)
    quarter = math.pi / 2
    sines = [(-1) ** k * quarter ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(8)]
    cosines = [(-1) ** k * quarter ** (2 * k) / math.factorial(2 * k) for k in range(1, 8)]
    head = [gamma / (2 * math.pi), magic, 1.0, 2.0, 2.0 ** (-qubits / 2)]
    return np.array([*head, *sines, *cosines], dtype=dtype)


@cache
def _kernels() -> Any:
    """Import the kernels and compile one, so that a cache without room is found here."""
    kernels = importlib.import_module("qrobot.backends.gate.state.kernels")
    one = np.zeros(2)
    try:
        kernels.moments(one, one, one, 0, 2)
    except OSError:
        jit.caching = False
        kernels = importlib.reload(kernels)
    return kernels


class CompiledEngine:
    """Kernels of `kernels` on plain threads (they release the interpreter's lock).

    Parameters
    ----------
    threads
        Of every pass over at least 2**16 amplitudes.
    """

    name = "numba"

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._kernels = _kernels()
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def begin(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        """Set the state to one layer applied to the uniform superposition."""
        how, k, c, s = self._setting(re, gamma, beta)
        run = self._kernels.first_pass
        self._spread(
            lambda a, b: run(re, im, diagonal, k, c, s, how.low, a, b), re.size >> how.low, re.size
        )
        self._high(re, im, c, s, how)

    def layer(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        """Apply one layer."""
        self._layer(re, im, diagonal, gamma, beta, back=False)

    def undo(self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float) -> None:
        """Apply the inverse of one layer."""
        self._layer(re, im, diagonal, -gamma, -beta, back=True)

    def overlap(self, lr: Reals, li: Reals, re: Reals, im: Reals) -> float:
        """Return the imaginary part of <l| X_0 + .. + X_(n-1) |state>."""
        how, sums = passes(_qubits(re), re.itemsize), self._kernels
        parts = self._spread(
            lambda a, b: sums.low_overlap(lr, li, re, im, how.low, a, b),
            re.size >> how.low,
            re.size,
        )
        for low, bits, width in how.high:

            def part(a: int, b: int, low: int = low, bits: int = bits, width: int = width) -> float:
                found: float = sums.high_overlap(lr, li, re, im, low, bits, width, a, b)
                return found

            parts += self._spread(part, re.size // (width << bits), re.size)
        return math.fsum(parts)

    def moments(self, re: Reals, im: Reals, diagonal: Reals) -> tuple[float, float]:
        """Return the sums of probability, and of probability times D."""
        run = self._kernels.moments
        parts = self._spread(lambda a, b: run(re, im, diagonal, a, b), re.size, re.size)
        return math.fsum(p[0] for p in parts), math.fsum(p[1] for p in parts)

    def histogram(
        self, re: Reals, im: Reals, diagonal: Reals, lowest: float, width: float, bins: int
    ) -> tuple[Floats, Floats]:
        """Return probability, and probability times D, in bins of D that start at `lowest`."""
        run, scale = self._kernels.histogram, 1.0 / width

        def part(a: int, b: int) -> tuple[Floats, Floats]:
            mass, energy = np.zeros(bins), np.zeros(bins)
            run(re, im, diagonal, lowest, scale, mass, energy, a, b)
            return mass, energy

        parts = self._spread(part, re.size, re.size)
        mass: Floats = np.sum([p[0] for p in parts], axis=0)
        energy: Floats = np.sum([p[1] for p in parts], axis=0)
        return mass, energy

    # -- passes ----------------------------------------------------------------------

    def _setting(self, re: Reals, gamma: float, beta: float) -> tuple[Passes, Reals, Any, Any]:
        kind, qubits = re.dtype.type, _qubits(re)
        k = constants(gamma, qubits, re.dtype)
        return passes(qubits, re.itemsize), k, kind(math.cos(beta)), kind(math.sin(beta))

    def _layer(
        self, re: Reals, im: Reals, diagonal: Reals, gamma: float, beta: float, *, back: bool
    ) -> None:
        how, k, c, s = self._setting(re, gamma, beta)
        run = self._kernels.low_pass
        if back:  # the mixers commute, so the high ones may come off first
            self._high(re, im, c, s, how)
        self._spread(
            lambda a, b: run(re, im, diagonal, k, c, s, how.low, back, a, b),
            re.size >> how.low,
            re.size,
        )
        if not back:
            self._high(re, im, c, s, how)

    def _high(self, re: Reals, im: Reals, c: Any, s: Any, how: Passes) -> None:
        run = self._kernels.high_pass
        for low, bits, width in how.high:

            def part(a: int, b: int, low: int = low, bits: int = bits, width: int = width) -> None:
                Re, Im = pair(width << bits, re.dtype)
                run(re, im, Re, Im, c, s, low, bits, width, a, b)

            self._spread(part, re.size // (width << bits), re.size)

    def _spread(self, work: Callable[[int, int], Any], blocks: int, size: int) -> list[Any]:
        """Run `work(a, b)` over ranges that cover all blocks, one range a thread."""
        if self._pool is None or size < 1 << 16:
            return [work(0, blocks)]
        edges = [blocks * k // self.threads for k in range(self.threads + 1)]
        return list(self._pool.map(work, edges[:-1], edges[1:]))


def _qubits(re: Reals) -> int:
    return re.size.bit_length() - 1
