"""`solve`: any instance gives a checked plan or a reasoned infeasibility."""

from __future__ import annotations

import itertools
import math
import re
import subprocess
import sys
import tempfile
import threading
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped, subset_programme
from processes import HANG, with_our_modules
from slow import slow
from strategies import instances

import qrobot
from qrobot.backends import Stop
from qrobot.backends.testing.planners import held_up
from qrobot.planning.bounds import forest_bound, quick_bound, walk_bound
from qrobot.planning.run import Progress
from qrobot.problem import DistanceTable, Instance, Item, Node, OpenFloor, Order, Point, Robot

ROOT = Path(__file__).resolve().parents[2]


def table_instance(
    weights: list[float], capacity: float, robots: int, lots: list[tuple[int, ...]] | None = None
) -> Instance:
    """Items one metre from everything, named by number from 1."""
    n = len(weights)
    matrix = tuple(tuple(float(i != j) for j in range(n + 1)) for i in range(n + 1))
    items = tuple(Item(str(k + 1), Fraction(str(w)), Node(k + 1)) for k, w in enumerate(weights))
    groups = lots or [(k + 1,) for k in range(n)]
    return Instance(
        DistanceTable(matrix),
        items,
        tuple(
            Order(f"o{g + 1}" if lots else str(g + 1), tuple(map(str, lot)))
            for g, lot in enumerate(groups)
        ),
        tuple(Robot(f"R{k + 1}", Fraction(str(capacity))) for k in range(robots)),
    )


@settings(deadline=None, max_examples=120)
@given(instances(max_items=6, multi_trip=True))
def test_auto_is_optimal_or_reasons_why_not(instance: Instance) -> None:
    expected = least_distance(instance)
    if expected is None:
        with pytest.raises(qrobot.InfeasibleError) as caught:
            qrobot.solve(instance, max_work=50)
        assert caught.value.proven
        assert caught.value.reason
        return
    result = qrobot.solve(instance, max_work=50)
    distance, trips = expected
    assert qrobot.check(result.plan, instance).ok
    assert result.is_optimal
    assert result.gap == 0.0
    assert result.cost == pytest.approx(distance, rel=1e-9, abs=1e-9)
    assert len(result.plan.trips) == trips


@pytest.mark.parametrize("seed", [0, slow(1), slow(2)])
def test_bounds_hold_with_tight_capacity_and_are_useful(seed: int) -> None:
    instance = paper_shaped(10, 3, seed)
    expected = least_distance(instance)
    if expected is None:
        pytest.skip("this draw cannot be packed")
    walks = walk_bound(instance, expected[0], lambda: False)
    forests = forest_bound(instance, expected[0], lambda: False)
    for bound in (walks, forests):
        assert quick_bound(instance) <= bound * (1 + 1e-6) <= expected[0] * (1 + 2e-6)
    assert max(walks, forests) > 0.75 * expected[0]


@pytest.mark.parametrize(
    ("instance", "reason"),
    [
        (
            table_instance([19, 3, 19], 15, 4),
            "items 1, 3 weigh 19 each: no robot holds more than 15",
        ),
        (
            table_instance([15, 15, 15, 16], 16, 3),
            "total load 61 exceeds 3 x 16; enough would be 4 robots (--robots 4), or several "
            "trips of each robot (--trips free), or a capacity of 30 (--capacity 30)",
        ),
        (table_instance([15.5, 15.5, 15, 15], 15.5, 3), "total load 61 exceeds 3 x 15.5"),
        (table_instance([6, 6, 6], 11, 2), "all weights are multiples of 6, so 2 x 11 hold"),
        (table_instance([6, 6, 7], 11, 2), "3 orders weigh more than half"),
        (
            table_instance([8, 8, 3], 10, 3, [(1, 2), (3,)]),
            "order o1 weighs 16: no robot holds more than 10; enough would be a capacity of 16 "
            "(--capacity 16), or orders that may be split (--split-orders)",
        ),
        (table_instance([4, 4, 4, 3, 3], 9, 2), "cannot be packed into 2 trips of at most 9 each"),
    ],
)
def test_infeasible_input_gets_the_reason(instance: Instance, reason: str) -> None:
    with pytest.raises(qrobot.InfeasibleError, match=r"^.+$") as caught:
        qrobot.solve(instance, max_work=100)
    assert reason in caught.value.reason
    assert caught.value.proven


