"""Whole orders batched for the ways of a policy: plans, proofs, and what the checker refuses."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import qrobot
from qrobot import _jit
from qrobot.backends import Stop
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.plan.rules import rule_of
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot
from qrobot.warehouse import ROUTINGS, under_policy

SHARED = Path(__file__).parents[3] / "shared/data/picking"
POLICIES = [name for name in ROUTINGS if name != "exact"]
SLOW = pytest.mark.slow
THROUGH_BLOCKS = [name for name in POLICIES if name not in {"return", "midpoint"}]
COMPILED = pytest.mark.skipif(not _jit.available(), reason="numba is not installed")


def orders(seed: int, count: int, *, back: int = 0, blocks: int = 1) -> Instance:
    """Return some orders of one to three items, two or three of which fit on a trip."""
    rng = np.random.default_rng(seed)
    house = AisleWarehouse(
        6,
        9,
        blocks,
        depot_aisle=int(rng.integers(6)),
        depot_cross_aisle=back * blocks,
        depot_distance=1.0,
    )
    block = (lambda: 0) if blocks == 1 else (lambda: int(rng.integers(blocks)))
    items = [
        Item(f"{o}/{k}", 1, Slot(int(rng.integers(6)), int(rng.integers(9)), block()))
        for o in range(count)
        for k in range(int(rng.integers(1, 4)))
    ]
    lots = [
        Order(f"o{o}", [item.id for item in items if item.id.startswith(f"{o}/")])
        for o in range(count)
    ]
    return Instance(house, tuple(items), tuple(lots), (Robot("R1", 6, trips=count),))


def least(instance: Instance, policy: str) -> float:
    """Return the least length of all partitions of the orders, by the checker's formulas."""
    measure, _ = rule_of(policy, instance.warehouse)
    assert measure is not None
    place = {item.id: item.place for item in instance.items}
    count = len(instance.orders)
    cost = [math.inf] * (1 << count)
    for mask in range(1, 1 << count):
        ids = [i for o, lot in enumerate(instance.orders) if mask >> o & 1 for i in lot.items]
        if len(ids) <= 6:
            cost[mask] = measure(place[i] for i in ids)
    best = [0.0] + [math.inf] * ((1 << count) - 1)
    for mask in range(1, 1 << count):
        first, part = mask & -mask, mask
        while part:
            if part & first:
                best[mask] = min(best[mask], cost[part] + best[mask ^ part])
            part = (part - 1) & mask
    return best[-1]


@COMPILED
@pytest.mark.parametrize("policy", POLICIES)
def test_the_best_batches_are_found_and_proven(policy: str) -> None:
    for seed in range(2):
        instance = orders(seed, 7, back=seed % 2)
        result = qrobot.solve(instance, routing=policy, max_work=400)
        assert result.is_optimal
        assert result.plan.routing == policy
        assert result.plan.distance == pytest.approx(least(instance, policy))
        assert qrobot.check(result.plan, instance).ok
        assert result.plan.distance >= qrobot.solve(instance, max_work=400).plan.distance - 1e-9


