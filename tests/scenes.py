"""Instances and plans to draw; used by the tests of pictures.

>>> from scenes import CASES, question, shared
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from qrobot.plan import Plan
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

__all__ = ["CASES", "LAYOUT", "points", "question", "shared", "slots"]


def question(house: Warehouse, places: list[Place], robots: int = 3, **names: object) -> Instance:
    items = tuple(Item(f"i{k + 1}", Fraction(k % 3 + 1), p) for k, p in enumerate(places))
    return Instance(
        warehouse=house,
        items=items,
        orders=tuple(Order(i.id, (i.id,)) for i in items),
        robots=tuple(Robot(f"R{k + 1}", Fraction(5 * len(items) + 5)) for k in range(robots)),
        **names,  # type: ignore[arg-type]
    )


def slots(layout: AisleWarehouse, count: int) -> list[Place]:
    rng = np.random.default_rng(4)
    spots = [
        (a, b)
        for a in range(layout.aisles)
        for b in range(layout.blocks)
        if (a, b) not in layout.closed_aisles
    ]
    return [
        Slot(*(int(v) for v in (a, rng.integers(layout.slots), b)), ("left", "right")[k % 2])
        for k, (a, b) in enumerate(spots[int(i)] for i in rng.integers(len(spots), size=count))
    ]


def points(count: int) -> list[Place]:
    rng = np.random.default_rng(5)
    return [Point(float(x), float(y)) for x, y in rng.permutation(2500)[:count, None] % (50, 49)]


def shared(instance: Instance, trips: int = 3) -> Plan:
    nodes = list(range(1, instance.size + 1))
    return Plan.from_routes(instance, [nodes[k::trips] for k in range(trips)])


LAYOUT = AisleWarehouse(aisles=8, slots=10, blocks=2, depot_aisle=3, depot_distance=2.0)
CLOSED = replace(
    LAYOUT, closed_aisles=frozenset({(2, 0), (5, 1)}), closed_crossings=frozenset({(1, 2)})
)
TABLE = DistanceTable(tuple(tuple(float(abs(i - j)) for j in range(8)) for i in range(8)))

CASES = {
    "aisles": question(LAYOUT, slots(LAYOUT, 20)),
    "closed": question(CLOSED, slots(CLOSED, 14)),
    "euclid": question(OpenFloor(20.0, 20.0), points(12)),
    "manhattan": question(OpenFloor(20.5, 20.5, metric="manhattan"), points(12)),
    "table": question(TABLE, [Node(k) for k in range(1, 8)]),
    "there and back": question(OpenFloor(), [Point(3, 4), Point(5, 0), Point(0, 7)]),
    "many": question(LAYOUT, slots(LAYOUT, 60), robots=20),
}
