"""Small instances with known optima, and the rules of a plan written out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Place,
    Point,
    Robot,
    Slot,
    Warehouse,
)

__all__ = ["Case", "cases", "scattered", "verify"]


@dataclass(frozen=True)
class Case:
    """An instance and the least distance of its plans, ``None`` when it has none."""

    name: str
    instance: Instance
    best: float | None


def verify(instance: Instance, routes: Sequence[Sequence[int]]) -> float:
    """Return the distance of routes, having checked every rule.

    Raises
    ------
    AssertionError
        When items are missing or collected twice, an order is split, there are more trips
        than the robots may make, or a robot is overloaded.
    """
    trips = [list(route) for route in routes if len(route)]
    nodes = sorted(v for route in trips for v in route)
    assert nodes == list(range(1, len(instance.items) + 1)), f"items collected: {nodes}"
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    trip_of = {v: t for t, route in enumerate(trips) for v in route}
    for order in instance.orders:
        assert len({trip_of[node[i]] for i in order.items}) == 1, f"order {order.id} is split"
    seats = sorted((r.capacity for r in instance.robots for _ in range(r.trips)), reverse=True)
    assert len(trips) <= len(seats), f"{len(trips)} trips for {len(seats)}"
    loads = sorted(
        (sum((instance.items[v - 1].weight for v in r), Fraction(0)) for r in trips), reverse=True
    )
    for load, seat in zip(loads, seats, strict=False):
        assert load <= seat, f"a load of {float(load):g} on a robot of {float(seat):g}"
    d = instance.distances
    return float(
        sum(d[a, b] for r in trips for a, b in itertools.pairwise([0, *(int(v) for v in r), 0]))
    )


@cache
def cases() -> tuple[Case, ...]:
    """Return small instances of every kind, each with its optimum found by trying all plans."""
    found = [
        ("one robot", _floor([3, 5, 2, 4, 1], [20])),
        ("tight", _floor([5, 4, 3, 5, 4, 3], [12, 12])),
        ("three robots", _floor([7, 6, 5, 4, 3], [9, 9, 9])),
        ("robots of two sizes", _floor([8, 3, 3, 2], [8, 8], sizes=[8, 9])),
        ("two trips", _floor([6, 5, 4, 2], [9], trips=2)),
        ("fractions", _floor([Fraction(1, 4), Fraction(5, 2), Fraction(3, 4)], [Fraction(3)] * 2)),
        ("no weight", _floor([0, 0, 0], [1, 1])),
        ("one place", _shared()),
        ("asymmetric", _table()),
        ("whole orders", _aisles()),
        ("nothing to do", _floor([], [5])),
        ("an item too heavy", _floor([11, 1], [10, 10])),
        ("no packing", _floor([6, 6, 6], [10, 10])),
    ]
    return tuple(Case(name, instance, _least(instance)) for name, instance in found)


def scattered(items: int) -> Instance:
    """Return a larger instance that takes a while."""
    rng = np.random.default_rng(5)
    weights = rng.integers(1, 11, items).tolist()
    room = -(-12 * sum(weights) // 50)
    return _instance(
        "scattered",
        OpenFloor(depot_x=50, depot_y=50),
        [Point(float(x), float(y)) for x, y in rng.uniform(0, 100, (items, 2))],
        [Fraction(w) for w in weights],
        [Robot(f"R{k + 1}", Fraction(room)) for k in range(5)],
    )


def _instance(
    name: str,
    warehouse: Warehouse,
    places: Sequence[Place],
    weights: Sequence[Fraction],
    robots: Sequence[Robot],
    orders: Sequence[Order] | None = None,
) -> Instance:
    ids = [f"i{k + 1}" for k in range(len(places))]
    return Instance(
        warehouse=warehouse,
        items=tuple(Item(i, w, p) for i, w, p in zip(ids, weights, places, strict=True)),
        orders=tuple(orders if orders is not None else [Order(i, (i,)) for i in ids]),
        robots=tuple(robots),
        name=name,
    )


def _floor(
    weights: Sequence[int | Fraction],
    capacities: Sequence[int | Fraction],
    *,
    sizes: Sequence[int] | None = None,
    trips: int = 1,
) -> Instance:
    rng = np.random.default_rng(len(weights))
    spots = rng.integers(0, 41, (len(weights), 2)).tolist()
    rooms = capacities if sizes is None else sizes
    return _instance(
        "floor",
        OpenFloor(depot_x=20, depot_y=0),
        [Point(x / 2, y / 2) for x, y in spots],
        [Fraction(w) for w in weights],
        [Robot(f"R{k + 1}", Fraction(c), trips=trips) for k, c in enumerate(rooms)],
    )


def _shared() -> Instance:
    return _instance(
        "one place",
        OpenFloor(),
        [Point(3, 4)] * 4,
        [Fraction(2)] * 4,
        [Robot("R1", Fraction(4)), Robot("R2", Fraction(4))],
    )


def _table() -> Instance:
    rng = np.random.default_rng(8)
    ways = rng.integers(5, 30, (6, 6)).astype(float)
    np.fill_diagonal(ways, 0.0)
    return _instance(
        "asymmetric",
        DistanceTable(matrix=tuple(tuple(row) for row in ways.tolist())),
        [Node(k) for k in range(1, 6)],
        [Fraction(w) for w in (2, 3, 2, 3, 2)],
        [Robot("R1", Fraction(7)), Robot("R2", Fraction(7))],
    )


def _aisles() -> Instance:
    slots = [(0, 1), (0, 4), (1, 2), (2, 0), (2, 4), (3, 3)]
    orders = [Order("A", ("i1", "i4")), Order("B", ("i2", "i3")), Order("C", ("i5", "i6"))]
    return _instance(
        "whole orders",
        AisleWarehouse(aisles=4, slots=5, blocks=1),
        [Slot(a, s) for a, s in slots],
        [Fraction(w) for w in (3, 2, 3, 2, 2, 3)],
        [Robot("R1", Fraction(10)), Robot("R2", Fraction(6))],
        orders,
    )


def _least(instance: Instance) -> float | None:
    """Return the least distance of any plan by trying all, ``None`` when there is none."""
    d = instance.distances.tolist()
    node = {item.id: i + 1 for i, item in enumerate(instance.items)}
    weight = {item.id: item.weight for item in instance.items}
    seats = [r.capacity for r in instance.robots for _ in range(r.trips)]

    @cache
    def tour(nodes: frozenset[int]) -> float:
        if not nodes:
            return 0.0
        return min(
            float(sum(d[a][b] for a, b in itertools.pairwise((0, *way, 0))))
            for way in itertools.permutations(nodes)
        )

    least = math.inf
    for deal in itertools.product(range(len(seats)), repeat=len(instance.orders)):
        loads = [Fraction(0)] * len(seats)
        carried: list[set[int]] = [set() for _ in seats]
        for order, seat in zip(instance.orders, deal, strict=True):
            loads[seat] += sum((weight[i] for i in order.items), Fraction(0))
            carried[seat] |= {node[i] for i in order.items}
        if all(load <= seat for load, seat in zip(loads, seats, strict=True)):
            least = min(least, sum(tour(frozenset(nodes)) for nodes in carried))
    return None if math.isinf(least) else least
