"""What an instance refuses, however it was made, and what it derives."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from strategies import instances

from qrobot.errors import InputError
from qrobot.problem import (
    MAX_ITEMS,
    MAX_STOPS,
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

FLOOR = OpenFloor()
AISLES = AisleWarehouse(aisles=2, slots=3)
R1 = Robot("R1", 10)  # type: ignore[arg-type]


def make(
    *places: Place,
    warehouse: Warehouse = FLOOR,
    weight: Any = 1,
    orders: tuple[Order, ...] | None = None,
    robots: tuple[Robot, ...] = (R1,),
) -> Instance:
    items = tuple(Item(f"i{n}", weight, place) for n, place in enumerate(places))
    lots = tuple(Order(i.id, (i.id,)) for i in items) if orders is None else orders
    return Instance(warehouse, items, lots, robots)


A, B = Point(1, 1), Point(2, 2)


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (
            lambda: make(A, weight=-3),
            "items[0].weight: weight -3 of item 'i0' is negative; use zero",
        ),
        (lambda: make(A, weight=math.nan), "weight: nan is not a finite number; use"),
        (lambda: make(A, weight=1e13), "weight: 10000000000000.0 is larger than 1e+12"),
        (lambda: make(A, robots=()), "robots: no robots; give at least one robot"),
        (lambda: make(A, robots=(R1, R1)), "robots[1].id: the id 'R1' is used twice; give"),
        (lambda: make(A, robots=(Robot("R", 0),)), "robots[0].capacity: capacity 0 of robot"),  # type: ignore
        (lambda: make(A, robots=(Robot("R", 1, 0.0),)), "robots[0].speed: speed 0 of robot"),  # type: ignore
        (lambda: make(A, robots=(Robot("R", 1, math.nan),)), "robots[0].speed: speed nan"),  # type: ignore
        (lambda: make(A, robots=(Robot("R", 1, 1.0, 0),)), "robots[0].trips: 0 trips"),  # type: ignore
        (lambda: make(A, orders=()), "orders: items i0 are in no order; put every item"),
        (lambda: make(A, orders=(Order("o", ()),)), "orders[0].items: order 'o' is empty; name"),
        (lambda: make(A, orders=(Order("o", ("x",)),)), "orders[0].items[0]: order 'o' names"),
        (
            lambda: make(A, orders=(Order("o", ("i0", "i0")),)),
            "orders[0].items[1]: item 'i0' is in",
        ),
        (lambda: make(Slot(0, 0)), "items[0].at: slot 0 of aisle 0, block 0 is not a coordinate"),
        (lambda: make(Point(math.nan, 0)), "items[0].at.x: nan is not -1e+09 to 1e+09"),
        (lambda: make(A, warehouse=AISLES), "items[0].at: coordinate (1, 1) is not a slot"),
        (lambda: make(Slot(2, 0), warehouse=AISLES), "items[0].at.aisle: aisle 2 is outside"),
        (lambda: make(Slot(0, 3), warehouse=AISLES), "items[0].at.slot: slot 3 is outside the"),
        (lambda: make(Slot(0, 0, 1), warehouse=AISLES), "items[0].at.block: block 1 is outside"),
        (lambda: make(Slot(-1, 0), warehouse=AISLES), "items[0].at.aisle: aisle -1 is outside"),
        (lambda: make(Node(1), warehouse=DistanceTable(((0,),))), "items[0].at.node: node 1 is"),
        (
            lambda: make(A, warehouse=DistanceTable(((0,),))),
            "items[0].at: coordinate (1, 1) is not",
        ),
        (lambda: make(A).with_robots(0), "robots: 0 robots are too few; give 1 or more, or 'free'"),
        (lambda: make(A).with_robots(10**9), "robots: 1000000000 robots are more than 20000"),
        (lambda: make(*[A] * (MAX_ITEMS + 1)), "items: 20001 items are more than the 20000"),
        (
            lambda: make(*[Point(n, 0) for n in range(MAX_STOPS + 1)]),
            "orders: 2501 stops (places of each order) are more than the 2500 that one plan",
        ),
        (lambda: AisleWarehouse(aisles=0, slots=1), "aisles: 0 is not 1 to 4000; correct"),
        (lambda: AisleWarehouse(aisles=1, slots=0), "slots: 0 is not 1 to 10000; correct"),
        (lambda: AisleWarehouse(aisles=1, slots=1, blocks=0), "blocks: 0 is not 1 to 4000"),
        (lambda: AisleWarehouse(aisles=4000, slots=1), "aisles: 8000 crossings are more than 4000"),
        (lambda: AisleWarehouse(aisles=1, slots=1, aisle_pitch=0), "aisle_pitch: 0 is not 0.001"),
        (lambda: AisleWarehouse(aisles=1, slots=1, slot_pitch=math.inf), "slot_pitch: inf is not"),
        (lambda: AisleWarehouse(aisles=1, slots=1, end_gap=-1), "end_gap: -1 is not 0 to 1e+06"),
        (lambda: AisleWarehouse(aisles=1, slots=1, end_gap=0), "end_gap: 0 leaves no aisle; use"),
        (lambda: AisleWarehouse(aisles=1, slots=1, depot_aisle=1), "depot.aisle: 1 is outside"),
        (lambda: AisleWarehouse(aisles=1, slots=1, depot_cross_aisle=2), "depot.cross_aisle: 2 is"),
        (lambda: AisleWarehouse(aisles=1, slots=1, depot_distance=-1), "depot.distance: -1 is not"),
        (
            lambda: AisleWarehouse(aisles=1, slots=1, closed_aisles=frozenset({(0, 1)})),
            "closed_aisles[].block: 1 is outside the layout; use 0 to 0",
        ),
        (
            lambda: AisleWarehouse(aisles=1, slots=1, closed_crossings=frozenset({(0, 0)})),
            "closed_crossings[].aisle: 0 is outside the layout; remove it",
        ),
        (
            lambda: AisleWarehouse(aisles=1, slots=1, blocks=2, block_gaps=((1, 1),)),
            "block_gaps: 1 pairs of gaps for 2 blocks; give a front and a back gap for each block",
        ),
        (
            lambda: AisleWarehouse(aisles=1, slots=1, block_gaps=((1, -1),)),
            "block_gaps[0].back: -1 is not 0 to 1e+06; correct it",
        ),
        (
            lambda: AisleWarehouse(aisles=1, slots=1, block_gaps=((0, 0),)),
            "block_gaps[0].front: 0 leaves no aisle; use metres above 0",
        ),
        (
            lambda: AisleWarehouse(aisles=2, slots=1, depot_ways=((2, 1),)),
            "depot.ways[0].aisle: 2 is outside the layout; use 0 to 1",
        ),
        (
            lambda: AisleWarehouse(aisles=2, slots=1, depot_ways=((1, math.nan),)),
            "depot.ways[0].distance: nan is not 0 to 1e+06; correct it",
        ),
        (
            lambda: AisleWarehouse(aisles=2, slots=1, depot_ways=((0, 1),)),
            "depot.ways: two ways lead to one aisle; keep the shorter one",
        ),
        (
            lambda: AisleWarehouse(
                aisles=3, slots=1, aisle_pitch=2, depot_distance=1, depot_ways=((2, 2.9),)
            ),
            "depot.ways: the ways to aisles 0 and 2 are a short cut past the depot; lengthen them",
        ),
        (
            lambda: AisleWarehouse(aisles=2, slots=1, depot_offset=-1),
            "depot.offset: -1 is not 0 to 1e+06; correct it",
        ),
        (
            lambda: AisleWarehouse(aisles=2, slots=1, aisle_pitch=2, depot_offset=2),
            "depot.offset: the depot is not between aisle 0 and the next; count it from",
        ),
        (
            lambda: AisleWarehouse(aisles=2, slots=1, depot_aisle=1, depot_offset=1),
            "depot.offset: the depot is not between aisle 1 and the next; count it from",
        ),
        (
            lambda: AisleWarehouse(
                aisles=2, slots=1, depot_offset=1, closed_crossings=frozenset({(0, 0)})
            ),
            "depot.offset: the depot is on a closed segment of its cross aisle; open it",
        ),
        (
            lambda: AisleWarehouse(aisles=3, slots=1, depot_offset=1, depot_ways=((2, 9),)),
            "depot.ways: a depot between two aisles has one way only; leave depot.offset or",
        ),
        (lambda: OpenFloor(depot_x=math.inf), "depot.x: inf is not -1e+09 to 1e+09; correct it"),
        (lambda: DistanceTable(()), "matrix: is empty; give at least the depot's row"),
        (lambda: DistanceTable(((0, 1), (1,))), "matrix[1]: has 1 entries where the matrix has 2"),
        (lambda: DistanceTable(((0, -1), (1, 0))), "matrix[0][1]: -1 is not 0 or more; correct"),
        (lambda: DistanceTable(((0, math.nan), (1, 0))), "matrix[0][1]: nan is not 0 or"),
        (
            lambda: DistanceTable(((0,),), depot_node=1),
            "depot_node: 1 is outside the layout; use 0",
        ),
        (lambda: DistanceTable(((0,),), 0, ()), "positions: 0 positions for 1 rows; give each"),
        (lambda: DistanceTable(((0,),), 0, ((math.nan, 0),)), "positions[0].x: nan is not"),
    ],
)
def test_what_makes_no_sense_is_refused(build: Callable[[], object], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        build()
    assert str(caught.value).startswith(sentence)
    assert "; " in str(caught.value)


def test_duplicate_ids_are_refused() -> None:
    item = Item("a", 1, A)  # type: ignore[arg-type]
    order = Order("o", ("a",))
    with pytest.raises(InputError, match=r"items\[1\]\.id: the id 'a' is used twice"):
        Instance(FLOOR, (item, item), (order,), (R1,))
    with pytest.raises(InputError, match=r"orders\[1\]\.id: the id 'o' is used twice"):
        Instance(FLOOR, (item,), (order, order), (R1,))


def test_nothing_to_collect_is_fine() -> None:
    empty = make()
    assert empty.distances.tolist() == [[0]]
    assert empty.size == 0
    assert empty.weights.size == empty.order_weights.size == 0
    assert empty.notes == ()
    assert empty.vehicle_capacities.tolist() == [10]


def table(*rows: tuple[float, ...]) -> Instance:
    return make(*(Node(n) for n in range(1, len(rows))), warehouse=DistanceTable(rows))


def test_a_metric_table_needs_no_notes() -> None:
    assert table((0, 2, 2), (2, 0, 2), (2, 2, 0)).notes == ()


def test_asymmetry_is_allowed_and_told() -> None:
    assert table((0, 2, 2), (2, 0, 2), (3, 2, 0)).notes == (
        "the distances are asymmetric: depot to i1 is 2, back 3",
    )


def test_a_violated_triangle_is_allowed_and_told() -> None:
    assert table((0, 2, 5), (2, 0, 2), (5, 2, 0)).notes == (
        "the distances violate the triangle inequality: depot to i1 is 5, but 4 over i0",
    )
    by_one = table((0, 2, 3), (2, 0, 0), (3, 0, 0))
    assert "depot to i1 is 3, but 2 over i0" in by_one.notes[0]


def test_split_orders_stand_alone() -> None:
    one = make(A, B, orders=(Order("o", ("i0", "i1")),))
    assert one.whole_orders
    split = one.split_orders()
    assert [o.items for o in split.orders] == [("i0",), ("i1",)]
    assert split.split
    assert not split.whole_orders
    assert not one.split


@pytest.mark.parametrize("count", ["x", 2.5, True, 0, -1])
def test_what_is_not_a_number_of_robots_is_refused(count: object) -> None:
    with pytest.raises(InputError, match=r"^robots: .* give "):
        make(Point(1, 0)).with_robots(count)


def test_fewer_robots_are_the_first_of_those_that_there_are() -> None:
    fleet = (
        Robot("a", Fraction(5), trips=3),
        Robot("b", Fraction(9), speed=0.5),
        Robot("c", Fraction(7)),
    )
    one = make(A, B, robots=fleet)
    for count in (1, 2, 3):
        assert one.with_robots(count).robots == fleet[:count]


def test_more_robots_are_like_those_that_there_are_where_these_are_alike() -> None:
    alike = (Robot("R2", Fraction(5), trips=2), Robot("x", Fraction(5), trips=2))
    more = make(A, B, robots=alike).with_robots(4).robots
    assert more[:2] == alike
    assert [(r.id, r.capacity, r.trips) for r in more[2:]] == [("R1", 5, 2), ("R3", 5, 2)]
    unlike = make(A, B, robots=(Robot("a", Fraction(5)), Robot("b", Fraction(9))))
    with pytest.raises(InputError, match="3 robots are more than the 2 that there are, and"):
        unlike.with_robots(3)


def test_no_limit_is_a_trip_of_the_largest_for_each_order() -> None:
    one = make(A, B, robots=(Robot("a", Fraction(5), trips=3), Robot("b", Fraction(9))))
    assert [(r.capacity, r.trips) for r in one.with_robots(None).robots] == [
        (9, 1) for _ in one.orders
    ]
    assert len(make().with_robots(None).robots) == 1


@settings(max_examples=100, deadline=None)
@given(instances(multi_trip=True))
def test_what_is_derived_agrees(one: Instance) -> None:
    assert [one.order_of_node[v] for v in range(1, one.size + 1)] == [
        next(o for o, order in enumerate(one.orders) if item.id in order.items)
        for item in one.items
    ]
    assert one.order_weights.sum() == one.weights.sum()
    assert [w * one.unit for w in one.weights.tolist()] == [i.weight for i in one.items]
    assert sorted(one.vehicle_capacities.tolist(), reverse=True) == one.vehicle_capacities.tolist()
    assert len(one.vehicle_capacities) <= max(len(one.orders), 1)
    assert [one.node_name(v) for v in range(one.size + 1)] == ["depot", *(i.id for i in one.items)]


@settings(max_examples=100, deadline=None)
@given(instances(feasible=True, min_items=1))
def test_feasible_draws_fit_on_one_robot(one: Instance) -> None:
    assert one.weights.sum() <= one.capacities.min()
