"""Whole orders in an aisle warehouse as the kernels take them, and batches of them as trips.

Importing this module imports numba; `takes` in `aisles` says whether it is of use.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import Routes
from qrobot.problem import AisleWarehouse, Instance, Slot
from qrobot.warehouse import Router
from qrobot.warehouse.kernels import Layout, least_length, masks_of, tour_length
from qrobot.warehouse.layouts import CODES, SHORTEST

__all__ = [
    "Batch",
    "Hashes",
    "Orders",
    "Trips",
    "lengths_of",
    "masks_of_orders",
    "orders_of",
    "tie_of",
]

Hashes = npt.NDArray[np.uint64]

Batch = tuple[int, ...]
"""Its orders, rising."""

NEIGHBOURS = 25
"""Orders whose common trips are tried with each order."""

ALL_PAIRS = 250
"""Orders up to which every pair gets its tour to find neighbours."""


class Orders(NamedTuple):
    """What is collected, and the trips.

    Parameters
    ----------
    masks
        Shape (orders, sub-aisles, words): their places.
    weights
        Shape (orders,).
    alone
        Shape (orders,): length of a trip for each alone, metres.
    least
        Shape (orders,): what a trip of each and others is no shorter than.
    most
        What the trips of a plan are no longer than together, metres.
    capacities
        Shape (trips,), largest first.
    near
        Shape (orders, neighbours): those that save most on a common trip, the best first.
    keys
        Shape (orders,): random odd numbers, for hashes of batches.
    layout
        The grid.
    """

    masks: Hashes
    weights: Ints
    alone: Floats
    least: Floats
    most: float
    capacities: Ints
    near: Ints
    keys: Hashes
    layout: Layout


def lengths_of(layout: Layout, masks: Hashes) -> Floats:
    """Return the length of a shortest tour for each row of words, metres."""
    return np.array([tour_length(words, layout) for words in masks])


def masks_of_orders(instance: Instance) -> tuple[Layout, Hashes]:
    """Return the grid and the places of each order, of an instance whose warehouse has aisles."""
    warehouse = instance.warehouse
    assert isinstance(warehouse, AisleWarehouse)
    picks = [
        [place for v in nodes if isinstance(place := instance.items[v - 1].place, Slot)]
        for nodes in instance.order_nodes
    ]
    return masks_of(warehouse, picks, CODES[instance.routing])


def orders_of(instance: Instance) -> Orders:
    """Return the orders of an instance whose warehouse has aisles."""
    layout, masks = masks_of_orders(instance)
    alone = lengths_of(layout, masks)
    random = np.random.default_rng(len(masks))
    keys = random.integers(0, 2**63, len(masks), dtype=np.uint64) * np.uint64(2) + np.uint64(1)
    return Orders(
        masks=masks,
        weights=instance.order_weights.astype(np.int64),
        alone=alone,
        least=np.array(
            [least_length(words, layout, own) for words, own in zip(masks, alone, strict=True)]
        ),
        most=_most(layout, alone, len(instance.vehicle_capacities)),
        capacities=instance.vehicle_capacities.astype(np.int64),
        near=_near(layout, masks, alone),
        keys=keys,
        layout=layout,
    )


def _most(layout: Layout, alone: Floats, trips: int) -> float:
    """Return what no plan is longer than.

    A shortest tour past two orders is no longer than those past each, but a way by a policy may be.
    None walks more than to and fro in every aisle, and, between going out and coming home, four
    times along a cross aisle for each block.
    """
    if layout.policy == SHORTEST:
        return float(alone.sum())
    blocks = layout.along.shape[1]
    width = float(layout.across[:-1, 0].sum())
    inside = 2.0 * float(layout.along.sum()) + float(layout.along[0].sum())
    longest = inside + (4 * blocks + 2) * width + 2.0 * float(layout.ways[0])
    return float(min(len(alone), trips) * longest)


def _near(layout: Layout, masks: Hashes, alone: Floats) -> Ints:
    """Return for each order those that save most on a common trip."""
    count = len(masks)
    if count == 1:
        return np.zeros((1, 1), dtype=np.int64)
    occupied = np.asarray(masks.any(axis=2), dtype=np.float64)
    # Sub-aisles in common stand for the saving where there are too many pairs.
    common = np.asarray(np.matmul(occupied, occupied.T), dtype=np.float64)
    many = np.count_nonzero(occupied, axis=1).astype(np.float64)
    likely = np.asarray(common / (many[:, None] + many - common))
    np.fill_diagonal(likely, -1.0)
    tried = count - 1 if count <= ALL_PAIRS else 2 * NEIGHBOURS
    near = np.argsort(-likely, axis=1, kind="stable")[:, :tried]
    saved = np.array(
        [
            alone[i] + alone[near[i]] - lengths_of(layout, masks[i] | masks[near[i]])
            for i in range(count)
        ]
    )
    best = np.argsort(-saved, axis=1, kind="stable")[:, :NEIGHBOURS]
    return np.take_along_axis(near, best, axis=1).astype(np.int64)


def tie_of(warehouse: AisleWarehouse, orders: Orders) -> float:
    """Return what a trip more may cost so that it decides between plans of one length only.

    Lengths of tours are sums of the layout's lengths, so they differ by a measure of these: by
    twice their greatest common one where a tour returns to the crossing that it came from, since
    it then crosses every line an even number of times. All trips together cost half of that.
    """
    lengths = (
        warehouse.aisle_pitch,
        warehouse.slot_pitch,
        *(gap for pair in warehouse.gaps for gap in pair),
        *(length for _, length in warehouse.doors),
    )
    parts = [Fraction(str(length)) for length in lengths if length > 0.0]
    below = lcm(*(part.denominator for part in parts))
    measure = Fraction(gcd(*(int(part * below) for part in parts)), below)
    half = float(measure) if len(warehouse.doors) == 1 else float(measure) / 2.0
    usual = float(orders.alone.mean()) if len(orders.alone) else 1.0
    return max(half, 1e-6 * usual) / (len(orders.weights) + 1)


class Trips:
    """Batches of an instance as routes, and routes as batches.

    Parameters
    ----------
    instance
        Its warehouse has aisles.
    """

    def __init__(self, instance: Instance) -> None:
        assert isinstance(instance.warehouse, AisleWarehouse)
        self._instance = instance
        self._router = Router(instance.warehouse)
        self._exact = instance.routing == "exact"
        self._known: dict[Batch, list[int]] = {}

    def routes(self, plan: Iterable[Batch]) -> Routes:
        """Return the routes of batches, each a shortest tour or that of the policy."""
        return [self._route(batch) for batch in plan if batch]

    def _route(self, batch: Batch) -> list[int]:
        known = self._known.get(batch)
        if known is None:
            nodes = [node for order in batch for node in self._instance.order_nodes[order]]
            if not self._exact:
                (known,) = self._instance.in_sequence([nodes])
            else:
                _, known = self._router.route(self._instance, nodes)
            self._known[batch] = known
        return known

    def batches(self, routes: Sequence[Sequence[int]]) -> list[Batch]:
        """Return the orders of each route."""
        owner = self._instance.order_of_node
        return [tuple(sorted({int(owner[node]) for node in route})) for route in routes]
