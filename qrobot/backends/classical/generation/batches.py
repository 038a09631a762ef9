"""Batches of orders, each with its shortest tour, listed by depth-first search.

Importing this module imports numba. A batch is extended by orders of higher index only, so that
each is met once. A tour past more orders is never shorter, so the reduced cost of every batch
that contains the present one is at least the present length less the prices of its orders and of
the dearest orders that the capacity still takes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot._jit import compile_kernel
from qrobot.backends.classical.orders import Orders
from qrobot.warehouse.kernels import tour_length

__all__ = [
    "Pool",
    "Prices",
    "best_for_each",
    "count_batches",
    "list_batches",
    "reduced_costs",
    "room_table",
]

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


def count_batches(weights: Ints, capacity: int) -> float:
    """Return how many sets of orders fit on one robot: without regard to tours."""
    scale = max(1, -(-capacity // BUCKETS))
    room = capacity // scale
    counts = np.zeros(room + 1)
    counts[0] = 1.0
    for weight in (weights // scale).tolist():
        if weight <= room:
            counts[weight:] += counts[: room + 1 - weight].copy()
    return float(counts.sum()) - 1.0


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
            np.maximum(
                table[k, weight:], table[k + 1, : room + 1 - weight] + prices[k], table[k, weight:]
            )
    return table, scale


def _trip_price(load: int, prices: Prices) -> float:
    """Return what a batch pays for the robot that it needs."""
    paid = 0.0
    for k in range(len(prices.loads)):
        if load > prices.loads[k]:
            paid += prices.trips[k]
    return paid


_trip_price = compile_kernel(_trip_price)


def _count(prices: Prices, order: int, within: Ints) -> float:
    """Add an order to the sums of its cuts; return what the batch pays more."""
    paid = 0.0
    for k in range(prices.first_cut[order], prices.first_cut[order + 1]):
        cut = prices.cuts_of[k]
        before = within[cut] // prices.divisors[cut]
        within[cut] += prices.multipliers[k]
        paid += prices.cuts[cut] * (within[cut] // prices.divisors[cut] - before)
    return paid


_count = compile_kernel(_count)


def _uncount(prices: Prices, order: int, within: Ints) -> None:
    """Take an order from the sums of its cuts."""
    for k in range(prices.first_cut[order], prices.first_cut[order + 1]):
        within[prices.cuts_of[k]] -= prices.multipliers[k]


_uncount = compile_kernel(_uncount)


def _list_batches(
    orders: Orders,
    prices: Prices,
    table: Floats,
    scale: int,
    below: float,
    most: int,
    members: Members,
    lengths: Floats,
    loads: Ints,
) -> tuple[int, float]:
    """Write the batches of a reduced cost below a limit.

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
    most
        Ends when so many were found.
    members, lengths, loads
        Room for them.

    Returns
    -------
    tuple
        How many were found, and the least reduced cost of all (``inf`` when there is none).
    """
    count, width = len(orders.weights), members.shape[1]
    capacity = orders.capacities[0]
    words = np.zeros((width + 1, orders.masks.shape[1], orders.masks.shape[2]), dtype=np.uint64)
    load = np.zeros(width + 1, dtype=np.int64)
    paid = np.zeros(width + 1)
    length = np.zeros(width + 1)
    chosen = np.zeros(width + 1, dtype=np.int64)
    following = np.zeros(width + 1, dtype=np.int64)
    within = np.zeros(len(prices.cuts), dtype=np.int64)
    found, least = 0, np.inf
    depth = 0
    while depth >= 0:
        order = following[depth]
        if order >= count or depth == width:
            depth -= 1
            if depth >= 0:
                _uncount(prices, chosen[depth], within)
            continue
        following[depth] = order + 1
        heavy = load[depth] + orders.weights[order]
        if heavy > capacity:
            continue
        gain = paid[depth] + prices.orders[order]
        room = (capacity - heavy) // scale
        more = table[order + 1, room]
        trip = _trip_price(heavy, prices)
        if max(length[depth], orders.alone[order]) - gain - trip - more >= below:
            continue
        gain += _count(prices, order, within)
        words[depth + 1] = words[depth] | orders.masks[order]
        tour = tour_length(words[depth + 1], orders.layout)
        reduced = tour - gain - trip
        if reduced < below:
            least = min(least, reduced)
            if found < most:
                for k in range(depth):
                    members[found, k] = chosen[k]
                members[found, depth] = order
                members[found, depth + 1 :] = -1
                lengths[found], loads[found] = tour, heavy
            found += 1
            if found == most:
                break
        if reduced - more >= below:
            _uncount(prices, order, within)
            continue
        chosen[depth] = order
        load[depth + 1], paid[depth + 1], length[depth + 1] = heavy, gain, tour
        following[depth + 1] = order + 1
        depth += 1
    return found, least


list_batches = compile_kernel(_list_batches)


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
