"""What the annealing of batches works on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from qrobot._arrays import Floats, Ints
from qrobot.backends.classical.orders import Hashes, Orders

__all__ = ["KNOWN_BITS", "State", "new_state"]

KNOWN_BITS = 20
"""Lengths of 2^20 batches are remembered (16 MB)."""


class State(NamedTuple):
    """A plan of the search; all arrays are changed in place.

    Parameters
    ----------
    trip
        Shape (orders,): of each order its trip.
    members, size
        Shapes (trips, orders) and (trips,): the orders of each trip.
    at
        Shape (orders,): where an order stands among those of its trip.
    load, length, key
        Shape (trips,) each.
    without
        Shape (orders,): length of the trip of each order without it; -1: not known yet.
    random
        Shape (1,): the generator's state.
    known_keys, known_lengths
        Remembered lengths.
    best
        Shape (orders,): trips of the best plan without overload.
    figures
        Shape (3,): price of a unit of overload, cost of the best plan (length and ties), and the
        length of a trip more that decides between plans of one length.
    pool_keys, pool, pool_size
        Hashes of the batches kept, their orders (-1 after the last), and how many there are.
    """

    trip: Ints
    members: Ints
    size: Ints
    at: Ints
    load: Ints
    length: Floats
    key: Hashes
    without: Floats
    random: Hashes
    known_keys: Hashes
    known_lengths: Floats
    best: Ints
    figures: Floats
    pool_keys: Hashes
    pool: Ints
    pool_size: Ints


def new_state(orders: Orders, tie: float, seed: int, pool: int) -> State:
    """Return a state without a plan yet.

    Parameters
    ----------
    orders
        The question.
    tie
        What a trip more costs, metres.
    seed
        Of the generator.
    pool
        Most batches to keep.
    """
    count, trips = len(orders.weights), len(orders.capacities)
    return State(
        trip=np.zeros(count, dtype=np.int64),
        members=np.zeros((trips, count), dtype=np.int64),
        size=np.zeros(trips, dtype=np.int64),
        at=np.zeros(count, dtype=np.int64),
        load=np.zeros(trips, dtype=np.int64),
        length=np.zeros(trips),
        key=np.zeros(trips, dtype=np.uint64),
        without=np.full(count, -1.0),
        random=np.array([2 * seed + 1], dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15),
        known_keys=np.zeros(1 << KNOWN_BITS, dtype=np.uint64),
        known_lengths=np.zeros(1 << KNOWN_BITS),
        best=np.full(count, -1, dtype=np.int64),
        figures=np.array([1.0, np.inf, tie]),
        pool_keys=np.zeros(1 << int(2 * pool - 1).bit_length(), dtype=np.uint64),
        pool=np.full((pool, 24), -1, dtype=np.int64),
        pool_size=np.zeros(1, dtype=np.int64),
    )