@settings(deadline=None, max_examples=60)
@given(instances(min_items=1, max_items=7, multi_trip=True), st.sampled_from([1, 2, 4, 5]))
def test_what_a_refusal_says_to_be_enough_is_enough(instance: Instance, part: int) -> None:
    """Every option in the text, alone, must lead to a plan; through files, as users do."""
    small = tuple(replace(r, capacity=r.capacity / part) for r in instance.robots)
    instance = replace(instance, robots=small)
    try:
        qrobot.solve(instance, max_work=30)
        return
    except qrobot.InfeasibleError as error:
        reason = error.reason
    options = re.findall(r"\(--([a-z-]+)(?: ([^)]+))?\)", reason)
    assert options, reason
    for name, value in options:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "one.json")
            qrobot.write(instance, path)
            given: dict[str, Any] = {
                "robots": {"robots": int(value) if value.isdigit() else value},
                "capacity": {"capacity": value},
                "trips": {"trips": value},
                "split-orders": {"split_orders": True},
            }[name]
            mended = qrobot.read(path, **given)
        assert qrobot.check(qrobot.solve(mended, max_work=50).plan, mended).ok, reason


def test_split_orders_make_the_heavy_order_possible() -> None:
    instance = table_instance([8, 8, 3], 10, 3, [(1, 2), (3,)]).split_orders()
    result = qrobot.solve(instance, max_work=100)
    assert result.plan.split
    assert len(result.plan.trips) == 3


def test_unpackable_beyond_the_subset_programme_is_proven() -> None:
    """20 orders of 6 into 6 robots of 23: three fit each, so 18 of 20."""
    pytest.importorskip("ortools")
    with pytest.raises(qrobot.InfeasibleError) as caught:
        qrobot.solve(table_instance([6] * 20, 23, 6), deadline=20)
    assert caught.value.proven


def test_no_items_give_an_empty_plan() -> None:
    empty = Instance(OpenFloor(), (), (), (Robot("R1", Fraction(1)),))
    result = qrobot.solve(empty)
    assert result.plan.trips == ()
    assert result.cost == 0.0
    assert result.is_optimal


def test_idle_robots_stay_home() -> None:
    """With a metric one robot that can carry everything is always best (FORMULATION.md)."""
    instance = replace(
        paper_shaped(7, 3, 1), robots=tuple(Robot(f"R{k}", Fraction(100)) for k in range(3))
    )
    result = qrobot.solve(instance)
    assert result.plan.robots_used == 1


def test_unusual_matrices_are_said_in_the_result() -> None:
    instance = table_instance([1, 1], 5, 1)
    crooked = DistanceTable(((0.0, 1.0, 9.0), (1.0, 0.0, 1.0), (1.0, 1.0, 0.0)))
    notes = " ".join(qrobot.solve(replace(instance, warehouse=crooked)).notes)
    assert "asymmetric" in notes
    assert "triangle" in notes


def test_one_seed_and_one_work_limit_give_one_plan() -> None:
    instance = paper_shaped(30, 4, 1)
    plans = {
        str(qrobot.solve(instance, max_work=200, seed=7).plan.to_dict()["trips"]) for _ in range(2)
    }
    assert len(plans) == 1