@COMPILED
@pytest.mark.parametrize("listed", [True, False])
@pytest.mark.parametrize(
    "policy", ["s-shape", *(pytest.param(p, marks=SLOW) for p in THROUGH_BLOCKS if p != "s-shape")]
)
def test_the_best_batches_through_blocks_are_found_and_proven(
    policy: str, listed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether batches are all listed, or left out by what no longer batch is shorter than."""
    if not listed:
        monkeypatch.setattr("qrobot.backends.classical.generation.search.MOST_BATCHES", 0)
    for seed in range(4):
        instance = orders(seed, 7, back=seed % 2, blocks=2 + seed // 2)
        best = least(instance, policy)
        result = qrobot.solve(instance, routing=policy, max_work=4_000)
        assert result.is_optimal
        assert result.plan.distance == pytest.approx(best)
        assert result.bound == pytest.approx(best)
        assert qrobot.check(result.plan, instance).ok
        wrong = qrobot.check(replace(result.plan, routing="return"), instance)
        assert "the routing 'return' needs one block of aisles" in str(wrong)


def test_a_trip_is_walked_alike_in_whatever_sequence_its_nodes_come() -> None:
    """Some places differ by their block only; which of a set comes first is left to chance."""
    house = AisleWarehouse(6, 9, 3, depot_distance=1.0)
    for seed in range(250):
        rng = np.random.default_rng(seed)
        spots = [(int(rng.integers(6)), int(rng.integers(9))) for _ in range(6)]
        items = [
            Item(f"{k}/{b}", 1, Slot(a, s, b)) for k, (a, s) in enumerate(spots) for b in (0, 1)
        ]
        lots = tuple(Order(item.id, (item.id,)) for item in items)
        asked = under_policy(Instance(house, tuple(items), lots, (Robot("R1", 99),)), "s-shape")
        nodes = list(range(1, len(items) + 1))
        for _ in range(2):
            (walked,) = asked.in_sequence([nodes])
            assert qrobot.check(Plan.from_routes(asked, [walked]), asked).ok, seed
            rng.shuffle(nodes)


@COMPILED
def test_a_way_may_be_longer_than_those_of_its_orders_together() -> None:
    """Aisles that a trip of few picks turns in, S-shape passes: no proof may rely on less."""
    from qrobot.backends.classical.generation import generate

    places = [Slot(0, 0), Slot(3, 0), Slot(1, 0), Slot(2, 0)]
    items = tuple(Item(f"i{k}", 1, place) for k, place in enumerate(places))
    lots = tuple(Order(f"o{k}", (item.id,)) for k, item in enumerate(items))
    instance = Instance(AisleWarehouse(4, 60), items, lots, (Robot("R1", 2, trips=2),))
    best = qrobot.check(qrobot.solve(instance, routing="s-shape", max_work=50).plan, instance)
    # Twice two aisles of 61 m; across, 6 m to aisle 1 and back, and 18 m to aisle 3 and back.
    assert best.distance == 4 * 61 + 6 + 18
    poor = [[1, 2], [3, 4]]
    asked = under_policy(instance, "s-shape")
    assert asked.length(poor) == 4 * 61 + 18 + 12
    proof = generate(asked, Stop(max_work=50), start=poor)
    assert proof.optimal
    assert proof.routes is not None
    assert asked.length(proof.routes) == best.distance


@COMPILED
@pytest.mark.parametrize("backend", ["fcfs", "seed", "savings", "batching", "exact"])
def test_every_planner_measures_by_the_policy(backend: str) -> None:
    instance = orders(5, 8)
    best = least(instance, "largest-gap")
    result = qrobot.solve(instance, backend=backend, routing="largest-gap", max_work=200)
    assert qrobot.check(result.plan, instance).ok
    assert result.plan.distance >= best - 1e-9
    assert result.bound <= best + 1e-9
    if result.is_optimal:
        assert result.plan.distance == pytest.approx(best)


@COMPILED
@pytest.mark.skipif(not SHARED.is_dir(), reason="the published files are not here")
@pytest.mark.parametrize(
    "name",
    [
        "S-Shape__25s-30-30-8",
        pytest.param("S-Shape__26s-30-45-4", marks=pytest.mark.slow),
        pytest.param("Largest_Gap__5l-30-30-0", marks=pytest.mark.slow),
    ],
)
def test_proven_values_are_the_published_ones(name: str) -> None:
    """Wahlen and Gschwind (2023), files of Henn."""
    file = f"henn/uniform_{name}.txt"
    entries = json.loads((SHARED / "index.json").read_text())
    published = next(entry["published"] for entry in entries if entry["file"] == file)
    instance = qrobot.read(SHARED / file)
    names = {"s-shape": "traversal", "largest-gap": "largest_gap"}
    for policy in ("s-shape", "return", "midpoint", "largest-gap", "combined"):
        value = published[names.get(policy, policy)]
        assert value["proven"]
        result = qrobot.solve(instance, routing=policy, max_work=3_000)
        assert result.is_optimal
        assert result.plan.distance == value["value"]


@COMPILED
def test_a_plan_keeps_its_policy_and_the_checker_verifies_it(tmp_path: Path) -> None:
    instance = orders(1, 6)
    result = qrobot.solve(instance, routing="s-shape", max_work=200)
    result.save(tmp_path / "plan.json")
    data = json.loads((tmp_path / "plan.json").read_text())
    assert data["routing"] == "s-shape"
    schema = Path(qrobot.__file__).parent / "plan" / "plan.schema.json"
    jsonschema.validate(data, json.loads(schema.read_text()))
    assert qrobot.check(tmp_path / "plan.json", instance).ok
    qrobot.plot(result, tmp_path / "plan.svg")

    del data["routing"]
    as_shortest = qrobot.check(Plan.from_dict(data), instance)
    assert {problem.kind for problem in as_shortest.problems} == {"distance", "total"}
    other = qrobot.check(replace(result.plan, routing="return"), instance)
    assert {problem.kind for problem in other.problems} >= {"distance", "total"}
    unknown = qrobot.check(replace(result.plan, routing="zigzag"), instance)
    assert "the routing 'zigzag' is not known" in str(unknown)
    closed = replace(instance.warehouse, closed_crossings=frozenset({(1, 0)}))
    shut = qrobot.check(result.plan, replace(instance, warehouse=closed))
    assert "the routing 's-shape' needs aisles that are open in both directions" in str(shut)


def test_stops_in_a_sequence_that_the_policy_does_not_take_are_refused() -> None:
    house = AisleWarehouse(3, 9)
    items = tuple(Item(f"i{k}", 1, Slot(a, s)) for k, (a, s) in enumerate([(0, 2), (2, 7), (0, 6)]))
    instance = Instance(house, items, (Order("o", ("i0", "i1", "i2")),), (Robot("R1", 5),))
    plan = qrobot.solve(instance, routing="s-shape", max_work=20).plan
    assert plan.distance == 2 * 10 + 2 * 6
    assert plan.trips[0].stops == ("i0", "i2", "i1")
    to_and_fro = replace(plan, trips=(replace(plan.trips[0], stops=("i0", "i1", "i2")),))
    (problem,) = qrobot.check(to_and_fro, instance).problems
    assert problem.kind == "routing"
    assert "trip 1 needs" in problem.text


@pytest.mark.parametrize("backend", ["neal", "pyvrp"])
def test_backends_that_know_shortest_tours_only_say_so(backend: str) -> None:
    with pytest.raises(InputError, match=f"backend {backend} plans shortest tours only; use one"):
        qrobot.solve(orders(0, 3), backend=backend, routing="return")
