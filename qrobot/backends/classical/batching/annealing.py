"""Simulated annealing over batches, compiled. Importing this module imports numba.

An order moves to another trip, or two orders of two trips change places; the trips that change
get their shortest tours at once. Trips may be overloaded at a price that follows what is found:
so the search passes from one packing to another. Lengths of batches are remembered by a hash of
their orders, and so are the batches of good plans, from which a set partition may put together
a better one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot._jit import compile_kernel
from qrobot.backends.classical.batching.state import KNOWN_BITS, State
from qrobot.backends.classical.orders import Hashes, Orders
from qrobot.warehouse.kernels import tour_length

__all__ = ["anneal", "place"]


def _next(random: Hashes) -> Any:
    """Return the next 64 random bits (xorshift64*, Marsaglia 2003, Vigna 2016)."""
    x = random[0]
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    random[0] = x
    return x * np.uint64(0x2545F4914F6CDD1D)


_next = compile_kernel(_next, inner=True)


def _below(random: Hashes, limit: int) -> Any:
    """Return a random number from 0 to limit - 1."""
    return np.int64(((_next(random) >> np.uint64(32)) * np.uint64(limit)) >> np.uint64(32))


_below = compile_kernel(_below, inner=True)


def _uniform(random: Hashes) -> float:
    """Return a random number from 0 to 1."""
    return float(_next(random) >> np.uint64(11)) / 9007199254740992.0


_uniform = compile_kernel(_uniform, inner=True)


def _batch_length(
    orders: Orders, state: State, trip: int, out: int, into: int, key: Any, words: Hashes
) -> Any:
    """Return the length of a trip without one order and with another (-1: none)."""
    if key == np.uint64(0):
        return 0.0
    slot = np.int64(key >> np.uint64(64 - KNOWN_BITS))
    if state.known_keys[slot] == key:
        return state.known_lengths[slot]
    words[:] = np.uint64(0)
    for k in range(state.size[trip]):
        order = state.members[trip, k]
        if order != out:
            words |= orders.masks[order]
    if into >= 0:
        words |= orders.masks[into]
    length = tour_length(words, orders.layout)
    state.known_keys[slot] = key
    state.known_lengths[slot] = length
    return length


_batch_length = compile_kernel(_batch_length, inner=True)


def _leave(state: State, orders: Orders, order: int) -> None:
    """Take an order off its trip."""
    trip = state.trip[order]
    last = state.members[trip, state.size[trip] - 1]
    state.members[trip, state.at[order]] = last
    state.at[last] = state.at[order]
    state.size[trip] -= 1
    state.load[trip] -= orders.weights[order]
    state.key[trip] ^= orders.keys[order]


_leave = compile_kernel(_leave, inner=True)


def _join(state: State, orders: Orders, order: int, trip: int) -> None:
    """Put an order on a trip."""
    state.members[trip, state.size[trip]] = order
    state.at[order] = state.size[trip]
    state.trip[order] = trip
    state.size[trip] += 1
    state.load[trip] += orders.weights[order]
    state.key[trip] ^= orders.keys[order]


_join = compile_kernel(_join, inner=True)


def _keep(state: State) -> None:
    """Keep the batches of the present plan for a set partition."""
    room, width = state.pool.shape
    mask = np.uint64(len(state.pool_keys) - 1)
    for trip in range(len(state.size)):
        count = state.size[trip]
        if not count or count > width:
            continue
        slot = np.int64((state.key[trip] >> np.uint64(8)) & mask)
        while state.pool_keys[slot] != np.uint64(0) and state.pool_keys[slot] != state.key[trip]:
            slot = (slot + 1) & np.int64(mask)
        if state.pool_keys[slot] == state.key[trip] or state.pool_size[0] >= room:
            continue
        state.pool_keys[slot] = state.key[trip]
        row = state.pool_size[0]
        for k in range(width):
            state.pool[row, k] = state.members[trip, k] if k < count else -1
        state.pool_size[0] += 1


_keep = compile_kernel(_keep, inner=True)


def _pick(
    near: Ints, trip: Ints, size: Ints, members: Ints, random: Hashes
) -> tuple[Any, Any, Any, Any]:
    """Return an order, another one, the other's trip, and whether they change places."""
    first = _below(random, len(trip))
    kind = _below(random, 16)
    second = near[first, _below(random, near.shape[1])]
    to = trip[second]
    if kind == 0:
        # Any trip, so that trips are opened and orders meet that have little in common.
        to = _below(random, len(size))
        if not size[to]:
            second = first
    if (kind == 0 or kind >= 9) and size[to]:
        # It joins whom it goes well with; another of that trip takes its place.
        second = members[to, _below(random, size[to])]
    return first, second, to, second != first and (kind == 0 or kind >= 6)


_pick = compile_kernel(_pick, inline=True)


def _least(length: Floats, without: Floats, alone: Floats, first: Any, second: Any, to: Any) -> Any:
    """Return what both trips are surely no shorter than after a move, -1 when it is not known.

    A tour is no shorter than that of a part of its orders, so most moves need no tour.
    """
    if without[first] < 0.0:
        return -1.0
    if second < 0:
        return without[first] + max(length[to], alone[first])
    if without[second] < 0.0:
        return -1.0
    return max(without[first], alone[second]) + max(without[second], alone[first])


