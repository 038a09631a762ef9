"""Batches of orders, each with its shortest tour, listed by depth-first search.

Importing this module imports numba. A batch is extended by orders of higher index only, so that
each is met once. A tour past more orders is never shorter, so the reduced cost of every batch
that contains the present one is at least the present length less the prices of its orders and of
the dearest orders that the capacity still takes. Where a policy may shorten a way by another pick,
the shortest tour takes the place of the length.
"""

from __future__ import annotations

import math
import time
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot._jit import compile_kernel
from qrobot.backends.base import Stop
from qrobot.backends.classical.orders import Hashes, Orders
from qrobot.warehouse.kernels import least_length, tour_length

__all__ = [
    "Pool",
    "Prices",
    "Work",
    "best_for_each",
    "count_batches",
    "find_batches",
    "reduced_costs",
    "room_table",
]

TOURS, TOUR_EFFORT = 20_000, 20
"""Tours between two looks at the clock, a tenth of a second; how many other steps one is worth."""

AT_ONCE = 4
"""Batches for each order that come into the linear programme together."""

BUCKETS = 1_000
"""Larger capacities are counted in coarser units in the bound, which stays valid."""


Members = npt.NDArray[np.signedinteger[Any]]
"""Shape (batches, width): orders, -1 after the last."""


class Pool(NamedTuple):
    """Batches.

    Parameters
    ----------
    members
        Shape (batches, width): their orders, -1 after the last.
    lengths, loads
        Shape (batches,).
    """

    members: Members
    lengths: Floats
    loads: Ints

    def take(self, rows: Any) -> Pool:
        """Return some of them."""
        return Pool(self.members[rows], self.lengths[rows], self.loads[rows])


class Prices(NamedTuple):
    """What a batch is paid: duals of a set partition.

    Parameters
    ----------
    orders
        Shape (orders,).
    loads, trips
        Shape (fleet rows,): a batch heavier than this pays that for the robot which it needs.
    cuts, divisors
        Shape (cuts,): what a batch pays each time that it counts in a cut, and what the sum of
        multipliers is divided by.
    cuts_of, multipliers, first_cut
        The cuts of each order with its multiplier, and where those of each order begin.
    """

    orders: Floats
    loads: Ints
    trips: Floats
    cuts: Floats
    divisors: Ints
    cuts_of: Ints
    multipliers: Ints
    first_cut: Ints


