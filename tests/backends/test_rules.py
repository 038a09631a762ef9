"""The rules of batching: each does what its name says, worked out by hand or anew."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

import qrobot
from qrobot.backends import Planner, Stop, get
from qrobot.backends.classical.batching.lots import packed
from qrobot.backends.testing import PlannerConformance, scattered, verify
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Point,
    Robot,
    Slot,
)

RULES = ["fcfs", "seed", "savings"]


def planner(name: str) -> Planner:
    found = get(name)
    assert isinstance(found, Planner)
    return found


def batches(name: str, instance: Instance, **limits: float) -> list[list[int]] | None:
    """The orders of each trip, from 0."""
    found = planner(name).search(instance, stop=Stop(**limits))  # type: ignore[arg-type]
    if found.routes is None:
        return None
    verify(instance, found.routes)
    owner = instance.order_of_node
    return sorted(sorted({int(owner[v]) for v in route}) for route in found.routes)


def singles(weights: list[int], robots: list[int], spots: list[tuple[float, float]]) -> Instance:
    ids = [f"i{k}" for k in range(len(weights))]
    return Instance(
        warehouse=OpenFloor(),
        items=tuple(Item(i, w, Point(*s)) for i, w, s in zip(ids, weights, spots, strict=True)),
        orders=tuple(Order(i, (i,)) for i in ids),
        robots=tuple(Robot(f"R{k}", room) for k, room in enumerate(robots)),
    )


def in_aisles(orders: int, seed: int, capacity: int = 12, blocks: int = 2) -> Instance:
    """Orders of 1 to 4 items of weight 1, and a trip for each."""
    rng = np.random.default_rng(seed)
    items, lots = [], []
    for o in range(orders):
        ids = []
        for k in range(int(rng.integers(1, 5))):
            ids.append(f"{o}.{k}")
            place = Slot(int(rng.integers(5)), int(rng.integers(8)), int(rng.integers(blocks)))
            items.append(Item(ids[-1], 1, place))
        lots.append(Order(f"o{o}", tuple(ids)))
    return Instance(
        AisleWarehouse(aisles=5, slots=8, blocks=blocks), tuple(items), tuple(lots),
        (Robot("R", capacity, trips=orders),),
    )  # fmt: skip


def shortest(instance: Instance, orders: tuple[int, ...]) -> float:
    """The shortest tour by all sequences."""
    nodes = {v for o in orders for v in instance.order_nodes[o]}
    d = instance.distances
    return min(
        float(sum(d[a, b] for a, b in itertools.pairwise((0, *way, 0))))
        for way in itertools.permutations(nodes)
    )


class TestFirstCome(PlannerConformance):
    def make(self) -> Planner:
        return planner("fcfs")


class TestSeed(PlannerConformance):
    def make(self) -> Planner:
        return planner("seed")


class TestSavings(PlannerConformance):
    def make(self) -> Planner:
        return planner("savings")


@pytest.mark.parametrize("name", RULES)
@settings(deadline=None, max_examples=40)
@given(instance=instances(min_items=1, max_items=7, multi_trip=True, feasible=True))
def test_plans_keep_to_all_rules(name: str, instance: Instance) -> None:
    found = planner(name).search(instance, stop=Stop())
    if found.routes is not None:
        verify(instance, found.routes)


def test_first_come_closes_a_trip_when_an_order_does_not_fit() -> None:
    spots = [(float(k), 1.0) for k in range(5)]
    free = singles([5, 6, 2, 4, 1], [10, 10, 10, 10, 10], spots)
    assert batches("fcfs", free) == [[0], [1, 2], [3, 4]]
    # Two trips are too few like this: an order joins the first trip with room.
    assert batches("fcfs", singles([5, 6, 4, 4, 1], [10, 10], spots)) == [[0, 2, 4], [1, 3]]


def test_first_come_fills_the_largest_robot_first() -> None:
    spots = [(float(k), 1.0) for k in range(4)]
    assert batches("fcfs", singles([3, 3, 3, 2], [5, 9], spots)) == [[0, 1, 2], [3]]


def test_savings_join_whom_it_saves_most_and_count_anew() -> None:
    # On a line at 10, 9 and -1, -2, two on a trip of 2 each: the far pair saves 18, the near 2.
    line = singles([1] * 4, [2] * 4, [(10, 0), (-1, 0), (9, 0), (-2, 0)])
    assert batches("savings", line) == [[0, 2], [1, 3]]


def savings_anew(instance: Instance) -> float:
    """Clarke and Wright (ii), written down plainly: every pair of trips, every time."""
    weight, room = instance.order_weights, int(instance.vehicle_capacities[0])
    trips = [(o,) for o in range(len(weight))]
    cost = {t: shortest(instance, t) for t in trips}
    while True:
        best, pair = 1e-9, None
        for a, b in itertools.combinations(trips, 2):
            if weight[list(a + b)].sum() <= room:
                both = tuple(sorted(a + b))
                cost.setdefault(both, shortest(instance, both))
                if cost[a] + cost[b] - cost[both] > best + 1e-9:
                    best, pair = cost[a] + cost[b] - cost[both], (a, b)
        if pair is None:
            return sum(cost[t] for t in trips)
        trips = [t for t in trips if t not in pair] + [tuple(sorted(pair[0] + pair[1]))]


@pytest.mark.parametrize("kind", ["aisles", "table"])
@pytest.mark.parametrize("seed", range(4))
def test_savings_against_the_rule_written_down_plainly(kind: str, seed: int) -> None:
    # A table of drawn distances: no two savings are equal, so there is one answer.
    rng = np.random.default_rng(seed)
    spots = rng.uniform(0, 100, (7, 2))
    ways = np.hypot(*(spots[:, None] - spots[None, :]).T)
    if kind == "table":
        warehouse, places = DistanceTable(tuple(map(tuple, ways.tolist()))), range(1, 7)
        instance = Instance(
            warehouse,
            tuple(Item(f"i{k}", 1, Node(k)) for k in places),
            tuple(Order(f"i{k}", (f"i{k}",)) for k in places),
            (Robot("R", 3, trips=6),),
        )
    else:
        lots = [Slot(int(a), int(s)) for a, s in rng.integers(0, (6, 9), (6, 2))]
        instance = Instance(
            AisleWarehouse(aisles=6, slots=9, aisle_pitch=3.17, slot_pitch=1.0213, end_gap=0.71),
            tuple(Item(f"i{k}", 1, place) for k, place in enumerate(lots)),
            tuple(Order(f"i{k}", (f"i{k}",)) for k in range(6)),
            (Robot("R", 3, trips=6),),
        )
    found = planner("savings").search(instance, stop=Stop())
    assert found.routes is not None
    assert instance.length(found.routes) == pytest.approx(savings_anew(instance))


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("blocks", [1, 2])
def test_tours_in_aisles_are_shortest(name: str, blocks: int) -> None:
    instance = in_aisles(12, seed=3, capacity=6, blocks=blocks)
    found = planner(name).search(instance, stop=Stop())
    assert found.routes is not None
    for route in found.routes:
        orders = tuple({int(instance.order_of_node[v]) for v in route})
        assert instance.route_length(route) == pytest.approx(shortest(instance, orders))


def test_rules_that_look_at_tours_beat_the_one_that_does_not() -> None:
    lengths = dict.fromkeys(RULES, 0.0)
    for seed in range(5):
        instance = in_aisles(40, seed)
        for name in RULES:
            found = planner(name).search(instance, stop=Stop())
            assert found.routes is not None
            lengths[name] += verify(instance, found.routes)
    assert lengths["savings"] < 0.95 * lengths["fcfs"]
    assert lengths["seed"] < 0.95 * lengths["fcfs"]


@pytest.mark.parametrize("name", ["seed", "savings"])
def test_scarce_trips_are_kept_to(name: str) -> None:
    # Three trips of 12 for 36: any order astray, and it does not fit.
    spots = [(float(k % 4), float(k)) for k in range(9)]
    tight = singles([5, 4, 3, 5, 4, 3, 5, 4, 3], [12, 12, 12], spots)
    found = batches(name, tight)
    assert found is not None
    assert len(found) == 3


@pytest.mark.parametrize("name", RULES)
def test_a_rule_without_a_packing_says_so_in_a_sentence(name: str) -> None:
    # 5 + 9 + 4 and 6 + 6 + 6 would do; no rule finds it.
    spots = [(float(k), 1.0) for k in range(6)]
    hard = singles([5, 6, 6, 9, 4, 6], [18, 18], spots)
    assert batches(name, hard) is None
    with pytest.raises(
        qrobot.InfeasibleError, match=f"no plan was found by {name} .* use another"
    ) as told:
        qrobot.solve(hard, backend=name)
    assert not told.value.proven
    assert qrobot.solve(hard, backend="exact").is_optimal


@settings(deadline=None, max_examples=200)
@given(
    loads=st.lists(st.integers(0, 9), min_size=1, max_size=8),
    rooms=st.lists(st.integers(1, 20), min_size=1, max_size=4),
)
def test_a_packing_holds_all_and_overloads_none(loads: list[int], rooms: list[int]) -> None:
    capacities = np.array(sorted(rooms, reverse=True), dtype=np.int64)
    trips = packed(np.array(loads, dtype=np.int64), capacities)
    if trips is not None:
        assert (np.bincount(trips, loads, len(rooms)) <= capacities).all()
    else:  # one a trip would not have done
        heaviest = sorted(loads, reverse=True)
        pairs = zip(heaviest, capacities.tolist(), strict=False)
        assert len(loads) > len(rooms) or any(load > room for load, room in pairs)


@pytest.mark.parametrize("name", ["seed", "savings"])
def test_a_stopped_rule_keeps_what_it_has_joined(name: str) -> None:
    instance = scattered(40).with_robots(None)
    routes = {
        work: planner(name).search(instance, stop=Stop(max_work=work)).routes for work in (5, 20)
    }
    assert routes[5] is not None
    assert routes[20] is not None
    assert verify(instance, routes[20]) < verify(instance, routes[5])


def test_orders_of_several_items_stay_whole_on_a_floor() -> None:
    rng = np.random.default_rng(2)
    items = tuple(
        Item(f"i{k}", Fraction(1), Point(float(x), float(y)))
        for k, (x, y) in enumerate(rng.uniform(0, 50, (60, 2)))
    )
    orders = tuple(
        Order(f"o{k}", tuple(f"i{j}" for j in range(2 * k, 2 * k + 2))) for k in range(30)
    )
    instance = Instance(OpenFloor(), items, orders, (Robot("R", 8, trips=30),))
    lengths = []
    for name in RULES:
        found = planner(name).search(instance, stop=Stop())
        assert found.routes is not None
        lengths.append(verify(instance, found.routes))
    assert lengths[2] < lengths[0]
    assert lengths[1] < lengths[0]
