"""Objectives: what a plan costs, against all plans and all robots for its trips."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

import qrobot
from qrobot.plan import OBJECTIVES, Objective, read_plan
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    Order,
    Robot,
    Slot,
    Stock,
    Times,
)

ROOT = Path(__file__).resolve().parents[2]
SPEEDS = st.sampled_from([0.25, 0.7, 1.0, 1.5, 4.0])


@st.composite
def unlike(draw: st.DrawFn, max_items: int = 4) -> Instance:
    """Return a small instance whose robots and picks differ."""
    instance = draw(instances(min_items=1, max_items=max_items))
    robots = [replace(robot, speed=draw(SPEEDS)) for robot in instance.robots]
    items = [
        replace(item, pick_seconds=draw(st.floats(0, 30).map(lambda s: round(s, 2))))
        for item in instance.items
    ]
    return replace(instance, robots=tuple(robots), items=tuple(items))


def partitions(elements: Sequence[int]) -> Iterator[list[list[int]]]:
    if not elements:
        yield []
        return
    first, *rest = elements
    for parts in partitions(rest):
        for at in range(len(parts)):
            yield [*parts[:at], [first, *parts[at]], *parts[at + 1 :]]
        yield [[first], *parts]


def shortest(instance: Instance, orders: Sequence[int]) -> float:
    nodes = [v for order in orders for v in instance.order_nodes[order]]
    return min(instance.route_length(list(route)) for route in permutations(nodes))


def least_seconds(instance: Instance) -> float:
    """Return the least time of all plans: every split, every sequence, every assignment."""
    seats = [robot for robot in instance.robots for _ in range(robot.trips)]
    least = math.inf
    for parts in partitions(range(len(instance.orders))):
        weights = [
            sum(instance.items[v - 1].weight for o in part for v in instance.order_nodes[o])
            for part in parts
        ]
        lengths = [shortest(instance, part) for part in parts]
        for robots in set(permutations(seats, len(parts))):
            if all(w <= robot.capacity for w, robot in zip(weights, robots, strict=True)):
                ways = zip(lengths, robots, strict=True)
                least = min(least, math.fsum(length / robot.speed for length, robot in ways))
    return least + math.fsum(item.pick_seconds for item in instance.items)


@pytest.mark.parametrize("backend", ["auto", "exact", "pyvrp", "pyvrp-plain"])
@pytest.mark.parametrize("straight", [6.0, 1e3, math.inf])
def test_a_long_way_of_a_fast_robot_costs_its_time(backend: str, straight: float) -> None:
    """A limit of useful ways that holds for distances is no limit for times."""
    ways = ((0.0, 1.0, 1.0), (1.0, 0.0, straight), (1.0, straight, 0.0))
    instance = Instance(
        warehouse=DistanceTable(ways),
        items=tuple(Item(f"i{k}", 0, Node(k)) for k in (1, 2)),
        orders=tuple(Order(f"i{k}", (f"i{k}",)) for k in (1, 2)),
        robots=(Robot("R1", 1, speed=0.25), Robot("R2", 1, speed=0.7)),
    )
    result = qrobot.solve(instance, backend=backend, objective="time", max_work=50)
    assert result.cost == pytest.approx(2 / 0.25 + 2 / 0.7)
    assert result.bound <= result.cost * (1 + 1e-9)


@settings(deadline=None, max_examples=60)
@given(instance=unlike())
@pytest.mark.parametrize("backend", ["auto", "exact"])
def test_proven_plans_take_the_least_time_of_all(backend: str, instance: Instance) -> None:
    least = least_seconds(instance)
    if math.isinf(least):
        with pytest.raises(qrobot.InfeasibleError):
            qrobot.solve(instance, backend=backend, objective="time", deadline=20)
        return
    result = qrobot.solve(instance, backend=backend, objective="time", deadline=20)
    assert result.is_optimal
    assert result.objective == "time"
    assert result.cost == pytest.approx(least, rel=1e-9)
    assert result.bound <= least * (1 + 1e-9)
    report = qrobot.check(result.plan, instance)
    assert report.ok
    assert report.cost == pytest.approx(least, rel=1e-6)


@settings(deadline=None, max_examples=25)
@given(instance=unlike())
def test_bounds_and_plans_of_pyvrp_are_true(instance: Instance) -> None:
    pytest.importorskip("pyvrp")
    instance = instance.split_orders()
    least = least_seconds(instance)
    if math.isinf(least):
        return
    try:
        result = qrobot.solve(instance, backend="pyvrp", objective="time", max_work=80)
    except qrobot.InfeasibleError:
        return  # none was found: it promises none
    assert result.bound <= least * (1 + 1e-9)
    assert result.cost >= least * (1 - 1e-9)
    assert not result.is_optimal or result.cost == pytest.approx(least, rel=1e-9)


@pytest.fixture
def cart_and_lift(tmp_path: Path) -> Path:
    """Write two items, one far and one near, for a fast robot and a slow one."""
    items = [
        {"id": "far", "weight": 1, "at": {"x": 90, "y": 0}, "pick_seconds": 5},
        {"id": "near", "weight": 1, "at": {"x": 0, "y": 10}, "pick_seconds": 7},
    ]
    robots = [
        {"id": "slow", "capacity": 1, "speed": 0.5},
        {"id": "fast", "capacity": 1, "speed": 2},
    ]
    document = {
        "schema": "qrobot.instance/1",
        "warehouse": {"kind": "floor"},
        "robots": robots,
        "items": items,
    }
    path = tmp_path / "two.json"
    path.write_text(json.dumps(document))
    return path


def command(*words: str) -> Any:
    """Return what a command prints, its JSON as data."""
    done = subprocess.run(
        [sys.executable, "-m", "qrobot", *words],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    return json.loads(done.stdout) if "--json" in words else done.stdout


# 180 m at 2 m/s, 20 m at 0.5 m/s, and 12 s of picks.
LEAST = 180 / 2 + 20 / 0.5 + 12


@pytest.mark.parametrize("backend", ["auto", "exact", "pyvrp"])
def test_the_far_trip_goes_to_the_fast_robot(backend: str, cart_and_lift: Path) -> None:
    if backend == "pyvrp":
        pytest.importorskip("pyvrp")
    result = qrobot.solve(cart_and_lift, backend=backend, objective="time", max_work=50)
    assert result.cost == pytest.approx(LEAST)
    assert {trip.robot: trip.stops for trip in result.plan.trips} == {
        "slow": ("near",),
        "fast": ("far",),
    }


def test_a_backend_that_cannot_is_refused(cart_and_lift: Path) -> None:
    with pytest.raises(qrobot.InputError, match=r"batching cannot .* use one of: auto, exact"):
        qrobot.solve(cart_and_lift, backend="batching", objective="time")
    with pytest.raises(qrobot.InputError, match=r"'tme' is not an objective; did you mean time"):
        qrobot.solve(cart_and_lift, objective="tme")
    with pytest.raises(qrobot.InputError, match="batching cannot"):
        qrobot.solve(cart_and_lift, fallback="batching", objective="time")


@pytest.mark.parametrize("backend", ["auto", "batching", "neal", "qaoa-swap"])
def test_robots_that_are_alike_need_no_special_backend(backend: str, cart_and_lift: Path) -> None:
    instance = qrobot.read(cart_and_lift)
    robots = tuple(replace(robot, speed=2.0) for robot in instance.robots)
    alike = replace(instance, robots=robots)
    told: list[Any] = []
    result = qrobot.solve(
        alike, backend=backend, objective="time", max_work=50, on_progress=told.append
    )
    assert result.cost == pytest.approx(200 / 2 + 12)
    assert result.bound == pytest.approx(result.cost)
    assert result.is_optimal
    assert qrobot.check(result.plan, alike).ok
    assert told[-1].objective == "time"
    assert told[-1].cost == pytest.approx(result.cost)


def test_the_command_plans_for_time_and_check_measures_it(
    cart_and_lift: Path, tmp_path: Path
) -> None:
    plan, picture = tmp_path / "plan.json", tmp_path / "plan.svg"
    solve = ["solve", str(cart_and_lift), "--objective", "time", "-o", str(plan)]
    assert command(*solve, "--json")["result"]["cost"] == pytest.approx(LEAST)
    data = json.loads(plan.read_text())
    assert (data["objective"], data["cost"]) == ("time", pytest.approx(LEAST))
    assert (data["result"]["objective"], data["result"]["cost"]) == ("time", pytest.approx(LEAST))
    assert data["distance"] == pytest.approx(200)
    assert read_plan(plan).to_dict() == {k: v for k, v in data.items() if k != "result"}
    assert "time 142 s (distance 200), proven optimal" in command(*solve)
    assert "time 142" in command("check", str(plan), str(cart_and_lift))
    pytest.importorskip("matplotlib")
    command(*solve, "-p", str(picture))
    assert "time 142 s" in picture.read_text()


def test_a_wrong_cost_is_told(cart_and_lift: Path, tmp_path: Path) -> None:
    result = qrobot.solve(cart_and_lift, objective="time", deadline=5)
    wrong = replace(result.plan, value=LEAST - 1)
    shortest = qrobot.solve(cart_and_lift, deadline=5).plan
    for plan in (wrong, replace(shortest, value=199.0)):
        report = qrobot.check(plan, cart_and_lift)
        assert [problem.kind for problem in report.problems] == ["cost"]
    result.save(path := tmp_path / "plan.json")
    data = json.loads(path.read_text())
    for change in ({"objective": "money"}, {"cost": "142"}):
        path.write_text(json.dumps(data | change))
        with pytest.raises(qrobot.InputError, match=next(iter(change))):
            read_plan(path)
    del data["cost"]
    path.write_text(json.dumps(data))
    with pytest.raises(qrobot.InputError, match="cost: is missing"):
        read_plan(path)


def test_whole_orders_beyond_the_proof_are_planned_with_a_note() -> None:
    from oracles import paper_shaped

    instance = paper_shaped(32, 4, 0)
    pairs = [
        qrobot.Order(f"o{i}", (instance.items[2 * i].id, instance.items[2 * i + 1].id))
        for i in range(16)
    ]
    robots = tuple(
        Robot(r.id, 2 * r.capacity, speed=1.0 + i, trips=16) for i, r in enumerate(instance.robots)
    )
    hard = replace(instance, orders=tuple(pairs), robots=robots)
    result = qrobot.solve(hard, objective="time", max_work=30)
    assert any("no search takes account of time" in note for note in result.notes)
    assert not result.is_optimal
    assert result.bound <= result.cost
    assert qrobot.check(result.plan, hard).ok


def test_another_objective_is_one_entry(
    cart_and_lift: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the drives of the robots take: a joule or five for a metre, two for a stop."""
    energy = Objective(
        "energy",
        "J",
        rate=lambda r: 5.0 if r.id == "fast" else 1.0,
        handling=lambda _times, _item: 2.0,
    )
    monkeypatch.setitem(OBJECTIVES, "energy", energy)
    result = qrobot.solve(cart_and_lift, backend="exact", objective="energy", deadline=5)
    assert result.cost == pytest.approx(180 * 1 + 20 * 5 + 2 * 2)
    assert result.is_optimal
    assert "energy 284 J" in result.summary()
    assert qrobot.check(result.plan, cart_and_lift).ok


