"""Plans along one-way aisles: every planner keeps to the directions, and no bound is too high."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance
from strategies import aisle_warehouses

import qrobot
from qrobot.backends import Stop
from qrobot.planning import rank_orders
from qrobot.planning.bounds import forest_bound, quick_bound, walk_bound
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot, Stock
from qrobot.problem.table import unreachable
from qrobot.report import compare_routing

SERPENTINE = frozenset((a, 0, "back" if a % 2 == 0 else "front") for a in range(6))


@st.composite
def one_way_orders(draw: st.DrawFn) -> Instance:
    """Draw orders that lie where the directions lead to and back from."""
    house = draw(aisle_warehouses(one_way=True))
    slots = [
        Slot(a, s, b)
        for a in range(house.aisles)
        for b in range(house.blocks)
        for s in range(house.slots)
    ]
    cut_off = set(unreachable(~(house.distance_matrix(slots) == math.inf)).tolist())
    slots = [slot for k, slot in enumerate(slots) if k + 1 not in cut_off]
    if not slots:
        house, slots = AisleWarehouse(6, 4, one_way_aisles=SERPENTINE), [Slot(1, 2), Slot(4, 0)]
    lots = draw(st.lists(st.integers(0, 2), min_size=1, max_size=6))
    items = tuple(Item(f"i{k}", 1, draw(st.sampled_from(slots))) for k in range(len(lots)))
    orders = tuple(
        Order(f"o{lot}", tuple(f"i{k}" for k, of in enumerate(lots) if of == lot))
        for lot in sorted(set(lots))
    )
    most = max(len(order.items) for order in orders)
    return Instance(house, items, orders, (Robot("R1", Fraction(most + 1), trips=3),))


@settings(max_examples=40, deadline=None)
@given(one_way_orders())
def test_plans_are_proven_and_bounds_hold(instance: Instance) -> None:
    least = least_distance(instance)
    assert least is not None
    found = qrobot.solve(instance, max_work=200)
    assert found.is_optimal
    assert found.plan.distance == pytest.approx(least[0])
    slack = 1e-9 * max(1.0, least[0])
    for bound in (forest_bound, walk_bound):
        assert bound(instance, least[0], Stop()) <= least[0] + slack
    assert quick_bound(instance) <= least[0] + slack


@pytest.mark.parametrize("backend", ["fcfs", "seed", "savings", "batching", "neal", "exact"])
def test_every_planner_keeps_to_the_directions(backend: str) -> None:
    """The checker, which measures for itself, accepts the plan."""
    house = AisleWarehouse(6, 4, one_way_aisles=SERPENTINE)
    items = tuple(Item(f"i{k}", 1, Slot(k, k % 4)) for k in range(6))
    orders = tuple(Order(f"o{k}", (f"i{k}", f"i{k + 3}")) for k in range(3))
    instance = Instance(house, items, orders, (Robot("R1", Fraction(4), trips=3),))
    least = least_distance(instance)
    assert least is not None
    result = qrobot.solve(instance, backend=backend, max_work=200)
    assert qrobot.check(result, instance).ok
    assert result.bound <= least[0] + 1e-9
    assert result.plan.distance >= least[0] - 1e-9


def many(count: int, directions: frozenset[tuple[int, int, str]]) -> Instance:
    """Return orders for one robot."""
    house = AisleWarehouse(12, 9, one_way_crossings=directions)
    items = tuple(Item(f"i{k}", 1, Slot(5 * k % 12, 7 * k % 9)) for k in range(count))
    orders = tuple(
        Order(f"o{k}", tuple(item.id for item in items[k : k + 4])) for k in range(0, count, 4)
    )
    return Instance(house, items, orders, (Robot("R1", Fraction(count)),))


def test_long_tours_are_said_not_to_be_proven() -> None:
    instance = many(40, frozenset({(1, 5, "right")}))
    result = qrobot.solve(instance, backend="batching", max_work=20)
    note = "tours of more than 15 stops are not proven shortest (1 of 1 here)"
    assert [text for text in result.notes if note in text]
    free = qrobot.solve(many(40, frozenset()), max_work=60)
    assert free.is_optimal
    assert free.plan.distance <= result.plan.distance
    short = qrobot.solve(many(12, frozenset({(1, 5, "right")})), backend="fcfs", max_work=20)
    assert not [text for text in short.notes if "one-way" in text]


def test_short_tours_of_a_rule_are_shortest() -> None:
    """One trip: the least distance of any plan is that of its tour."""
    instance = many(12, frozenset({(1, 5, "right"), (0, 3, "left")}))
    rule = qrobot.solve(instance, backend="fcfs", max_work=20)
    assert rule.plan.distance == pytest.approx(
        qrobot.solve(instance, backend="exact").plan.distance
    )


def test_other_parts_take_directions_or_say_so(tmp_path: Path) -> None:
    instance = many(12, frozenset({(1, 5, "right"), (0, 3, "left")}))
    result = qrobot.solve(instance, max_work=100)
    ways = {one.policy: one for one in compare_routing(result).ways}
    assert ways["shortest"].distance == pytest.approx(result.plan.distance)
    assert "some are one-way" in ways["s-shape"].problem
    first = rank_orders(instance)[0]
    assert first.is_shortest
    qrobot.plot(result, tmp_path / "plan.svg")
    assert (tmp_path / "plan.svg").read_text().count('id="one-way-') == 2
    stocked = Instance(
        instance.warehouse,
        (Item("a", 1, Slot(0, 0), article="nut"),),
        (Order("o", ("a",)),),
        instance.robots,
        stock=(Stock("nut", Slot(0, 0), 1), Stock("nut", Slot(1, 0), 1)),
    )
    assert [n for n in qrobot.solve(stocked).notes if "items are taken from their own" in n]
