"""Lengths of the ways of routing policies for numba. Importing this module imports numba.

The rules are those of `policies`: everything is open, there is one door, and the front is the
depot's side.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from qrobot._jit import compile_kernel
from qrobot.warehouse.extents import extent, lowest
from qrobot.warehouse.layouts import (
    AISLE_BY_AISLE,
    COMBINED,
    EVEN,
    LARGEST_GAP,
    RETURN,
    S_SHAPE,
    Layout,
    Words,
)

__all__ = ["way_length"]

ONE = np.uint64(1)


def _picks(words: Words, column: int, block: int, layout: Layout) -> tuple[float, float, float]:
    """Return first place, last place and widest gap between places of a sub-aisle, metres.

    Blocks and metres count from the depot's side; the first is -1 where nothing is picked.
    """
    blocks, flipped = layout.along.shape[1], layout.doors[0, 1] > 0
    at = blocks - 1 - block if flipped else block
    near, far, gap = extent(words, column * blocks + at, layout)
    if near < 0.0 or not flipped:
        return near, far, gap
    length = layout.along[column, at]
    return max(0.0, length - far), length - near, gap  # rounding: not below 0


_picks = compile_kernel(_picks, inner=True)


def _length(block: int, layout: Layout) -> float:
    """Return the length of the aisles of a block, counted from the depot's side."""
    flipped = layout.doors[0, 1] > 0
    return float(layout.along[0, layout.along.shape[1] - 1 - block if flipped else block])


_length = compile_kernel(_length, inner=True)


def _has_picks(words: Words, part: int) -> bool:
    """Return whether anything is picked in a sub-aisle."""
    found = False
    for w in range(words.shape[1]):
        found |= words[part, w] != 0
    return found


_has_picks = compile_kernel(_has_picks, inner=True)


def _halves(words: Words, column: int, layout: Layout) -> Any:
    """Return what is walked in an aisle whose halves are picked each from its end."""
    length, back = layout.along[column, 0], layout.doors[0, 1] == 1
    before, behind = 0.0, length
    for w in range(words.shape[1]):
        word = words[column, w]
        while word:
            y = layout.bases[0] + layout.pitch * (64 * w + lowest(word))
            word &= word - ONE
            if back:
                y = length - y
            if 2.0 * y <= (1.0 + EVEN) * length:
                before = max(before, y)
            else:
                behind = min(behind, y)
    return 2.0 * before + 2.0 * (length - behind)


_halves = compile_kernel(_halves, inner=True)


def _used(words: Words) -> tuple[int, int, int]:
    """Return the first and the last aisle with picks of one block, and how many have any."""
    first, last, used = -1, -1, 0
    for column in range(words.shape[0]):
        if _has_picks(words, column):
            first = column if first < 0 else first
            last, used = column, used + 1
    return first, last, used


_used = compile_kernel(_used, inner=True)


def _one_block(words: Words, layout: Layout) -> float:
    """Return the length of a way through one block, without the way to the depot's crossing."""
    policy, depot = layout.policy, layout.doors[0, 0]
    length = layout.along[0, 0]
    first, last, used = _used(words)
    if used == 0:
        return 0.0
    total, front, back = 0.0, 0.0, np.inf
    for column in range(first, last + 1):
        near, far, gap = _picks(words, column, 0, layout)
        if near < 0.0:
            continue
        if policy == COMBINED:
            here = min(front + 2.0 * far, back + length)
            back = min(back + 2.0 * (length - near), front + length)
            front = here
        elif policy == RETURN or used == 1:
            total += 2.0 * far
        elif policy == S_SHAPE:
            total += 2.0 * far if column == last and used % 2 == 1 else length
        elif column in (first, last):
            total += length
        elif policy == LARGEST_GAP:
            total += 2.0 * (length - max(gap, near, length - far))
        else:
            total += _halves(words, column, layout)
    span = max(last, depot) - min(first, depot)
    if layout.along.shape[0] > 1:
        total += 2.0 * span * layout.across[0, 0]
    return float(total + front)


_one_block = compile_kernel(_one_block, inner=True)


def _in_turn(
    words: Words, block: int, low: int, high: int, here: int, at_front: bool, layout: Layout
) -> tuple[float, float, int]:
    """Serve the aisles of a block from one end to the other: by S-shape, or combined.

    Returns
    -------
    tuple
        Metres in the aisles, pitches along the cross aisles, and the aisle where the picker comes
        to the front.
    """
    start, end, step, length = low, high, 1, _length(block, layout)
    if not at_front and abs(high - here) < abs(low - here):
        start, end, step = high, low, -1
    front, back = (0.0, np.inf) if at_front else (np.inf, 0.0)
    for column in range(start, end + step, step):
        near, far, _ = _picks(words, column, block, layout)
        if near < 0.0:
            continue
        if layout.policy == S_SHAPE and column != end:
            front, back = back + length, front + length
        else:
            ahead, behind = 2.0 * far, 2.0 * (length - near)
            front, back = min(front + ahead, back + length), min(back + behind, front + length)
    return front, float(abs(start - here) + high - low), end