def test_deadlines_need_a_backend_that_knows_of_time() -> None:
    """Every backend makes distances small, which is not enough where deadlines bind."""
    instance = qrobot.read("examples/morning.json")
    first = replace(instance.orders[0], deadline=500.0)
    instance = replace(instance, orders=(first, *instance.orders[1:]))
    with pytest.raises(qrobot.InputError, match="batching cannot optimise distance with deadlines"):
        qrobot.solve(instance, backend="batching", max_work=1)


def test_no_plan_is_called_best_where_other_places_take_fewer_picks() -> None:
    """Two near bins with a piece each make two picks, a far one with both only one."""
    items = tuple(Item(f"a{k}", 1, Slot(k, 0), article="nut") for k in range(2))
    stock = (Stock("nut", Slot(0, 0), 1), Stock("nut", Slot(1, 0), 1), Stock("nut", Slot(0, 9), 2))
    instance = Instance(
        AisleWarehouse(2, 10, aisle_pitch=1.0, end_gap=1.0),
        items,
        (Order("A", ("a0", "a1")),),
        (Robot("R", 9, trips=3),),
        stock=stock,
        times=Times(per_pick=100.0),
    )
    far = 2 * 10.0 + 100.0
    for objective in ("time", "makespan", "distance=1,time=1"):
        result = qrobot.solve(instance, objective=objective)
        assert not result.is_optimal
        assert result.bound <= far + (20.0 if "distance" in objective else 0.0)
    assert qrobot.solve(instance).is_optimal  # by metres it is proven