_least = compile_kernel(_least, inline=True)


def _new_lengths(
    orders: Orders, state: State, first: int, second: int, trip: int, limit: float, words: Hashes
) -> tuple[float, float]:
    """Return the lengths of both trips after a move; ``inf`` when they exceed the limit."""
    a = state.trip[first]
    key_a, key_b = state.key[a] ^ orders.keys[first], state.key[trip] ^ orders.keys[first]
    if state.without[first] < 0.0:
        state.without[first] = _batch_length(orders, state, a, first, -1, key_a, words)
    length_a = state.without[first]
    least_b = max(state.length[trip], orders.alone[first])
    if second >= 0:
        if state.without[second] < 0.0:
            key = state.key[trip] ^ orders.keys[second]
            state.without[second] = _batch_length(orders, state, trip, second, -1, key, words)
        key_a ^= orders.keys[second]
        key_b ^= orders.keys[second]
        least_b = max(state.without[second], orders.alone[first])
        if max(length_a, orders.alone[second]) + least_b > limit:
            return np.inf, np.inf
        length_a = _batch_length(orders, state, a, first, second, key_a, words)
    if length_a + least_b > limit:
        return np.inf, np.inf
    length_b = _batch_length(orders, state, trip, second, first, key_b, words)
    if length_a + length_b > limit:
        return np.inf, np.inf
    return length_a, length_b


_new_lengths = compile_kernel(_new_lengths, inner=True)


def _move(orders: Orders, state: State, first: int, second: int, trip: int) -> None:
    """Put an order on a trip; another, unless it is -1, takes its place."""
    a = state.trip[first]
    _leave(state, orders, first)
    if second >= 0:
        _leave(state, orders, second)
        _join(state, orders, second, a)
    _join(state, orders, first, trip)
    for changed in (a, trip):
        for k in range(state.size[changed]):
            state.without[state.members[changed, k]] = -1.0


_move = compile_kernel(_move, inner=True)


def _excess(load: int, capacity: int) -> int:
    """Return by how much a trip is overloaded."""
    return max(0, load - capacity)


_excess = compile_kernel(_excess, inline=True)


def _note(state: State, cost: float, pool_below: float) -> None:
    """Keep a plan without overload when it is the best, and its batches when it is good."""
    if cost < pool_below:
        _keep(state)
    if cost < state.figures[1] - 1e-9 * abs(cost):
        state.figures[1] = cost
        for order in range(len(state.trip)):
            state.best[order] = state.trip[order]


_note = compile_kernel(_note, inner=True)


def _anneal(
    orders: Orders, state: State, moves: int, heat: float, pool_below: float
) -> tuple[float, float]:
    """Try some moves at one temperature.

    Parameters
    ----------
    orders, state
        The question and the present plan, which is changed.
    moves
        How many are tried.
    heat
        The temperature, metres.
    pool_below
        Plans without overload that cost less give their batches to the pool.

    Returns
    -------
    tuple
        Length and overload of the present plan.
    """
    words = np.empty(orders.masks.shape[1:], dtype=np.uint64)
    price, tie = state.figures[0], state.figures[2]
    weights, capacities, near, alone = orders.weights, orders.capacities, orders.near, orders.alone
    trip, size, members, random = state.trip, state.size, state.members, state.random
    load, length, without = state.load, state.length, state.without
    total, over, used = 0.0, 0, 0
    for t in range(len(capacities)):
        total += length[t]
        over += _excess(load[t], capacities[t])
        used += size[t] > 0
    if over == 0:
        _note(state, total + tie * used, pool_below)
    for _ in range(moves):
        first, second, b, swap = _pick(near, trip, size, members, random)
        a = trip[first]
        if a == b:
            continue
        gain, opened = weights[first], 0
        if swap:
            gain -= weights[second]
        else:
            second = -1
            opened = (size[b] == 0) - (size[a] == 1)
        change = _excess(load[a] - gain, capacities[a]) + _excess(load[b] + gain, capacities[b])
        change -= _excess(load[a], capacities[a]) + _excess(load[b], capacities[b])
        limit = length[a] + length[b] - price * change - tie * opened
        limit -= heat * np.log(_uniform(random) + 1e-300)
        if _least(length, without, alone, first, second, b) > limit:
            continue
        length_a, length_b = _new_lengths(orders, state, first, second, b, limit, words)
        if length_a == np.inf:
            continue
        total += length_a + length_b - length[a] - length[b]
        over += change
        used += opened
        _move(orders, state, first, second, b)
        length[a], length[b] = length_a, length_b
        if over == 0:
            _note(state, total + tie * used, pool_below)
    return total, float(over)


anneal = compile_kernel(_anneal)


def _place(orders: Orders, state: State, trip: Ints) -> None:
    """Set the present plan."""
    for t in range(len(state.size)):
        state.size[t], state.load[t], state.key[t] = 0, 0, np.uint64(0)
    for order in range(len(trip)):
        state.without[order] = -1.0
    words = np.empty(orders.masks.shape[1:], dtype=np.uint64)
    for order in range(len(trip)):
        _join(state, orders, order, trip[order])
    for t in range(len(state.size)):
        state.length[t] = _batch_length(orders, state, t, -1, -1, state.key[t], words)


place = compile_kernel(_place)
