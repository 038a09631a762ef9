"""The compiled kernels of the diagonal simulator. Importing this module imports numba.

A state is two arrays, real and imaginary parts, so that every loop is plain real arithmetic on
contiguous memory and the compiler uses the widest vectors of the processor. One pass over
memory applies the phase and the mixers of all low qubits, block by block within the cache; one
more pass (two beyond 24 qubits) applies the mixers of the high qubits to tiles of contiguous
columns. Functions that call each other are in one file: numba's cache looks at its date only.

The mixer of one qubit is exp(-i beta X): with c = cos beta and s = sin beta it takes (u, v) to
(c u - i s v, c v - i s u). All sums are taken in float64, whatever the state's precision.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Reals
from qrobot._jit import compile_kernel

__all__ = [
    "first_pass",
    "high_overlap",
    "high_pass",
    "histogram",
    "low_overlap",
    "low_pass",
    "moments",
]

compile_sum = partial(compile_kernel, sums=True)


@compile_kernel
def two(Re: Reals, Im: Reals, c: Any, s: Any, h: int) -> None:
    """Mix the one qubit of stride `h`."""
    for o in range(0, Re.shape[0], 2 * h):
        R0, I0 = Re[o : o + h], Im[o : o + h]
        R1, I1 = Re[o + h : o + 2 * h], Im[o + h : o + 2 * h]
        for j in range(h):
            r0, i0, r1, i1 = R0[j], I0[j], R1[j], I1[j]
            R0[j] = c * r0 + s * i1
            I0[j] = c * i0 - s * r1
            R1[j] = c * r1 + s * i0
            I1[j] = c * i1 - s * r0


@compile_kernel
def four(Re: Reals, Im: Reals, c: Any, s: Any, h: int) -> None:
    """Mix the two qubits of strides `h` and `2 h`: half the loads and stores."""
    for o in range(0, Re.shape[0], 4 * h):
        R0, I0 = Re[o : o + h], Im[o : o + h]
        R1, I1 = Re[o + h : o + 2 * h], Im[o + h : o + 2 * h]
        R2, I2 = Re[o + 2 * h : o + 3 * h], Im[o + 2 * h : o + 3 * h]
        R3, I3 = Re[o + 3 * h : o + 4 * h], Im[o + 3 * h : o + 4 * h]
        for j in range(h):
            r0, i0, r1, i1 = R0[j], I0[j], R1[j], I1[j]
            r2, i2, r3, i3 = R2[j], I2[j], R3[j], I3[j]
            x0, y0, x1, y1 = c * r0 + s * i1, c * i0 - s * r1, c * r1 + s * i0, c * i1 - s * r0
            x2, y2, x3, y3 = c * r2 + s * i3, c * i2 - s * r3, c * r3 + s * i2, c * i3 - s * r2
            R0[j] = c * x0 + s * y2
            I0[j] = c * y0 - s * x2
            R2[j] = c * x2 + s * y0
            I2[j] = c * y2 - s * x0
            R1[j] = c * x1 + s * y3
            I1[j] = c * y1 - s * x3
            R3[j] = c * x3 + s * y1
            I3[j] = c * y3 - s * x1


@compile_kernel
def eight(Re: Reals, Im: Reals, c: Any, s: Any) -> None:
    """Mix the three lowest qubits in registers: their strides are too short for vectors."""
    for o in range(0, Re.shape[0], 8):
        r0, r1, r2, r3 = Re[o], Re[o + 1], Re[o + 2], Re[o + 3]
        r4, r5, r6, r7 = Re[o + 4], Re[o + 5], Re[o + 6], Re[o + 7]
        i0, i1, i2, i3 = Im[o], Im[o + 1], Im[o + 2], Im[o + 3]
        i4, i5, i6, i7 = Im[o + 4], Im[o + 5], Im[o + 6], Im[o + 7]
        r0, i0, r1, i1 = c * r0 + s * i1, c * i0 - s * r1, c * r1 + s * i0, c * i1 - s * r0
        r2, i2, r3, i3 = c * r2 + s * i3, c * i2 - s * r3, c * r3 + s * i2, c * i3 - s * r2
        r4, i4, r5, i5 = c * r4 + s * i5, c * i4 - s * r5, c * r5 + s * i4, c * i5 - s * r4
        r6, i6, r7, i7 = c * r6 + s * i7, c * i6 - s * r7, c * r7 + s * i6, c * i7 - s * r6
        r0, i0, r2, i2 = c * r0 + s * i2, c * i0 - s * r2, c * r2 + s * i0, c * i2 - s * r0
        r1, i1, r3, i3 = c * r1 + s * i3, c * i1 - s * r3, c * r3 + s * i1, c * i3 - s * r1
        r4, i4, r6, i6 = c * r4 + s * i6, c * i4 - s * r6, c * r6 + s * i4, c * i6 - s * r4
        r5, i5, r7, i7 = c * r5 + s * i7, c * i5 - s * r7, c * r7 + s * i5, c * i7 - s * r5
        r0, i0, r4, i4 = c * r0 + s * i4, c * i0 - s * r4, c * r4 + s * i0, c * i4 - s * r0
        r1, i1, r5, i5 = c * r1 + s * i5, c * i1 - s * r5, c * r5 + s * i1, c * i5 - s * r1
        r2, i2, r6, i6 = c * r2 + s * i6, c * i2 - s * r6, c * r6 + s * i2, c * i6 - s * r2
        r3, i3, r7, i7 = c * r3 + s * i7, c * i3 - s * r7, c * r7 + s * i3, c * i7 - s * r3
        Re[o], Re[o + 1], Re[o + 2], Re[o + 3] = r0, r1, r2, r3
        Re[o + 4], Re[o + 5], Re[o + 6], Re[o + 7] = r4, r5, r6, r7
        Im[o], Im[o + 1], Im[o + 2], Im[o + 3] = i0, i1, i2, i3
        Im[o + 4], Im[o + 5], Im[o + 6], Im[o + 7] = i4, i5, i6, i7


@compile_kernel
def mix(Re: Reals, Im: Reals, c: Any, s: Any, h: int) -> None:
    """Mix every qubit of stride `h` and above within a block."""
    size = Re.shape[0]
    if h == 1 and size >= 8:
        eight(Re, Im, c, s)
        h = 8
    while 4 * h <= size:
        four(Re, Im, c, s, h)
        h *= 4
    if 2 * h <= size:
        two(Re, Im, c, s, h)


@compile_kernel
def phase(Re: Reals, Im: Reals, D: Reals, k: Reals, fresh: bool) -> None:
    """Multiply with exp(-i gamma D), or begin with it times one amplitude.

    The angle in turns is reduced to half a turn around zero (exactly), its quarter goes into
    Taylor polynomials, and two doublings of the angle give the whole: no table, no branch, so
    it becomes vector code. The constants come as an array of the state's type because a
    written constant would be float64.
    """
    turns, magic, one, two_, amplitude = k[0], k[1], k[2], k[3], k[4]
    s1, s3, s5, s7, s9, s11, s13, s15 = k[5], k[6], k[7], k[8], k[9], k[10], k[11], k[12]
    c2, c4, c6, c8, c10, c12, c14 = k[13], k[14], k[15], k[16], k[17], k[18], k[19]
    for j in range(Re.shape[0]):
        t = D[j] * turns
        t = t - ((t + magic) - magic)
        u = t * t
        sn = t * (s1 + u * (s3 + u * (s5 + u * (s7 + u * (s9 + u * (s11 + u * (s13 + u * s15)))))))
        cs = one + u * (c2 + u * (c4 + u * (c6 + u * (c8 + u * (c10 + u * (c12 + u * c14))))))
        half = two_ * sn * cs
        rest = one - two_ * sn * sn
        sn = two_ * half * rest
        cs = one - two_ * half * half
        if fresh:
            Re[j] = amplitude * cs
            Im[j] = -amplitude * sn
        else:
            r, i = Re[j], Im[j]
            Re[j] = r * cs + i * sn
            Im[j] = i * cs - r * sn


@compile_kernel
def first_pass(
    re: Reals, im: Reals, diagonal: Reals, k: Reals, c: Any, s: Any, bits: int, a: int, b: int
) -> None:
    """Begin in the uniform state: phase and low mixers of blocks a..b, nothing is read."""
    for block in range(a, b):
        o, e = block << bits, (block + 1) << bits
        phase(re[o:e], im[o:e], diagonal[o:e], k, True)
        mix(re[o:e], im[o:e], c, s, 1)


@compile_kernel
def low_pass(
    re: Reals,
    im: Reals,
    diagonal: Reals,
    k: Reals,
    c: Any,
    s: Any,
    bits: int,
    back: bool,
    a: int,
    b: int,
) -> None:
    """Apply phase and low mixers (mixers first when going back) to blocks a..b."""
    for block in range(a, b):
        o, e = block << bits, (block + 1) << bits
        if back:
            mix(re[o:e], im[o:e], c, s, 1)
        phase(re[o:e], im[o:e], diagonal[o:e], k, False)
        if not back:
            mix(re[o:e], im[o:e], c, s, 1)


@compile_kernel
def high_pass(
    re: Reals,
    im: Reals,
    Re: Reals,
    Im: Reals,
    c: Any,
    s: Any,
    low: int,
    bits: int,
    width: int,
    a: int,
    b: int,
) -> None:
    """Mix qubits low .. low + bits - 1, tile by tile of `width` columns, in the room Re and Im.

    Rows of a tile lie a power of two apart, in the same sets of the cache: hence the copy.
    """
    rows, per = 1 << bits, (1 << low) // width
    for tile in range(a, b):
        start = ((tile // per) << (low + bits)) + (tile % per) * width
        for row in range(rows):
            o = start + (row << low)
            Re[row * width : (row + 1) * width] = re[o : o + width]
            Im[row * width : (row + 1) * width] = im[o : o + width]
        mix(Re, Im, c, s, width)
        for row in range(rows):
            o = start + (row << low)
            re[o : o + width] = Re[row * width : (row + 1) * width]
            im[o : o + width] = Im[row * width : (row + 1) * width]


@compile_sum
def moments(re: Reals, im: Reals, diagonal: Reals, a: int, b: int) -> tuple[float, float]:
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


@compile_kernel
def histogram(
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


@compile_sum
def overlap(lr: Reals, li: Reals, re: Reals, im: Reals, h: int) -> float:
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


@compile_kernel
def low_overlap(lr: Reals, li: Reals, re: Reals, im: Reals, bits: int, a: int, b: int) -> float:
    """Return the overlap over the low qubits of blocks a..b."""
    total = 0.0
    for block in range(a, b):
        o, e = block << bits, (block + 1) << bits
        total += overlap(lr[o:e], li[o:e], re[o:e], im[o:e], 1)
    return total


@compile_kernel
def high_overlap(
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