def count_batches(weights: Ints, capacity: int, lightest: int = 0) -> float:
    """Return how many sets of orders fit on one robot and weigh at least `lightest`."""
    scale = max(1, -(-capacity // BUCKETS))
    room = capacity // scale
    counts = np.zeros(room + 1)
    counts[0] = 1.0
    for weight in (weights // scale).tolist():
        if weight <= room:
            counts[weight:] += counts[: room + 1 - weight].copy()
    return float(counts[lightest // scale :].sum()) - (lightest < scale)


def room_table(weights: Ints, prices: Floats, capacity: int) -> tuple[Floats, int]:
    """Return the most that orders k and later can be paid in a room r, and the unit of r.

    Returns
    -------
    tuple
        Shape (orders + 1, rooms + 1), and how many units of weight one room is.
    """
    scale = max(1, -(-capacity // BUCKETS))
    room = capacity // scale
    table = np.zeros((len(weights) + 1, room + 1))
    for k in reversed(range(len(weights))):
        weight = int(weights[k]) // scale  # rounded down: more seems to fit than does
        table[k] = table[k + 1]
        if prices[k] > 0.0 and weight <= room:
            more = table[k + 1, : room + 1 - weight] + prices[k]
            table[k, weight:] = np.maximum(table[k, weight:], more)
    return table, scale


def _trip_price(load: int, prices: Prices) -> float:
    """Return what a batch pays for the robot that it needs."""
    paid = 0.0
    for k in range(len(prices.loads)):
        if load > prices.loads[k]:
            paid += prices.trips[k]
    return paid


_trip_price = compile_kernel(_trip_price, inner=True)


def _count(prices: Prices, order: int, within: Ints) -> float:
    """Add an order to the sums of its cuts; return what the batch pays more."""
    paid = 0.0
    for k in range(prices.first_cut[order], prices.first_cut[order + 1]):
        cut = prices.cuts_of[k]
        before = within[cut] // prices.divisors[cut]
        within[cut] += prices.multipliers[k]
        paid += prices.cuts[cut] * (within[cut] // prices.divisors[cut] - before)
    return paid


_count = compile_kernel(_count, inner=True)


def _uncount(prices: Prices, order: int, within: Ints) -> None:
    """Take an order from the sums of its cuts."""
    for k in range(prices.first_cut[order], prices.first_cut[order + 1]):
        within[prices.cuts_of[k]] -= prices.multipliers[k]


_uncount = compile_kernel(_uncount, inner=True)


class Walk(NamedTuple):
    """Where a depth-first search stands, so that it can be continued.

    Parameters
    ----------
    words, load, paid, length
        Of the batch at each depth; length: what no batch that contains it is shorter than.
    chosen, following
        Order that leads on from each depth, and the next one to try there.
    within
        Shape (cuts,): sums of multipliers of the present batch.
    at
        Depth (-1 at the end), and how many batches were found.
    least
        The least reduced cost found so far.
    """

    words: Hashes
    load: Ints
    paid: Floats
    length: Floats
    chosen: Ints
    following: Ints
    within: Ints
    at: Ints
    least: Floats


def new_walk(orders: Orders, prices: Prices, width: int) -> Walk:
    """Return the beginning of a search for batches of at most so many orders."""
    depths = width + 1
    return Walk(
        words=np.zeros((depths, *orders.masks.shape[1:]), dtype=np.uint64),
        load=np.zeros(depths, dtype=np.int64),
        paid=np.zeros(depths),
        length=np.zeros(depths),
        chosen=np.zeros(depths, dtype=np.int64),
        following=np.zeros(depths, dtype=np.int64),
        within=np.zeros(len(prices.cuts), dtype=np.int64),
        at=np.zeros(2, dtype=np.int64),
        least=np.full(1, np.inf),
    )


def _list_batches(
    orders: Orders,
    prices: Prices,
    table: Floats,
    scale: int,
    below: float,
    lightest: int,
    walk: Walk,
    effort: int,
    members: Members,
    lengths: Floats,
    loads: Ints,
) -> None:
    """Write the batches of a reduced cost below a limit, until the room for them is full.

    Parameters
    ----------
    orders
        The question.
    prices
        What batches are paid.
    table, scale
        From `room_table`.
    below
        The limit, metres.
    lightest
        Batches of less load are left out.
    walk
        Where the search stands; changed.
    effort
        What is done before it pauses: a step counts once, a tour as often as `TOUR_EFFORT`.
    members, lengths, loads
        Room for batches.
    """
    count, width, most = len(orders.weights), members.shape[1], len(lengths)
    weights, alone, capacity = orders.weights, orders.least, orders.capacities[0]
    words, load, paid, length = walk.words, walk.load, walk.paid, walk.length
    chosen, following, within = walk.chosen, walk.following, walk.within
    depth, found = walk.at
    least = walk.least[0]
    while depth >= 0 and effort > 0 and found < most:
        effort -= 1
        order = following[depth]
        if order >= count or depth == width:
            depth -= 1
            if depth >= 0:
                _uncount(prices, chosen[depth], within)
            continue
        following[depth] = order + 1
        heavy = load[depth] + weights[order]
        if heavy > capacity:
            continue
        gain = paid[depth] + prices.orders[order]
        more = table[order + 1, (capacity - heavy) // scale]
        trip = _trip_price(heavy, prices)
        if max(length[depth], alone[order]) - gain - trip - more >= below:
            continue
        gain += _count(prices, order, within)
        for part in range(words.shape[1]):
            for w in range(words.shape[2]):
                words[depth + 1, part, w] = words[depth, part, w] | orders.masks[order, part, w]
        tour = tour_length(words[depth + 1], orders.layout)
        effort -= TOUR_EFFORT
        reduced, shortest = tour - gain - trip, least_length(words[depth + 1], orders.layout, tour)
        chosen[depth] = order
        if reduced < below and heavy >= lightest:
            least = min(least, reduced)
            for k in range(width):
                members[found, k] = chosen[k] if k <= depth else -1
            lengths[found], loads[found] = tour, heavy
            found += 1
        if shortest - gain - trip - more >= below:
            _uncount(prices, order, within)
            continue
        load[depth + 1], paid[depth + 1], length[depth + 1] = heavy, gain, shortest
        following[depth + 1] = order + 1
        depth += 1
    walk.at[0], walk.at[1] = depth, found
    walk.least[0] = least


list_batches = compile_kernel(_list_batches)


class Work(Stop):
    """A stop that counts the work itself: linear programmes, and lists of `TOURS` tours."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(None, stop.max_work, parent=stop)
        self._until = stop
        self.done = 0

    def __call__(self, work: int = 0) -> bool:
        """Return True when it is time to stop."""
        return self._until(max(work, self.done))

    def affords(self, lists: float, seconds: float) -> bool:
        """Return whether there is work and time for so many lists."""
        left = math.inf if self.max_work is None else self.max_work - self.done
        return lists <= left and seconds <= self.remaining


def find_batches(
    orders: Orders,
    prices: Prices,
    below: float,
    lightest: int,
    room: Pool,
    stop: Work,
    expected: float = 0.0,
) -> tuple[Pool, float]:
    """Return batches below a reduced cost, and the least of all.

    Parameters
    ----------
    orders, prices
        The question, and what batches are paid.
    below
        The limit, metres.
    lightest
        Batches of less load are left out.
    room
        Where batches are written; the search ends when it is full.
    stop
        Deadline and interrupts.
    expected
        How many there are: the search ends early when its pace shows that time is too short.

    Returns
    -------
    tuple
        The batches, and the least reduced cost; ``-inf`` where the search ended early.
    """
    table, scale = room_table(orders.weights, prices.orders, int(orders.capacities[0]))
    walk = new_walk(orders, prices, room.members.shape[1])
    began = time.perf_counter()
    while walk.at[0] >= 0 and walk.at[1] < len(room.lengths) and not stop():
        list_batches(
            orders, prices, table, scale, below, lightest, walk, TOURS * TOUR_EFFORT, *room
        )
        stop.done += 1
        found = int(walk.at[1])
        if expected and found >= TOURS // 2:
            left = expected - found
            if not stop.affords(left / TOURS, (time.perf_counter() - began) / found * left):
                break
    least = float(walk.least[0]) if walk.at[0] < 0 else -math.inf
    return room.take(slice(int(walk.at[1]))), least


def _reduced_costs(
    members: Members, lengths: Floats, loads: Ints, prices: Prices, reduced: Floats
) -> None:
    """Write the reduced cost of each batch."""
    within = np.zeros(len(prices.cuts), dtype=np.int64)
    for row in range(len(lengths)):
        total = lengths[row] - _trip_price(loads[row], prices)
        for k in range(members.shape[1]):
            order = members[row, k]
            if order < 0:
                break
            total -= prices.orders[order] + _count(prices, order, within)
        for k in range(members.shape[1]):
            order = members[row, k]
            if order < 0:
                break
            _uncount(prices, order, within)
        reduced[row] = total


_reduced_costs = compile_kernel(_reduced_costs)


def reduced_costs(pool: Pool, prices: Prices) -> Floats:
    """Return the reduced cost of each batch, shape (batches,)."""
    reduced = np.empty(len(pool.lengths))
    _reduced_costs(*pool, prices, reduced)
    return reduced


def best_for_each(members: Members, reduced: Floats, count: int) -> npt.NDArray[np.intp]:
    """Return the rows of the batches of least negative reduced cost for each order."""
    rows = np.flatnonzero(reduced < 0.0)
    if len(rows) > 200 * count:
        rows = rows[np.argpartition(reduced[rows], 200 * count)[: 200 * count]]
    rows = rows[np.argsort(reduced[rows], kind="stable")]
    taken, kept = np.zeros(count, dtype=np.int64), []
    for row in rows.tolist():
        batch = members[row][members[row] >= 0]
        if (taken[batch] < AT_ONCE).any():
            taken[batch] += 1
            kept.append(row)
    return np.array(kept, dtype=np.intp)
