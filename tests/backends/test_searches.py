"""The searches pyvrp and batching: valid plans, near the optimum, repeatable, obedient."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from strategies import instances

from qrobot.backends import Planner, Stop, get
from qrobot.backends.classical.batching import improve_tour, tour_length
from qrobot.backends.testing import PlannerConformance
from qrobot.errors import BackendError
from qrobot.planning.run import plan_fits
from qrobot.problem import Instance, Robot

SEARCHES = ["pyvrp", "batching"]


def search(name: str) -> Planner:
    if name == "pyvrp":
        pytest.importorskip("pyvrp")
    planner = get(name)
    assert isinstance(planner, Planner)
    return planner


@pytest.mark.parametrize("name", SEARCHES)
@settings(deadline=None, max_examples=40)
@given(instance=instances(min_items=1, max_items=6, multi_trip=True))
def test_plans_are_valid_and_never_below_the_optimum(name: str, instance: Instance) -> None:
    assume(name == "batching" or not instance.whole_orders)
    found = search(name).search(instance, stop=Stop(max_work=60), seed=1)
    if found.routes is None:
        return
    assert plan_fits(instance, found.routes)
    expected = least_distance(instance)
    assert expected is not None
    assert instance.length(found.routes) >= expected[0] - 1e-9


@pytest.mark.parametrize("name", SEARCHES)
@pytest.mark.parametrize("seed", range(3))
def test_small_instances_are_solved_to_the_optimum(name: str, seed: int) -> None:
    instance = paper_shaped(9, 2, seed)
    expected = least_distance(instance)
    assert expected is not None
    found = search(name).search(instance, stop=Stop(max_work=1500), seed=seed)
    assert found.routes is not None
    assert instance.length(found.routes) == pytest.approx(expected[0])


@pytest.mark.parametrize("name", SEARCHES)
def test_one_seed_and_one_work_limit_give_one_plan(name: str) -> None:
    instance = paper_shaped(25, 4, 5)
    first, second = (
        search(name).search(instance, stop=Stop(max_work=150), seed=3) for _ in range(2)
    )
    assert first.routes == second.routes
    assert first.work == second.work == 150


@pytest.mark.parametrize("name", SEARCHES)
def test_a_request_ends_the_search_with_the_best_so_far(name: str) -> None:
    instance = paper_shaped(40, 4, 5)
    stop = Stop()  # without a limit: nothing else ends it
    told: list[float] = []

    def heard(_: object, cost: float) -> None:
        told.append(cost)
        stop.request()

    found = search(name).search(instance, stop=stop, seed=3, on_best=heard)
    assert found.routes is not None
    assert told
    assert instance.length(found.routes) == pytest.approx(min(told))


@pytest.mark.parametrize("name", SEARCHES)
def test_a_start_is_never_made_worse(name: str) -> None:
    instance = paper_shaped(10, 3, 2)
    exact = get("exact")
    assert isinstance(exact, Planner)
    best = exact.search(instance, stop=Stop()).routes
    assert best is not None
    found = search(name).search(instance, stop=Stop(max_work=20), seed=1, start=best)
    assert found.routes is not None
    assert instance.length(found.routes) <= instance.length(best) * (1 + 1e-6)


@pytest.mark.parametrize("name", SEARCHES)
def test_different_robots_carry_what_they_can(name: str) -> None:
    instance = paper_shaped(12, 3, 4)
    total = int(instance.weights.sum())
    sizes = (-(-total * 6 // 10), -(-total * 4 // 10), -(-total * 2 // 10))
    instance = replace(
        instance, robots=tuple(Robot(f"R{k}", Fraction(s)) for k, s in enumerate(sizes))
    )
    found = search(name).search(instance, stop=Stop(max_work=400), seed=1)
    assert found.routes is not None
    assert plan_fits(instance, found.routes)


def test_pyvrp_refuses_orders_of_several_stops() -> None:
    instance = paper_shaped(4, 2, 0)
    from qrobot.problem import Order

    instance = replace(
        instance, orders=(Order("a", ("i1", "i2")), Order("b", ("i3",)), Order("c", ("i4",)))
    )
    with pytest.raises(BackendError, match="several stops"):
        search("pyvrp").search(instance, stop=Stop(max_work=5))


@given(st.integers(0, 7), st.integers(0, 10_000), st.booleans())
def test_improved_tours_keep_their_stops_and_are_local_optima(
    n: int, seed: int, symmetric: bool
) -> None:
    rng = np.random.default_rng(seed)
    d = rng.integers(1, 50, (n + 1, n + 1)).astype(float)
    if symmetric:
        d = np.minimum(d, d.T)
    np.fill_diagonal(d, 0.0)
    tour = (rng.permutation(n) + 1).tolist()
    short = improve_tour(d, tour)
    assert sorted(short) == sorted(tour)
    length = tour_length(d, short)
    assert length <= tour_length(d, tour)
    for i in range(n):  # no reversal helps
        for j in range(i + 1, n):
            turned = short[:i] + short[i : j + 1][::-1] + short[j + 1 :]
            assert tour_length(d, turned) >= length - 1e-9
    for i in range(n):  # no move of one stop helps
        rest = short[:i] + short[i + 1 :]
        for at in range(n):
            assert tour_length(d, [*rest[:at], short[i], *rest[at:]]) >= length - 1e-9
    if n <= 3:
        assert length == min(tour_length(d, list(p)) for p in permutations(tour))


class TestExactConformance(PlannerConformance):
    def make(self) -> Planner:
        return search("exact")


class TestBatchingConformance(PlannerConformance):
    def make(self) -> Planner:
        return search("batching")


class TestPyVRPConformance(PlannerConformance):
    def make(self) -> Planner:
        return search("pyvrp")