_in_turn = compile_kernel(_in_turn, inner=True)


def _around_gaps(
    words: Words, block: int, low: int, high: int, here: int, at_front: bool, layout: Layout
) -> tuple[float, float, int]:
    """Serve a block from its back and then from its front, without the largest gaps.

    Returns
    -------
    tuple
        As of `_in_turn`.
    """
    inside, across, length = 0.0, 0.0, _length(block, layout)
    if at_front:
        across = float(abs(low - here))
        here = low
        if low == high:
            return 2.0 * _picks(words, low, block, layout)[1], across, low
        inside = length
    last = high if abs(high - here) >= abs(low - here) else low
    turn, end = 0, last
    for column in range(low, high + 1):
        near, far, gap = _picks(words, column, block, layout)
        if near < 0.0 or column == last or (at_front and column == low):
            continue
        widest = max(near, gap, length - far)
        inside += 2.0 * (length - widest)
        least = widest - EVEN * length  # of gaps as wide the first is left out
        if (near >= least or gap >= least) and (column - here) * (last - here) < 0:
            turn = max(turn, abs(column - here))  # from behind, on the other side of the picker
        if near < least and abs(column - last) > abs(end - last):
            end = column
    return inside + length, across + 2.0 * turn + abs(last - here) + abs(last - end), end


_around_gaps = compile_kernel(_around_gaps, inner=True)


def _block_by_block(words: Words, layout: Layout) -> float:
    """Return the length of a way up the first aisle to the farthest block, and back by blocks."""
    columns, blocks = layout.along.shape
    depot, cross = layout.doors[0]
    first, farthest = columns, -1
    for column in range(columns):
        for block in range(blocks):
            if _has_picks(words, column * blocks + (blocks - 1 - block if cross else block)):
                first, farthest = min(first, column), max(farthest, block)
    if farthest < 0:
        return 0.0
    inside, across, here = 0.0, float(abs(first - depot)), first
    for block in range(farthest, -1, -1):
        at_front = block == farthest
        # On the way up the first aisle its picks in the other blocks are picked.
        begin = first if at_front else first + 1
        low, high = columns, -1
        for column in range(begin, columns):
            if _has_picks(words, column * blocks + (blocks - 1 - block if cross else block)):
                low, high = min(low, column), column
        if not at_front:
            inside += _length(block, layout)
        if high < 0:
            inside += _length(block, layout)
            continue
        if layout.policy == LARGEST_GAP:
            more, pitches, here = _around_gaps(words, block, low, high, here, at_front, layout)
        else:
            more, pitches, here = _in_turn(words, block, low, high, here, at_front, layout)
        inside += more
        across += pitches
    across += abs(here - depot)
    return float(inside + across * layout.across[0, 0]) if columns > 1 else float(inside)


_block_by_block = compile_kernel(_block_by_block, inner=True)


def _aisle_by_aisle(words: Words, layout: Layout) -> float:
    """Return the length of a way that serves each aisle once, leaving it by the best crossing."""
    columns, blocks = layout.along.shape
    depot = layout.doors[0, 0]
    heights, best = np.zeros(blocks + 1), np.full(blocks + 1, np.inf)
    for block in range(blocks):
        heights[block + 1] = heights[block] + _length(block, layout)
    then = best.copy()
    best[0] = 0.0
    first, last = depot, depot
    for column in range(columns):
        low, high = np.inf, -np.inf
        for block in range(blocks):
            near, far, _ = _picks(words, column, block, layout)
            if near >= 0.0:
                low, high = min(low, heights[block] + near), heights[block] + far
        if high < 0.0:
            continue
        first, last = min(first, column), max(last, column)
        for leave in range(blocks + 1):
            then[leave] = np.inf
            for enter in range(blocks + 1):
                bottom = min(heights[enter], heights[leave])
                top = max(heights[enter], heights[leave])
                cost = top - bottom + 2.0 * max(0.0, bottom - low) + 2.0 * max(0.0, high - top)
                then[leave] = min(then[leave], best[enter] + cost)
        best, then = then, best
    across = 2.0 * (last - first) * layout.across[0, 0] if columns > 1 else 0.0
    return float(best[0] + across)


_aisle_by_aisle = compile_kernel(_aisle_by_aisle, inner=True)


def _way_length(words: Words, layout: Layout) -> float:
    """Return the length of the way of the layout's policy past all places of a batch, metres."""
    if layout.policy == AISLE_BY_AISLE:
        length = _aisle_by_aisle(words, layout)
    elif layout.along.shape[1] == 1:
        length = _one_block(words, layout)
    else:
        length = _block_by_block(words, layout)
    return float(length + 2.0 * layout.ways[0])


way_length = compile_kernel(_way_length, inner=True)
