"""The checker's own distances against those that solvers use."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from strategies import aisle_warehouses, warehouses_with_places

from qrobot.plan import Plan, Trip, check
from qrobot.plan.ruler import Ruler
from qrobot.problem import (
    AisleWarehouse,
    Instance,
    Item,
    OpenFloor,
    Order,
    Place,
    Point,
    Robot,
    Slot,
    Warehouse,
)


@given(warehouses_with_places(count=6))
def test_both_ways_of_measuring_agree(drawn: tuple[Warehouse, list[Place]]) -> None:
    warehouse, places = drawn
    matrix, ruler = warehouse.distance_matrix(places), Ruler(warehouse)
    nodes = [None, *places]
    for i, j in product(range(len(nodes)), repeat=2):
        if i != j:
            assert math.isclose(ruler.leg(nodes[i], nodes[j]), matrix[i, j], abs_tol=1e-9)


@given(aisle_warehouses(closed=True) | aisle_warehouses(closed=True, one_way=True), st.data())
def test_they_agree_around_closed_and_along_one_way_aisles(
    warehouse: AisleWarehouse, data: st.DataObject
) -> None:
    slots = [
        Slot(aisle, slot, block)
        for aisle in range(warehouse.aisles)
        for block in range(warehouse.blocks)
        for slot in {0, warehouse.slots - 1}
    ]
    places = data.draw(st.lists(st.sampled_from(slots), min_size=1, max_size=8, unique=True))
    matrix, ruler = warehouse.distance_matrix(places), Ruler(warehouse)
    mine = np.array([[ruler.leg(a, b) for b in [None, *places]] for a in [None, *places]])
    assert np.array_equal(np.isinf(mine), np.isinf(matrix))
    assert np.allclose(mine[np.isfinite(mine)], matrix[np.isfinite(matrix)])


def test_the_two_sides_of_an_aisle_are_one_place_to_the_picker() -> None:
    slots = [Slot(1, 2, side="left"), Slot(1, 2, side="right")]
    ruler = Ruler(AisleWarehouse(aisles=2, slots=4))
    assert ruler.leg(*slots) == 0


def test_rounding_is_half_up() -> None:
    floor = OpenFloor(metric="manhattan", rounding="nearest")
    ruler = Ruler(floor)
    assert ruler.leg(None, Point(0.5, 0)) == 1
    assert ruler.leg(None, Point(2.5, 0)) == 3
    assert ruler.leg(None, Point(2.25, 0.2)) == 2


def test_a_stop_behind_closed_aisles_is_reported() -> None:
    closed = AisleWarehouse(aisles=2, slots=3, closed_aisles=frozenset({(1, 0)}))
    item = Item("i1", Fraction(1), Slot(1, 1))
    instance = Instance(closed, (item,), (Order("i1", ("i1",)),), (Robot("R1", Fraction(5)),))
    plan = Plan((Trip("R1", ("i1",), ("i1",), 10.0, 1.0, 10.0),), 10.0)
    report = check(plan, instance)
    assert [p.kind for p in report.problems] == ["unreachable"]
    assert report.to_dict()["distance"] is None


def test_a_plan_that_goes_against_a_direction_is_refused() -> None:
    """Along the arrows the way back is around the block."""
    one_way = AisleWarehouse(aisles=2, slots=3, one_way_aisles=frozenset({(0, 0, "back")}))
    item = Item("i1", Fraction(1), Slot(0, 0))
    instance = Instance(one_way, (item,), (Order("i1", ("i1",)),), (Robot("R1", Fraction(5)),))
    plan = Plan((Trip("R1", ("i1",), ("i1",), 2.0, 1.0, 2.0),), 2.0)
    report = check(plan, instance)
    assert [p.kind for p in report.problems] == ["distance", "total"]
    assert "it is 14.0: the stated one goes against one-way aisles" in str(report.problems[0])
    right = Plan((Trip("R1", ("i1",), ("i1",), 14.0, 1.0, 14.0),), 14.0)
    assert check(right, instance).ok
    shut = AisleWarehouse(
        aisles=2,
        slots=3,
        one_way_aisles=frozenset({(0, 0, "back")}),
        closed_aisles=frozenset({(1, 0)}),
    )
    report = check(right, replace(instance, warehouse=shut))
    assert [p.kind for p in report.problems] == ["unreachable"]
    assert "from i1 to depot" in str(report.problems[0])


def test_a_thousand_items_are_measured_leg_by_leg() -> None:
    layout = AisleWarehouse(aisles=20, slots=30, blocks=3, depot_aisle=5, depot_distance=2.0)
    rng = np.random.default_rng(0)
    items = tuple(
        Item(f"i{k}", Fraction(1), Slot(int(rng.integers(20)), int(rng.integers(30)), k % 3))
        for k in range(1000)
    )
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    instance = Instance(layout, items, orders, (Robot("R1", Fraction(1000)),))
    plan = Plan.from_routes(instance, [list(range(1, 1001))])
    assert check(plan, instance).ok
