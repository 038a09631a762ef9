"""Hypothesis strategies for small, valid instances; used by the tests of every room.

>>> from strategies import instances
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from fractions import Fraction

from hypothesis import strategies as st

from qrobot.errors import InputError
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

__all__ = ["KINDS", "aisle_warehouses", "instances", "warehouses_with_places", "weights"]

KINDS = ("aisles", "floor", "matrix")

lengths = st.integers(1, 40).map(lambda quarters: quarters / 4)
"""Metres whose sums are exact in binary, so that ties are ties."""


def weights(*, zero: bool = True) -> st.SearchStrategy[Fraction]:
    """Draw a weight as warehouses have them: whole, or with up to three decimals."""
    low = 0 if zero else 1
    return st.one_of(
        st.integers(low, 12).map(Fraction),
        st.integers(low, 48).map(lambda n: Fraction(n, 4)),
        st.integers(low, 120).map(lambda n: Fraction(n, 10)),
        st.integers(low, 12_000).map(lambda n: Fraction(n, 1000)),
    )


@st.composite
def aisle_warehouses(
    draw: st.DrawFn, *, closed: bool = False, one_way: bool = False
) -> AisleWarehouse:
    """Draw a layout; some of its segments may be closed, or one-way."""
    aisles, blocks = draw(st.integers(1, 5)), draw(st.integers(1, 3))
    sub_aisles = [(a, b) for a in range(aisles) for b in range(blocks)]
    segments = [(c, a) for c in range(blocks + 1) for a in range(aisles - 1)]
    gaps = st.tuples(*[st.tuples(lengths, lengths)] * blocks)
    house = AisleWarehouse(
        aisles=aisles,
        blocks=blocks,
        slots=draw(st.integers(1, 6)),
        aisle_pitch=draw(lengths),
        slot_pitch=draw(lengths),
        end_gap=draw(lengths),
        depot_aisle=draw(st.integers(0, aisles - 1)),
        depot_cross_aisle=draw(st.integers(0, blocks)),
        depot_distance=draw(st.sampled_from([0.0, 0.5, 3.0])),
        closed_aisles=draw(_some_of(sub_aisles) if closed else st.just(frozenset())),
        closed_crossings=draw(_some_of(segments) if closed else st.just(frozenset())),
        block_gaps=draw(st.just(()) | gaps),
    )
    house = draw(_with_depot_ways(house) | _between_aisles(house))
    if not one_way:
        return house
    along = draw(_some_of([part for part in sub_aisles if part not in house.closed_aisles]))
    across = draw(_some_of([part for part in segments if part not in house.closed_crossings]))
    try:
        return dataclasses.replace(
            house,
            one_way_aisles=frozenset(
                (*part, draw(st.sampled_from(["front", "back"]))) for part in along
            ),
            one_way_crossings=frozenset(
                (*part, draw(st.sampled_from(["left", "right"]))) for part in across
            ),
        )
    except InputError:  # ways of the depot would be a short cut
        return house


@st.composite
def _with_depot_ways(draw: st.DrawFn, house: AisleWarehouse) -> AisleWarehouse:
    """Draw further ways from the depot, none shorter than straight on."""
    others = [aisle for aisle in range(house.aisles) if aisle != house.depot_aisle]
    if not others or draw(st.booleans()):
        return house
    shorter = st.sampled_from([0.0, house.depot_distance / 2, house.depot_distance])
    ways = tuple(
        (a, house.aisle_pitch * abs(a - house.depot_aisle) + house.depot_distance - draw(shorter))
        for a in draw(st.lists(st.sampled_from(others), unique=True))
    )
    try:
        return dataclasses.replace(house, depot_ways=ways)
    except InputError:  # where a cross aisle is closed, they would be a short cut
        return house


def _between_aisles(house: AisleWarehouse) -> st.SearchStrategy[AisleWarehouse]:
    """Move the depot between two aisles, where the segment is there and open."""
    segment = house.depot_cross_aisle, house.depot_aisle
    if house.depot_aisle == house.aisles - 1 or segment in house.closed_crossings:
        return st.just(house)
    part = st.sampled_from([0.25, 0.5, 0.75])
    return part.map(lambda p: dataclasses.replace(house, depot_offset=p * house.aisle_pitch))


def _some_of(
    candidates: Sequence[tuple[int, int]],
) -> st.SearchStrategy[frozenset[tuple[int, int]]]:
    if not candidates:
        return st.just(frozenset())
    return st.frozensets(st.sampled_from(candidates), max_size=4)


@st.composite
def warehouses_with_places(
    draw: st.DrawFn, *, count: int, kinds: Sequence[str] = KINDS
) -> tuple[Warehouse, list[Place]]:
    """Draw a warehouse and `count` places in it, all reachable, some perhaps shared."""
    kind = draw(st.sampled_from(list(kinds)))
    places: list[Place]
    if kind == "aisles":
        layout = draw(aisle_warehouses())
        places = [
            Slot(
                aisle=draw(st.integers(0, layout.aisles - 1)),
                block=draw(st.integers(0, layout.blocks - 1)),
                slot=draw(st.integers(0, layout.slots - 1)),
                side=draw(st.sampled_from(["left", "right"])),
            )
            for _ in range(count)
        ]
        return layout, places
    if kind == "floor":
        coordinate = st.integers(-40, 40).map(lambda quarters: quarters / 4)
        floor = OpenFloor(
            depot_x=draw(coordinate),
            depot_y=draw(coordinate),
            metric=draw(st.sampled_from(["euclidean", "manhattan"])),
            rounding=draw(st.sampled_from(["none", "nearest"])),
        )
        return floor, [Point(draw(coordinate), draw(coordinate)) for _ in range(count)]
    depot = draw(st.integers(0, count))
    table = DistanceTable(matrix=draw(matrices(count + 1)), depot_node=depot)
    return table, [Node(i) for i in range(count + 1) if i != depot]


@st.composite
def matrices(draw: st.DrawFn, size: int) -> tuple[tuple[float, ...], ...]:
    """Draw a distance matrix: symmetric or not, metric or not."""
    symmetric = draw(st.booleans())
    rows = [[0.0] * size for _ in range(size)]
    for i in range(size):
        for j in range(size):
            if i < j or (i > j and not symmetric):
                rows[i][j] = float(draw(st.integers(1, 40)))
            elif i > j:
                rows[i][j] = rows[j][i]
    return tuple(map(tuple, rows))


@st.composite
def instances(
    draw: st.DrawFn,
    *,
    min_items: int = 0,
    max_items: int = 7,
    max_robots: int = 3,
    whole_orders: bool | None = None,
    kinds: Sequence[str] = KINDS,
    heterogeneous: bool | None = None,
    multi_trip: bool = False,
    feasible: bool = False,
) -> Instance:
    """Draw a small valid instance, whose fleet may be too small for it.

    Parameters
    ----------
    min_items, max_items
        Bounds of the number of items.
    max_robots
        Bound of the number of robots.
    whole_orders
        True: orders may hold several items; False: every item is its own order; None: both.
    kinds
        Kinds of warehouse to draw from: ``aisles``, ``floor``, ``matrix``.
    heterogeneous
        True: robots differ in capacity and speed; False: all alike; None: both.
    multi_trip
        Whether robots may make up to three trips.
    feasible
        True gives each robot room for everything, so that some plan always exists.
    """
    count = draw(st.integers(min_items, max_items))
    warehouse, places = draw(warehouses_with_places(count=count, kinds=kinds))
    items = tuple(Item(f"i{n + 1}", draw(weights()), place) for n, place in enumerate(places))
    orders = draw(_orders(items, draw(st.booleans()) if whole_orders is None else whole_orders))
    total = sum((item.weight for item in items), Fraction(0))
    heaviest = max((_load(order, items) for order in orders), default=Fraction(0))
    fleet = draw(st.integers(1, max_robots))
    differ = draw(st.booleans()) if heterogeneous is None else heterogeneous
    # From tight (a tenth of slack, which packing may not allow) to roomy.
    share = draw(st.sampled_from([Fraction(11, 10), Fraction(3, 2), Fraction(3)]))
    fair = max(heaviest, total * share / fleet, Fraction(1, 2))
    capacity = max(total, Fraction(1)) if feasible else _rounded_up(fair)
    robots = tuple(
        Robot(
            id=f"R{k + 1}",
            capacity=capacity * (draw(st.integers(4, 8)) if differ and k else 4) / 4,
            speed=draw(st.sampled_from([0.5, 1.0, 1.5])) if differ else 1.0,
            trips=draw(st.integers(1, 3)) if multi_trip else 1,
        )
        for k in range(fleet)
    )
    return Instance(warehouse=warehouse, items=items, orders=orders, robots=robots, name="drawn")


@st.composite
def _orders(draw: st.DrawFn, items: Sequence[Item], whole: bool) -> tuple[Order, ...]:
    if not whole:
        return tuple(Order(item.id, (item.id,)) for item in items)
    lots: dict[int, list[str]] = {}
    for item in items:
        lots.setdefault(draw(st.integers(0, max(len(items) // 2, 0))), []).append(item.id)
    return tuple(Order(f"o{n + 1}", tuple(ids)) for n, ids in enumerate(lots.values()))


def _load(order: Order, items: Sequence[Item]) -> Fraction:
    return sum((item.weight for item in items if item.id in order.items), Fraction(0))


def _rounded_up(value: Fraction) -> Fraction:
    """Return the value with one decimal, as people write capacities."""
    return Fraction(-((-value * 10) // 1), 10)
