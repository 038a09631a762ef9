"""The compiled sums over a state. Importing this module imports numba.

All sums are taken in float64, whatever the state's precision.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Reals
from qrobot._jit import compile_kernel

__all__ = ["high_overlap", "histogram", "low_overlap", "moments"]


def _moments(re: Reals, im: Reals, diagonal: Reals, a: int, b: int) -> tuple[float, float]:
    """Return the sums of probability, and of probability times energy, of a..b."""
    mass, energy = 0.0, 0.0
    for start in range(a, b, 1024):
        part, weighted = 0.0, 0.0
        for j in range(start, min(start + 1024, b)):
            r, i = np.float64(re[j]), np.float64(im[j])
            p = r * r + i * i
            part += p
            weighted += p * np.float64(diagonal[j])
        mass += part
        energy += weighted
    return mass, energy


def _histogram(
    re: Reals,
    im: Reals,
    diagonal: Reals,
    lowest: float,
    scale: float,
    mass: npt.NDArray[np.float64],
    energy: npt.NDArray[np.float64],
    a: int,
    b: int,
) -> None:
    """Add probability, and probability times energy, to bins of equal width."""
    last = mass.shape[0] - 1
    for j in range(a, b):
        r, i, e = np.float64(re[j]), np.float64(im[j]), np.float64(diagonal[j])
        p = r * r + i * i
        k = min(max(int((e - lowest) * scale), 0), last)
        mass[k] += p
        energy[k] += p * e


def _overlap(lr: Reals, li: Reals, re: Reals, im: Reals, h: int) -> float:
    """Return the imaginary part of <l| sum of X |state> over strides `h` and above."""
    total, size = 0.0, re.shape[0]
    while 2 * h <= size:
        for o in range(0, size, 2 * h):
            m, e = o + h, o + 2 * h
            lr0, li0, r0, i0 = lr[o:m], li[o:m], re[o:m], im[o:m]
            lr1, li1, r1, i1 = lr[m:e], li[m:e], re[m:e], im[m:e]
            part = 0.0
            for j in range(h):
                part += np.float64(
                    lr0[j] * i1[j] - li0[j] * r1[j] + lr1[j] * i0[j] - li1[j] * r0[j]
                )
            total += part
        h *= 2
    return total


overlap = compile_kernel(_overlap, sums=True)


def _low_overlap(lr: Reals, li: Reals, re: Reals, im: Reals, bits: int, a: int, b: int) -> float:
    """Return the overlap over the low qubits of blocks a..b."""
    total = 0.0
    for block in range(a, b):
        o, e = block << bits, (block + 1) << bits
        total += overlap(lr[o:e], li[o:e], re[o:e], im[o:e], 1)
    return total


def _high_overlap(
    lr: Reals, li: Reals, re: Reals, im: Reals, low: int, bits: int, width: int, a: int, b: int
) -> float:
    """Return the overlap over qubits low .. low + bits - 1 of tiles a..b."""
    rows, per = 1 << bits, (1 << low) // width
    tiles = np.empty((4, rows * width), re.dtype)
    total = 0.0
    for tile in range(a, b):
        start = ((tile // per) << (low + bits)) + (tile % per) * width
        for row in range(rows):
            o, at = start + (row << low), row * width
            tiles[0, at : at + width] = lr[o : o + width]
            tiles[1, at : at + width] = li[o : o + width]
            tiles[2, at : at + width] = re[o : o + width]
            tiles[3, at : at + width] = im[o : o + width]
        total += overlap(tiles[0], tiles[1], tiles[2], tiles[3], width)
    return total


moments = compile_kernel(_moments, sums=True)
histogram = compile_kernel(_histogram)
low_overlap = compile_kernel(_low_overlap)
high_overlap = compile_kernel(_high_overlap)
