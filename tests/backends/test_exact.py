"""The exact planner against a dynamic programme of the tests' own."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from strategies import instances

import qrobot
from qrobot.backends import Stop
from qrobot.backends.classical.batching import BatchingPlanner, tour_length
from qrobot.backends.classical.exact import ExactPlanner, pack
from qrobot.backends.classical.exact.partition import best_split
from qrobot.backends.classical.exact.subsets import count_subsets, fitting_subsets, shortest_tours
from qrobot.backends.classical.exact.tours import shortest_tour, tour_bound
from qrobot.errors import BackendError
from qrobot.planning.run import plan_fits
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    Order,
    Robot,
    Slot,
)


@settings(deadline=None, max_examples=150)
@given(instances(max_items=6, multi_trip=True))
def test_distance_and_trips_equal_the_oracle(instance: Instance) -> None:
    found = ExactPlanner().search(instance, stop=Stop())
    expected = least_distance(instance)
    if expected is None:
        assert found.routes is None
        assert found.infeasible
        return
    distance, trips = expected
    assert found.routes is not None
    assert found.optimal
    assert plan_fits(instance, found.routes)
    assert instance.length(found.routes) == pytest.approx(distance, rel=1e-9, abs=1e-9)
    assert len(found.routes) == trips
    assert found.bound == pytest.approx(distance, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_set_partition_agrees_with_the_subset_programme(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both ways of the planner must give the same optimum on the same instance."""
    pytest.importorskip("ortools")
    instance = paper_shaped(9, 3, seed)
    by_subsets = ExactPlanner().search(instance, stop=Stop())
    monkeypatch.setattr("qrobot.backends.classical.exact.planner.MAX_ELEMENTS", 0)
    by_cover = ExactPlanner().search(instance, stop=Stop())
    assert by_subsets.routes is not None
    assert by_cover.routes is not None
    assert by_cover.optimal
    assert instance.length(by_cover.routes) == pytest.approx(instance.length(by_subsets.routes))
    start = [r[::-1] for r in by_subsets.routes]
    warm = ExactPlanner().search(instance, stop=Stop(), start=start)
    assert warm.optimal
    assert warm.routes is not None
    assert instance.length(warm.routes) == pytest.approx(instance.length(by_subsets.routes))


