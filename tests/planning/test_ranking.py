"""Which order is next: ways against all sequences, from anywhere, in every kind of warehouse."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

from qrobot.backends import Stop
from qrobot.errors import InfeasibleError, InputError
from qrobot.planning import rank_orders
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
)


def shortest(instance: Instance, order: Order, start: Place | None) -> float:
    """The shortest way from a place past an order's items to the depot, by all sequences."""
    places = [next(i for i in instance.items if i.id == item).place for item in order.items]
    d = instance.warehouse.distance_matrix([*places, *([] if start is None else [start])])
    first = 0 if start is None else len(places) + 1
    return min(
        sum(float(d[a, b]) for a, b in itertools.pairwise((first, *way, 0)))
        for way in itertools.permutations(range(1, len(places) + 1))
    )


@settings(deadline=None, max_examples=80)
@given(instance=instances(min_items=2, max_items=6, whole_orders=True), data=st.data())
def test_ways_are_shortest_and_the_least_extra_comes_first(
    instance: Instance, data: st.DataObject
) -> None:
    robot = data.draw(st.sampled_from(instance.robots))
    start = data.draw(st.sampled_from([None, *instance.places]))
    weight = {item.id: item.weight for item in instance.items}
    loads = {o.id: sum((weight[i] for i in o.items), Fraction(0)) for o in instance.orders}
    fitting = [o for o in instance.orders if loads[o.id] <= robot.capacity]
    if not fitting:
        with pytest.raises(InfeasibleError, match="every order is heavier"):
            rank_orders(instance, start, robot.id)
        return
    ranked = rank_orders(instance, start, robot.id)
    d = instance.warehouse.distance_matrix([] if start is None else [start])
    home = float(d[-1, 0])
    best = {o.id: shortest(instance, o, start) for o in fitting}
    assert {one.order for one in ranked} == set(best)
    orders = {o.id: o for o in instance.orders}
    for one in ranked:
        assert one.distance == pytest.approx(best[one.order])
        assert one.is_shortest
        assert one.load == loads[one.order]
        assert sorted(one.items) == sorted(orders[one.order].items)
        collecting = sum(i.pick_seconds for i in instance.items if i.id in one.items)
        assert one.seconds == pytest.approx(best[one.order] / robot.speed + collecting)
        if math.isfinite(home):
            assert one.extra == pytest.approx(best[one.order] - home, abs=1e-8)
    extras = [one.extra for one in ranked]
    assert extras == sorted(extras)


def lots(*spots: tuple[float, float]) -> Instance:
    """Orders of one item each, of weights 1, 2, 3 .."""
    return Instance(
        OpenFloor(),
        tuple(Item(f"i{k}", k, Point(*s)) for k, s in enumerate(spots, 1)),
        tuple(Order(f"lot {k}", (f"i{k}",)) for k in range(1, len(spots) + 1)),
        (Robot("small", 3), Robot("fast", 9, speed=2.0)),
    )


def test_the_nearest_lot_depends_on_where_the_robot_stands() -> None:
    question = lots((10, 0), (0, 9), (20, 1), (-4, 0))
    assert [one.order for one in rank_orders(question, robot="fast")] == [
        "lot 4", "lot 2", "lot 1", "lot 3",
    ]  # fmt: skip
    best = rank_orders(question, "20,0")[0]
    assert (best.order, best.extra, best.distance, best.seconds) == ("lot 1", 0.0, 20.0, 20.0)
    assert rank_orders(question, Point(20, 0), "fast")[0].seconds == 10.0
    assert rank_orders(question, "i3")[0] == rank_orders(question, Point(20, 1))[0]
    assert rank_orders(question, "depot") == rank_orders(question)
    assert "lot 4" not in {one.order for one in rank_orders(question)}  # 4 on a robot of 3


def test_places_are_written_as_their_warehouse_has_them() -> None:
    house = AisleWarehouse(aisles=3, slots=4, blocks=2)
    items = (Item("a", 1, Slot(0, 1)), Item("b", 1, Slot(2, 3, 1)))
    orders = (Order("A", ("a",)), Order("B", ("b",)))
    question = Instance(house, items, orders, (Robot("R", 5),))
    assert rank_orders(question, "2,3,1") == rank_orders(question, Slot(2, 3, 1))
    assert rank_orders(question, "2,3") == rank_orders(question, Slot(2, 3, 0))
    table = DistanceTable(((0.0, 4.0, 9.0), (7.0, 0.0, 2.0), (3.0, 5.0, 0.0)))
    ways = Instance(table, (Item("a", 1, Node(1)), Item("b", 1, Node(2))), orders, (Robot("R", 5),))
    assert [(one.order, one.distance, one.extra) for one in rank_orders(ways, "1")] == [
        ("B", 5.0, -2.0),  # past b it is shorter than the direct way
        ("A", 7.0, 0.0),
    ]


@pytest.mark.parametrize(
    ("at", "sentence"),
    [
        ("9,1", "at: aisle 9 is outside the layout"),
        ("1", "at: '1' is not a place here; .*AISLE,SLOT,BLOCK"),
        ("1,1,0,0", "is not a place here"),
        ("1.5,2", "is not a place here"),
        ("aa", "did you mean .*aaa"),
        (Point(1, 1), r"at: coordinate \(1, 1\) is not a slot"),
    ],
)
def test_a_place_that_does_not_exist_is_refused(at: Place | str, sentence: str) -> None:
    house = AisleWarehouse(aisles=3, slots=4)
    question = Instance(
        house, (Item("aaa", 1, Slot(0, 1)),), (Order("A", ("aaa",)),), (Robot("R", 5),)
    )
    with pytest.raises(InputError, match=sentence):
        rank_orders(question, at)
    with pytest.raises(InputError, match="'R9' is not a robot here; use one of: R"):
        rank_orders(question, robot="R9")


def test_a_way_that_does_not_exist_comes_last() -> None:
    away = math.inf
    table = DistanceTable(((0.0, 4.0, 9.0), (7.0, 0.0, away), (3.0, away, 0.0)))
    question = Instance(
        table,
        (Item("a", 1, Node(1)), Item("b", 1, Node(2))),
        (Order("B", ("b",)), Order("A", ("a",))),
        (Robot("R", 5),),
    )
    ranked = rank_orders(question, "1")
    assert [(one.order, one.distance) for one in ranked] == [("A", 7.0), ("B", away)]
    assert ranked[1].to_dict()["distance"] is None


def test_a_large_order_gets_a_good_way_within_the_time() -> None:
    rng = np.random.default_rng(1)
    spots = rng.uniform(0, 50, (70, 2))
    items = tuple(Item(f"i{k}", 1, Point(float(x), float(y))) for k, (x, y) in enumerate(spots))
    question = Instance(
        OpenFloor(), items, (Order("A", tuple(i.id for i in items)),), (Robot("R", 99),)
    )
    stop = Stop()
    stop.request()
    (one,) = rank_orders(question, stop=stop)
    assert not one.is_shortest
    assert sorted(one.items) == sorted(i.id for i in items)
    assert one.distance < 0.75 * sum(
        math.dist(a, b)
        for a, b in itertools.pairwise(np.array([(0, 0), *sorted(map(tuple, spots))]))
    )


def test_nothing_waits() -> None:
    empty = Instance(OpenFloor(), (), (), (Robot("R", 5),))
    assert rank_orders(empty) == ()
