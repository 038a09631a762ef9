"""Lengths of tours for numba: of one batch after the other, from bit masks of its places.

Importing this module imports numba. Functions that call each other are in one file: numba's
cache looks at its date only.

A batch is a row of words: for each sub-aisle a bit for each slot. The words of a batch are those
of its orders, joined by "or".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from qrobot._arrays import Floats
from qrobot._jit import compile_kernel
from qrobot.warehouse.layouts import (
    COMBINED,
    LARGEST_GAP,
    RETURN,
    S_SHAPE,
    Layout,
    Words,
    masks_of,
)
from qrobot.warehouse.sweep import Numbers

__all__ = ["Layout", "Words", "masks_of", "tour_length"]

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


_lowest = compile_kernel(_lowest, inner=True)


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
        low, high = _lowest(word), _highest(word)
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


_extent = compile_kernel(_extent, inner=True)


def _one_block(words: Words, layout: Layout) -> float:
    """Return the length of a shortest tour from one door (Ratliff and Rosenthal 1983).

    States: the crossing in front has an even number of walks (``front``), that at the back
    (``back``), both and they are connected (``one``) or not (``two``), both an odd number
    (``odd``); nothing was reached (``begin``) or the tour is finished (``done``).
    """
    columns = layout.along.shape[0]
    depot, cross = layout.doors[0]
    begin, done = 0.0, np.inf
    odd = front = back = one = two = np.inf
    first, last = 0, columns - 1
    if layout.is_open:
        first = last = depot
        for column in range(columns):
            for w in range(words.shape[1]):
                if words[column, w]:
                    first = min(first, column)
                    last = max(last, column)
    for column in range(first, last + 1):
        if column == depot:
            if cross == 0:
                two, back = min(two, back), np.inf
                front = min(front, begin)
            else:
                two, front = min(two, front), np.inf
                back = min(back, begin)
            begin = done = np.inf
        length = layout.along[column, 0]
        near, far, gap = _extent(words, column, layout)
        either = min(front, back, one, two, begin) + length
        twice = min(front, back, two, begin) + 2.0 * length
        if near < 0.0:
            # Nothing is picked here: the sub-aisle is passed, or left alone.
            odd, one = min(odd, either), min(one, odd + length, twice)
        else:
            here, there = 2.0 * far, 2.0 * (length - near)
            both = 2.0 * (length - gap) if gap > 0.0 else np.inf
            if length == np.inf:
                here = there = both = np.inf
            least = min(both, here, there)
            apart = min(two + least, front + min(there, both), back + min(here, both))
            two = min(apart, begin + both)
            one = min(one + least, odd + length, twice)
            odd = min(odd + least, either)
            front = min(front, begin) + here
            back = min(back, begin) + there
            begin = done = np.inf
        done = min(done, one, front, back)
        if column < last:
            ahead, behind = 2.0 * layout.across[column, 0], 2.0 * layout.across[column, 1]
            odd += 0.5 * (ahead + behind)
            front, back = min(front, one) + ahead, min(back, one) + behind
            one += ahead + behind
            two += ahead + behind
    return float(done + 2.0 * layout.ways[0])


_one_block = compile_kernel(_one_block, inner=True)


def _relax(now: Floats, then: Floats, steps: Numbers, first: int, end: int, prices: Floats) -> None:
    """Set the least cost of every state after some steps."""
    then[:] = np.inf
    for k in range(first, end):
        cost = now[steps[k, 0]] + prices[steps[k, 2]]
        if cost < then[steps[k, 1]]:
            then[steps[k, 1]] = cost


_relax = compile_kernel(_relax, inner=True)


def _prices(words: Words, column: int, block: int, layout: Layout, prices: Floats) -> Any:
    """Set what each choice for a sub-aisle costs, by `states.VERTICAL`; return if it is empty."""
    length = layout.along[column, block]
    part = column * layout.along.shape[1] + block
    near, far, gap = _extent(words, part, layout)
    prices[:] = np.inf
    prices[1], prices[2] = length, 2.0 * length
    if near < 0.0:
        prices[0] = 0.0
    elif length < np.inf:
        prices[3], prices[4] = 2.0 * far, 2.0 * (length - near)
        if gap > 0.0:
            prices[5] = 2.0 * (length - gap)
    return near < 0.0


_prices = compile_kernel(_prices, inner=True)


def _blocks(words: Words, layout: Layout) -> float:
    """Return the length of a shortest tour through any number of blocks, by the sweep."""
    columns, blocks = layout.along.shape
    now, then = np.empty(layout.states), np.empty(layout.states)
    prices, walks = np.empty(6), np.zeros(3)
    first, last = 0, columns - 1
    if layout.is_open:
        first, last = layout.doors[:, 0].min(), layout.doors[:, 0].max()
        for part in range(columns * blocks):
            for w in range(words.shape[1]):
                if words[part, w]:
                    first = min(first, part // blocks)
                    last = max(last, part // blocks)
    now[:] = np.inf
    now[layout.ends[0]] = 0.0
    starts = layout.starts
    for column in range(first, last + 1):
        for door in range(len(layout.ways)):
            if column == layout.doors[door, 0]:
                group = 2 * blocks + 1 + layout.doors[door, 1]
                walks[1], walks[2] = layout.ways[door], 2.0 * layout.ways[door]
                _relax(now, then, layout.steps, starts[group], starts[group + 1], walks)
                now, then = then, now
        for block in range(blocks):
            begin, end = starts[block], starts[block + 1]
            if _prices(words, column, block, layout, prices):
                end = layout.marks[block, 1]  # passed or left alone
            else:
                begin = layout.marks[block, 0]  # not left alone
            _relax(now, then, layout.steps, begin, end, prices)
            now, then = then, now
        for group in range(blocks, 2 * blocks + 1):
            length = layout.across[column, group - blocks] if column < last else np.inf
            walks[1], walks[2] = length, 2.0 * length
            _relax(now, then, layout.steps, starts[group], starts[group + 1], walks)
            now, then = then, now
    return float(now[layout.ends[1]])


_blocks = compile_kernel(_blocks, inner=True)


def _halves(words: Words, column: int, layout: Layout) -> Any:
    """Return what is walked in an aisle whose halves are picked each from its end."""
    length, back = layout.along[column, 0], layout.doors[0, 1] == 1
    before, behind = 0.0, length
    for w in range(words.shape[1]):
        word = words[column, w]
        while word:
            y = layout.bases[0] + layout.pitch * (64 * w + _lowest(word))
            word &= word - ONE
            if back:
                y = length - y
            if 2.0 * y <= length:
                before = max(before, y)
            else:
                behind = min(behind, y)
    return 2.0 * before + 2.0 * (length - behind)


_halves = compile_kernel(_halves, inner=True)


def _used(words: Words) -> tuple[int, int, int]:
    """Return the first and the last aisle with picks of one block, and how many have any."""
    first, last, used = -1, -1, 0
    for column in range(words.shape[0]):
        picks = False
        for w in range(words.shape[1]):
            picks |= words[column, w] != 0
        if picks:
            first = column if first < 0 else first
            last, used = column, used + 1
    return first, last, used


_used = compile_kernel(_used, inner=True)


def _by_policy(words: Words, layout: Layout) -> float:
    """Return the length of the tour of a policy; one block, all open, one door.

    The rules are those of `policies`, the depot's side is the front.
    """
    policy, columns = layout.policy, layout.along.shape[0]
    depot, cross = layout.doors[0]
    length = layout.along[0, 0]
    first, last, used = _used(words)
    if used == 0:
        return float(2.0 * layout.ways[0])
    total, front, back = 0.0, 0.0, np.inf
    for column in range(first, last + 1):
        near, far, gap = _extent(words, column, layout)
        if near < 0.0:
            continue
        if cross == 1:
            near, far = length - far, length - near
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
    if columns > 1:
        total += 2.0 * span * layout.across[0, 0]
    return float(total + front + 2.0 * layout.ways[0])


_by_policy = compile_kernel(_by_policy, inner=True)


def _tour_length(words: Words, layout: Layout) -> float:
    """Return the length of a tour from the depot past all places of a batch.

    It is a shortest one, or that of the layout's policy.

    Parameters
    ----------
    words
        Shape (sub-aisles, words): the places.
    layout
        The grid.

    Returns
    -------
    float
        Metres; ``inf`` where a place cannot be reached. A batch without places takes the way
        to the depot's nearest crossing and back.
    """
    if layout.policy != 0:
        return _by_policy(words, layout)
    if layout.along.shape[1] == 1 and len(layout.ways) == 1:
        return _one_block(words, layout)
    return _blocks(words, layout)


tour_length = compile_kernel(_tour_length)