def test_set_partition_respects_different_robots(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ortools")
    instance = paper_shaped(8, 3, 1)
    total = int(instance.weights.sum())
    sizes = (total // 2, total // 3, -(-total // 4))
    fleet = tuple(Robot(f"R{k}", Fraction(size)) for k, size in enumerate(sizes))
    instance = replace(instance, robots=fleet)
    monkeypatch.setattr("qrobot.backends.classical.exact.planner.MAX_ELEMENTS", 0)
    found = ExactPlanner().search(instance, stop=Stop())
    expected = least_distance(instance)
    if expected is None:
        assert found.routes is None
    else:
        assert found.routes is not None
        assert plan_fits(instance, found.routes)
        assert instance.length(found.routes) == pytest.approx(expected[0])


def test_equal_distance_takes_the_fewest_trips() -> None:
    """All items on one line: one trip to the far end is as long as two of them are not."""
    matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    items = tuple(Item(f"i{n}", Fraction(1), Node(n)) for n in (1, 2))
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    robots = tuple(Robot(f"R{k}", Fraction(2)) for k in range(2))
    instance = Instance(DistanceTable(matrix), items, orders, robots)
    found = ExactPlanner().search(instance, stop=Stop())
    assert found.routes is not None
    assert len(found.routes) == 1


def with_lots(instance: Instance, size: int) -> Instance:
    """Join neighbours in the list of items into whole orders."""
    ids = [item.id for item in instance.items]
    lots = [tuple(ids[k : k + size]) for k in range(0, len(ids), size)]
    return replace(instance, orders=tuple(Order(f"o{k}", lot) for k, lot in enumerate(lots)))


@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize("orders", [24, 60])
def test_too_many_sets_are_refused_with_advice_that_works(orders: int, size: int) -> None:
    instance = with_lots(paper_shaped(orders * size, 1, 0), size)
    assert not ExactPlanner().fits(instance)
    with pytest.raises(BackendError, match="too many to prove a plan") as caught:
        ExactPlanner().search(instance, stop=Stop(1.0))
    advised = re.findall(r"use backend (\w+) or (\w+)", str(caught.value))
    assert advised
    for name in advised[0]:
        result = qrobot.solve(instance, backend=name, deadline=0.5)  # long bounds say nothing here
        assert qrobot.check(result.plan, instance).ok


def wave(orders: int, lines: int, robots: int, seed: int) -> Instance:
    """Whole orders among aisles; weights of 1 to 5, fleets with a fifth of slack."""
    rng = np.random.default_rng(seed)
    count = orders * lines
    items = tuple(
        Item(f"i{k}", Fraction(int(rng.integers(1, 6))), Slot(*rng.integers(0, 10, 2).tolist()))
        for k in range(count)
    )
    room = -(-sum(int(item.weight) for item in items) * 12 // (10 * robots))
    fleet = tuple(Robot(f"R{k}", Fraction(room)) for k in range(robots))
    singles = tuple(Order(item.id, (item.id,)) for item in items)
    return with_lots(Instance(AisleWarehouse(aisles=10, slots=10), items, singles, fleet), lines)


@pytest.mark.parametrize(("orders", "lines", "robots"), [(8, 4, 3), (8, 6, 4), (10, 4, 5)])
def test_orders_of_several_stops_are_counted_not_their_stops(
    orders: int, lines: int, robots: int
) -> None:
    """Millions of sets of stops fit, but only hundreds of sets of orders."""
    instance = wave(orders, lines, robots, 1)
    assert ExactPlanner().fits(instance)
    found = ExactPlanner().search(instance, stop=Stop())
    assert found.optimal
    assert found.routes is not None
    assert plan_fits(instance, found.routes)
    assert found.bound == pytest.approx(instance.length(found.routes))
    other = BatchingPlanner().search(instance, stop=Stop(max_work=400), seed=1).routes
    assert other is not None
    assert found.bound <= instance.length(other) + 1e-9


@settings(deadline=None, max_examples=60)
@given(instances(max_items=7, multi_trip=True, whole_orders=True))
def test_measuring_tours_on_demand_finds_the_optimum_of_the_oracle(instance: Instance) -> None:
    """The way of the planner for orders of many stops, forced onto small ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("qrobot.backends.classical.exact.columns.MAX_ENTRIES", 0)
        if not instance.whole_orders:
            return
        found = ExactPlanner().search(instance, stop=Stop(max_work=40))
    expected = least_distance(instance)
    if expected is None:
        assert found.infeasible
        return
    assert found.optimal
    assert found.routes is not None
    assert instance.length(found.routes) == pytest.approx(expected[0], rel=1e-9, abs=1e-9)
    assert len(found.routes) == expected[1]


def test_more_than_13_orders_of_several_stops_go_to_the_set_partition() -> None:
    """With 40 stops the table of all sets of stops is out of reach."""
    pytest.importorskip("ortools")
    instance = wave(16, 3, 8, 2)
    found = ExactPlanner().search(instance, stop=Stop(max_work=100_000))
    assert found.optimal
    assert found.routes is not None
    assert plan_fits(instance, found.routes)


@pytest.mark.parametrize("kind", ["aisles", "floor", "asymmetric"])
@pytest.mark.parametrize("seed", range(3))
def test_tours_of_branch_and_bound_equal_the_dynamic_programme(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 13
    if kind == "aisles":
        d = wave(n, 1, 2, seed).stop_distances
    elif kind == "floor":
        d = paper_shaped(n, 1, seed).stop_distances
    else:
        d = rng.integers(1, 50, (n + 1, n + 1)).astype(float)
        np.fill_diagonal(d, 0.0)
    masks, _ = fitting_subsets([1] * n, n)
    tours = shortest_tours(masks, d)
    assert tours is not None
    least = float(tours.lengths[tours.row((1 << n) - 1)])
    found = shortest_tour(d, lambda: False)
    assert found is not None
    length, tour = found
    assert sorted(tour) == list(range(1, n + 1))
    assert length == pytest.approx(least)
    assert tour_length(d, tour) == pytest.approx(least)
    assert tour_bound(d, length) <= least * (1 + 1e-9)


def test_stop_is_obeyed_and_keeps_the_start() -> None:
    instance = paper_shaped(16, 4, 3)
    stop = Stop()
    stop.request()
    start = [[v] for v in range(1, 17)]
    assert ExactPlanner().search(instance, stop=stop, start=start).routes == start


@given(st.lists(st.integers(0, 9), max_size=9), st.integers(0, 30))
def test_fitting_subsets_are_all_that_fit(weights: list[int], capacity: int) -> None:
    masks, loads = fitting_subsets(weights, capacity)
    brute = [
        mask
        for mask in range(1, 1 << len(weights))
        if sum(w for i, w in enumerate(weights) if mask >> i & 1) <= capacity
    ]
    assert sorted(masks.tolist()) == brute
    assert count_subsets(weights, capacity, 10_000) == len(brute)
    for mask, load in zip(masks.tolist(), loads.tolist(), strict=True):
        assert load == sum(w for i, w in enumerate(weights) if mask >> i & 1)


@given(st.integers(1, 7), st.integers(0, 10_000))
def test_tours_are_the_shortest_of_all_sequences(n: int, seed: int) -> None:
    from itertools import permutations

    rng = np.random.default_rng(seed)
    d = rng.integers(1, 30, (n + 1, n + 1)).astype(float)
    masks, _ = fitting_subsets([1] * n, n)
    tours = shortest_tours(masks, d)
    assert tours is not None
    row = int(rng.integers(len(masks)))
    members = [i for i in range(n) if int(masks[row]) >> i & 1]

    def length(sequence: tuple[int, ...]) -> float:
        nodes = [0, *(i + 1 for i in sequence), 0]
        return float(sum(d[a, b] for a, b in itertools.pairwise(nodes)))

    assert tours.lengths[row] == min(length(p) for p in permutations(members))
    assert sorted(tours.stops(row)) == members
    assert length(tuple(tours.stops(row))) == tours.lengths[row]


def test_best_split_says_when_nothing_fits() -> None:
    empty_only = np.array([0.0, np.inf, np.inf, np.inf])
    total, masks, _ = best_split([empty_only, empty_only])
    assert np.isinf(total)
    assert masks == []


@pytest.mark.parametrize(
    ("weights", "room", "possible"), [([6, 6, 6], 11, False), ([6, 5, 5], 11, True)]
)
def test_packing_is_found_or_its_absence_proven(
    weights: list[int], room: int, possible: bool
) -> None:
    pytest.importorskip("ortools")
    n = len(weights)
    matrix = tuple(tuple(float(i != j) for j in range(n + 1)) for i in range(n + 1))
    items = tuple(Item(f"i{k}", Fraction(w), Node(k + 1)) for k, w in enumerate(weights))
    instance = Instance(
        DistanceTable(matrix),
        items,
        tuple(Order(i.id, (i.id,)) for i in items),
        tuple(Robot(f"R{k}", Fraction(room)) for k in range(2)),
    )
    routes, impossible = pack(instance, Stop(5.0))
    assert impossible is not possible
    if possible:
        assert routes is not None
        assert plan_fits(instance, routes)