def test_the_deadline_is_kept_and_work_is_told() -> None:
    instance = paper_shaped(40, 4, 1)
    heard: list[Progress] = []
    thread = threading.get_native_id()
    before = held_up(thread)
    result = qrobot.solve(instance, deadline=1.0, on_progress=heard.append)
    assert result.ended == "deadline"
    # What a busy machine held this thread up does not count; the benchmark has the figure.
    assert result.timing.total - (held_up(thread) - before) < 10.0
    assert sum(result.work.values()) > 0
    assert heard
    costs = [p.cost for p in heard if p.cost is not None]
    assert all(later <= earlier for earlier, later in itertools.pairwise(costs))
    assert 0 < result.bound <= result.cost


def test_a_request_returns_the_best_plan_so_far() -> None:
    stop = Stop()

    def heard(progress: Progress) -> None:
        if progress.cost is not None:
            stop.request()

    result = qrobot.solve(paper_shaped(40, 4, 1), deadline=HANG, stop=stop, on_progress=heard)
    assert result.ended == "interrupted"
    assert qrobot.check(result.plan, result.instance).ok


def test_ctrl_c_returns_the_best_plan_so_far() -> None:
    """In a process of its own: pytest-xdist's workers do not listen to Ctrl-C."""
    code = """
import os, signal, threading
signal.signal(signal.SIGINT, signal.default_int_handler)
from oracles import paper_shaped
import qrobot
press = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT))
begun = lambda _: None if press.is_alive() or press.finished.is_set() else press.start()
result = qrobot.solve(paper_shaped(40, 4, 1), deadline=3600, on_progress=begun)
assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
print(result.ended, qrobot.check(result.plan, result.instance).ok)
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True, text=True, check=False, cwd=ROOT, env=with_our_modules(),
    )  # fmt: skip
    assert done.stdout.split() == ["interrupted", "True"], done.stderr


def test_without_extras_whole_orders_and_large_instances_still_get_plans(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("qrobot.planning.auto.available", lambda name: name == "batching")
    monkeypatch.setattr("qrobot.planning.auto._has_cp_sat", lambda: False)
    instance = paper_shaped(30, 4, 1)
    lots = tuple(Order(f"o{k}", (f"i{2 * k + 1}", f"i{2 * k + 2}")) for k in range(15))
    for variant in (instance, replace(instance, orders=lots)):
        result = qrobot.solve(variant, max_work=100)
        assert result.steps == ("batching",)
        assert qrobot.check(result.plan, variant).ok


def test_ten_thousand_items_get_a_plan_or_a_refusal() -> None:
    """On few places it is a plan; on many places the instance itself refuses."""
    n = 10_000
    items = tuple(
        Item(f"i{k}", Fraction(1), Point(float(k % 20), float(k // 20 % 10))) for k in range(n)
    )
    lots = tuple(
        Order(f"o{k}", tuple(f"i{j}" for j in range(k * 2500, (k + 1) * 2500))) for k in range(4)
    )
    crowd = Instance(OpenFloor(), items, lots, (Robot("R1", Fraction(n)),))
    result = qrobot.solve(crowd, deadline=3.0)
    assert sum(len(t.stops) for t in result.plan.trips) == n
    with pytest.raises(qrobot.InputError, match="plan them in waves"):
        Instance(
            OpenFloor(),
            tuple(Item(f"i{k}", Fraction(1), Point(float(k), 0.0)) for k in range(n)),
            tuple(Order(f"o{k}", (f"i{k}",)) for k in range(n)),
            (Robot("R1", Fraction(n)),),
        )


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"deadline": 0.0}, "deadline"),
        ({"deadline": -1.0}, "deadline"),
        ({"deadline": math.nan}, "deadline"),
        ({"max_work": 0}, "max_work"),
        ({"seed": -1}, "seed"),
        ({"backend": "nonsense"}, "backend"),
        ({"num_reads": 5}, "num_reads"),
        ({"backend": "exact", "num_reads": 5}, "num_reads"),
    ],
)
def test_bad_arguments_name_the_field(arguments: dict[str, object], field: str) -> None:
    with pytest.raises(qrobot.InputError) as caught:
        qrobot.solve(paper_shaped(3, 1, 0), **arguments)  # type: ignore[arg-type]
    assert caught.value.field == field


def test_a_crashing_backend_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    from qrobot.backends.classical.exact import ExactPlanner

    def crash(*_: object, **__: object) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr(ExactPlanner, "search", crash)
    with pytest.raises(qrobot.BackendError, match="backend exact failed: RuntimeError: boom"):
        qrobot.solve(paper_shaped(3, 1, 0), backend="exact")


def test_a_plan_that_breaks_the_rules_is_never_returned(monkeypatch: pytest.MonkeyPatch) -> None:
    from qrobot.backends import Search
    from qrobot.backends.classical.exact import ExactPlanner

    monkeypatch.setattr(
        ExactPlanner, "search", lambda *_, **__: Search(routes=[[1], [1, 2]], optimal=True)
    )
    with pytest.raises(qrobot.InfeasibleError, match="no plan was found") as caught:
        qrobot.solve(paper_shaped(3, 1, 0), backend="exact")
    assert not caught.value.proven


@pytest.mark.parametrize("items", range(2, 13))
@pytest.mark.parametrize("robots", range(1, 5))
def test_paper_shaped_instances_equal_the_subset_programme(items: int, robots: int) -> None:
    """The benchmark `paper_shaped.py` does the same on 200 of them, with times."""
    instance = paper_shaped(items, robots, seed=100)
    expected = subset_programme(instance)
    if expected is None:
        with pytest.raises(qrobot.InfeasibleError) as caught:
            qrobot.solve(instance)
        assert caught.value.proven
        return
    result = qrobot.solve(instance)
    assert result.is_optimal
    assert result.cost == pytest.approx(expected, rel=1e-9)


def test_items_of_one_order_in_one_place_are_apart_where_detours_pay() -> None:
    """Passing a place twice is shorter here: 1-2-1 costs 4, 1-1-2 costs 52."""
    matrix = ((0.0, 1.0, 50.0), (1.0, 0.0, 1.0), (50.0, 1.0, 0.0))
    items = tuple(Item(name, Fraction(1), Node(n)) for name, n in (("a", 1), ("b", 2), ("c", 1)))
    instance = Instance(
        DistanceTable(matrix),
        items,
        (Order("o", ("a", "b", "c")),),
        (Robot("R1", Fraction(9)),),
    )
    result = qrobot.solve(instance)
    assert result.cost == 4.0
    assert result.is_optimal


def test_the_diagonal_of_a_table_is_no_way() -> None:
    items = tuple(Item(name, Fraction(1), Node(1)) for name in "ab")
    instance = Instance(
        DistanceTable(((0.0, 1.0), (1.0, 7.0))),
        items,
        tuple(Order(i.id, (i.id,)) for i in items),
        (Robot("R1", Fraction(9)),),
    )
    assert qrobot.solve(instance).cost == 2.0


def test_a_later_step_that_fails_does_not_cost_the_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    from qrobot.backends.classical.exact import ExactPlanner

    def crash(*_: object, **__: object) -> None:
        raise MemoryError("boom")

    monkeypatch.setattr(ExactPlanner, "search", crash)
    result = qrobot.solve(paper_shaped(16, 4, 3), max_work=50)
    assert qrobot.check(result.plan, result.instance).ok
    assert any("MemoryError: boom" in note for note in result.notes)


@pytest.mark.parametrize("backend", ["auto", "exact"])
def test_absurdly_long_deadlines_are_none(backend: str) -> None:
    assert qrobot.solve(paper_shaped(15, 4, 3), backend=backend, deadline=1e30).is_optimal


def test_exact_has_a_plan_when_its_time_is_up() -> None:
    result = qrobot.solve(paper_shaped(18, 3, 2), backend="exact", deadline=0.3)
    assert qrobot.check(result.plan, result.instance).ok


def test_planners_have_no_control() -> None:
    with pytest.raises(qrobot.InputError, match="no control"):
        qrobot.solve(paper_shaped(3, 1, 0), control=True)
