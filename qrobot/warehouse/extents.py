"""Where the picks of a sub-aisle lie, from its bit mask. Importing this module imports numba."""

from __future__ import annotations

from typing import Any

import numpy as np

from qrobot._jit import compile_kernel
from qrobot.warehouse.layouts import Layout, Words

__all__ = ["extent", "lowest"]

ONE = np.uint64(1)
SHIFT = np.uint64(58)
DE_BRUIJN = np.uint64(0x03F79D71B4CB0A89)
PLACE = np.zeros(64, dtype=np.int64)
"""Which bit is set, by the top six bits of the bit times `DE_BRUIJN`."""
for _bit in range(64):
    PLACE[(((1 << _bit) * int(DE_BRUIJN)) & (2**64 - 1)) >> 58] = _bit


def _lowest(word: Any) -> Any:
    """Return the index of the lowest set bit."""
    return PLACE[((word & (~word + ONE)) * DE_BRUIJN) >> SHIFT]


lowest = compile_kernel(_lowest, inner=True)


def _highest(word: Any) -> Any:
    """Return the index of the highest set bit."""
    word |= word >> np.uint64(1)
    word |= word >> np.uint64(2)
    word |= word >> np.uint64(4)
    word |= word >> np.uint64(8)
    word |= word >> np.uint64(16)
    word |= word >> np.uint64(32)
    return PLACE[((word ^ (word >> ONE)) * DE_BRUIJN) >> SHIFT]


_highest = compile_kernel(_highest, inner=True)


def _slots(words: Words, part: int) -> tuple[int, int, int]:
    """Return first and last slot of a sub-aisle, and the most slots from one to the next."""
    first, last, gap = -1, -1, 0
    for w in range(words.shape[1]):
        word = words[part, w]
        if not word:
            continue
        low, high = lowest(word), _highest(word)
        if first < 0:
            first = 64 * w + low
        else:
            gap = max(gap, 64 * w + low - last)
        last = 64 * w + high
        # Runs of slots without a pick between the first and the last: each round shortens them.
        empty = ~word & ((ONE << np.uint64(high)) - (ONE << np.uint64(low)))
        run = 1
        while empty:
            empty &= empty >> ONE
            run += 1
        if high > low:
            gap = max(gap, run)
    return first, last, gap


_slots = compile_kernel(_slots, inner=True)


def _extent(words: Words, part: int, layout: Layout) -> tuple[float, float, float]:
    """Return first place, last place and widest gap between places of a sub-aisle, metres."""
    first, last, gap = _slots(words, part)
    if first < 0:
        return -1.0, -1.0, 0.0
    base, pitch = layout.bases[part % layout.along.shape[1]], layout.pitch
    return base + pitch * first, base + pitch * last, pitch * gap


extent = compile_kernel(_extent, inner=True)
