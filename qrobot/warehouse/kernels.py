"""Lengths of tours for numba: of one batch after the other, from bit masks of its places.

Importing this module imports numba.

A batch is a row of words: for each sub-aisle a bit for each slot. The words of a batch are those
of its orders, joined by "or".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from qrobot._arrays import Floats
from qrobot._jit import compile_kernel
from qrobot.warehouse.extents import extent
from qrobot.warehouse.layouts import SHORTEST, Layout, Words, masks_of
from qrobot.warehouse.policy_kernels import way_length
from qrobot.warehouse.sweep import Numbers

__all__ = ["Layout", "Words", "least_length", "masks_of", "tour_length"]


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
        near, far, gap = extent(words, column, layout)
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
    near, far, gap = extent(words, part, layout)
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


def _shortest(words: Words, layout: Layout) -> float:
    """Return the length of a shortest tour."""
    if layout.along.shape[1] == 1 and len(layout.ways) == 1:
        return float(_one_block(words, layout))
    return float(_blocks(words, layout))


_shortest = compile_kernel(_shortest, inline=True)


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
    if layout.policy != SHORTEST:
        return float(way_length(words, layout))
    return float(_shortest(words, layout))


tour_length = compile_kernel(_tour_length)


def _least_length(words: Words, layout: Layout, length: float) -> float:
    """Return what no tour past all places of a batch and others is shorter than, metres.

    Parameters
    ----------
    words, layout
        As of `tour_length`.
    length
        What that returned.
    """
    return length if layout.grows else float(_shortest(words, layout))


least_length = compile_kernel(_least_length)
