"""Simulated annealing over batches, compiled. Importing this module imports numba.

An order moves to another trip, or two orders of two trips change places; where that would
overload a trip, one more order of each may balance the loads. The trips that change get their
shortest tours at once. Trips may be overloaded at a price that follows what is found:
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


def _length_after(
    orders: Orders,
    state: State,
    trip: int,
    out: tuple[int, int],
    into: tuple[int, int],
    words: Hashes,
) -> Any:
    """Return the length of a trip without up to two orders and with up to two others (-1: none)."""
    key = state.key[trip]
    for order in out:
        if order >= 0:
            key ^= orders.keys[order]
    for order in into:
        if order >= 0:
            key ^= orders.keys[order]
    if key == np.uint64(0):
        return 0.0
    slot = np.int64(key >> np.uint64(64 - KNOWN_BITS))
    if state.known_keys[slot] == key:
        return state.known_lengths[slot]
    words[:] = np.uint64(0)
    for k in range(state.size[trip]):
        order = state.members[trip, k]
        if order != out[0] and order != out[1]:
            words |= orders.masks[order]
    for order in into:
        if order >= 0:
            words |= orders.masks[order]
    length = tour_length(words, orders.layout)
    state.known_keys[slot] = key
    state.known_lengths[slot] = length
    return length


_length_after = compile_kernel(_length_after, inner=True)


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
    if state.without[first] < 0.0:
        state.without[first] = _length_after(orders, state, a, (first, -1), (-1, -1), words)
    length_a = state.without[first]
    least_b = max(state.length[trip], orders.alone[first])
    if second >= 0:
        if state.without[second] < 0.0:
            length = _length_after(orders, state, trip, (second, -1), (-1, -1), words)
            state.without[second] = length
        least_b = max(state.without[second], orders.alone[first])
        if max(length_a, orders.alone[second]) + least_b > limit:
            return np.inf, np.inf
        length_a = _length_after(orders, state, a, (first, -1), (second, -1), words)
    if length_a + least_b > limit:
        return np.inf, np.inf
    length_b = _length_after(orders, state, trip, (second, -1), (first, -1), words)
    if length_a + length_b > limit:
        return np.inf, np.inf
    return length_a, length_b


_new_lengths = compile_kernel(_new_lengths, inner=True)


def _balance(orders: Orders, state: State, first: int, second: int, trip: int) -> tuple[Any, Any]:
    """Return an order that moves along and one that comes back, so that no trip is overloaded.

    -1 stands for none; -2 and -2 are returned where no two orders do it. Each pair that does is as
    likely. Where trips are nearly full, few moves of one or two orders alone would fit.
    """
    a = state.trip[first]
    gain = orders.weights[first]
    if second >= 0:
        gain -= orders.weights[second]
    most = orders.capacities[trip] - state.load[trip] - gain
    least = state.load[a] - orders.capacities[a] - gain
    along, back, found = -2, -2, 0
    for i in range(-1, state.size[a]):
        one = state.members[a, i] if i >= 0 else -1
        if i >= 0 and one == first:
            continue
        plus = orders.weights[one] if i >= 0 else 0
        for j in range(-1, state.size[trip]):
            other = state.members[trip, j] if j >= 0 else -1
            if j >= 0 and other == second:
                continue
            more = plus - (orders.weights[other] if j >= 0 else 0)
            if least <= more <= most:
                found += 1
                if _below(state.random, found) == 0:
                    along, back = one, other
    return along, back


_balance = compile_kernel(_balance, inner=True)


def _balanced_lengths(
    orders: Orders,
    state: State,
    trip: int,
    out: tuple[int, int],
    into: tuple[int, int],
    limit: float,
    words: Hashes,
) -> tuple[float, float]:
    """Return the lengths of both trips when orders go out of one for others of `trip`."""
    length_a = _length_after(orders, state, state.trip[out[0]], out, into, words)
    if length_a + orders.alone[out[0]] > limit:
        return np.inf, np.inf
    length_b = _length_after(orders, state, trip, into, out, words)
    if length_a + length_b > limit:
        return np.inf, np.inf
    return length_a, length_b


_balanced_lengths = compile_kernel(_balanced_lengths, inner=True)


def _move(
    orders: Orders, state: State, trip: int, out: tuple[int, int], into: tuple[int, int]
) -> None:
    """Put orders of one trip on another; others, unless they are -1, take their place."""
    a = state.trip[out[0]]
    for order in out:
        if order >= 0:
            _leave(state, orders, order)
    for order in into:
        if order >= 0:
            _leave(state, orders, order)
            _join(state, orders, order, a)
    for order in out:
        if order >= 0:
            _join(state, orders, order, trip)
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
        if not swap:
            second = -1
        gain = weights[first] - (weights[second] if swap else 0)
        change = _excess(load[a] - gain, capacities[a]) + _excess(load[b] + gain, capacities[b])
        now = _excess(load[a], capacities[a]) + _excess(load[b], capacities[b])
        along = back = -1
        if change > now and size[b] and _below(random, 2):
            along, back = _balance(orders, state, first, second, b)
            if along == -2:
                continue
            change = 0
        change -= now
        left = size[a] - 1 + (second >= 0) - (along >= 0) + (back >= 0)
        opened = (size[b] == 0) - (left == 0)
        limit = length[a] + length[b] - price * change - tie * opened
        limit -= heat * np.log(_uniform(random) + 1e-300)
        if along >= 0 or back >= 0:
            length_a, length_b = _balanced_lengths(
                orders, state, b, (first, along), (second, back), limit, words
            )
        elif _least(length, without, alone, first, second, b) > limit:
            continue
        else:
            length_a, length_b = _new_lengths(orders, state, first, second, b, limit, words)
        if length_a == np.inf:
            continue
        total += length_a + length_b - length[a] - length[b]
        over += change
        used += opened
        _move(orders, state, b, (first, along), (second, back))
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
        state.length[t] = _length_after(orders, state, t, (-1, -1), (-1, -1), words)


place = compile_kernel(_place)
