"""Run every kernel of the classical searches once, so that its machine code is in the cache."""

from __future__ import annotations

import math
import time

import numpy as np

from qrobot._extras import load
from qrobot.backends.base import Stop
from qrobot.backends.classical.generation import generate
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot
from qrobot.warehouse.scattered import Offer, network_of

__all__ = ["compile_searches"]


def compile_searches() -> float:
    """Compile the searches; return the seconds that it took.

    Raises
    ------
    MissingExtraError
        When numba or OR-Tools is not installed.
    """
    load("numba", "compiling the searches")
    begun = time.perf_counter()
    # These import numba.
    from qrobot.backends.classical.batching.aisle_lots import AisleTours
    from qrobot.backends.classical.generation.cuts import violated_cuts
    from qrobot.warehouse.labels import shortest_within
    from qrobot.warehouse.prices import relax

    for blocks in (1, 2):
        generate(_orders(blocks), Stop(max_work=4))
    AisleTours(_orders(1)).common(0, np.arange(1, 3))
    # A proof may end without a cut; three orders that share halves of batches always have one.
    halves, random = np.full(3, 0.5), np.random.default_rng(0)
    violated_cuts([(0, 1), (0, 2), (1, 2)], halves, 3, 1, 0.1, set(), random)
    offers = [Offer(0, Slot(aisle, aisle), 1) for aisle in range(3)]
    shortest_within(relax(network_of(AisleWarehouse(5, 9), offers, [2]), compiled=True), math.inf)
    return time.perf_counter() - begun


def _orders(blocks: int) -> Instance:
    """Return orders whose best batches take cuts and branches to prove."""
    items = [
        Item(f"{order}/{k}", 1, Slot((3 * order + 2 * k) % 5, (order * 5 + k * 7) % 9, k % blocks))
        for order in range(15)
        for k in range(2 + order % 3)
    ]
    orders = [
        Order(f"{order}", [item.id for item in items if item.id.startswith(f"{order}/")])
        for order in range(15)
    ]
    return Instance(
        warehouse=AisleWarehouse(5, 9, blocks),
        items=tuple(items),
        orders=tuple(orders),
        robots=(Robot("R1", 7, trips=15),),
    )
