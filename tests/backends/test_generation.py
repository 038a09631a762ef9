"""Batches of whole orders in aisles: proven against every partition, and by any search."""

import hashlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from oracles import least_distance
from slow import slow

from qrobot import _jit, solve
from qrobot.backends import Stop
from qrobot.backends.classical.aisles import compiled_soon, takes
from qrobot.backends.classical.batching import BatchingPlanner
from qrobot.backends.classical.exact import ExactPlanner
from qrobot.backends.classical.generation import generate
from qrobot.plan import Plan, check
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot

pytestmark = pytest.mark.skipif(not _jit.available(), reason="numba is not installed")


def some_orders(seed: int, orders: int, blocks: int, capacities: tuple[int, ...]) -> Instance:
    """Return random whole orders; a robot makes any number of trips with each capacity."""
    rng = np.random.default_rng(seed)
    items, lots = [], []
    for order in range(orders):
        ids = [f"{order}/{k}" for k in range(rng.integers(1, 5))]
        lots.append(Order(f"{order}", ids))
        for name in ids:
            slot = Slot(int(rng.integers(5)), int(rng.integers(70)), int(rng.integers(blocks)))
            items.append(Item(name, int(rng.integers(1, 4)), slot))
    closed = frozenset({(2, 0)}) if blocks > 1 and seed % 2 else frozenset()
    items = [i for i in items if (i.place.aisle, i.place.block) not in closed]
    present = {item.id for item in items}
    lots = [Order(o.id, kept) for o in lots if (kept := [i for i in o.items if i in present])]
    return Instance(
        warehouse=AisleWarehouse(
            5,
            70,
            blocks,
            aisle_pitch=2.5,
            depot_aisle=seed % 5,
            depot_cross_aisle=seed % (blocks + 1),
            depot_distance=1.5,
            closed_aisles=closed,
        ),
        items=tuple(items),
        orders=tuple(lots),
        robots=tuple(
            Robot(f"R{k}", capacity, trips=2 if k < len(capacities) - 1 else orders)
            for k, capacity in enumerate(capacities)
        ),
    )


def least(instance: Instance) -> float:
    """Return the least distance of any plan."""
    found = least_distance(instance)
    assert found is not None
    return found[0]


@pytest.mark.parametrize("blocks", [1, 2])
@pytest.mark.parametrize(
    "depot", [{"depot_offset": 1.0}, {"depot_ways": ((1, 2.95), (2, 5.25), (4, 10.15))}]
)
def test_depots_with_several_ways_are_proven_too(depot: dict[str, Any], blocks: int) -> None:
    instance = some_orders(5 * blocks + 5, 5, blocks, (11,))
    warehouse = replace(instance.warehouse, depot_cross_aisle=0, **depot)  # type: ignore[type-var]
    instance = replace(instance, warehouse=warehouse)
    found = generate(instance, Stop())
    assert found.optimal
    assert found.routes is not None
    assert instance.length(found.routes) == pytest.approx(least(instance), abs=1e-9)
    assert check(Plan.from_routes(instance, found.routes), instance).ok


@pytest.mark.parametrize("blocks", [1, 2])
@pytest.mark.parametrize("seed", [0, 1, *map(slow, range(2, 6))])
def test_generation_proves_the_least_of_all_partitions(seed: int, blocks: int) -> None:
    instance = some_orders(seed, 6, blocks, (14, 9) if seed % 3 else (11,))
    expected = least(instance)
    found = generate(instance, Stop())
    assert found.optimal
    assert found.routes is not None
    assert instance.length(found.routes) == pytest.approx(expected, abs=1e-9)
    assert found.bound == pytest.approx(expected, abs=1e-9)
    plan = Plan.from_routes(instance, found.routes)
    assert check(plan, instance).ok


@pytest.mark.parametrize("seed", range(3))
def test_searches_and_proofs_agree_on_more_orders(seed: int) -> None:
    """Annealing never falls below the proof; the proof's plan is checked, its bound is met."""
    instance = some_orders(100 + seed, 16, 1, (16, 12))
    proven = ExactPlanner().search(instance, stop=Stop(), seed=seed)
    assert proven.optimal
    assert proven.routes is not None
    searched = BatchingPlanner().search(instance, stop=Stop(max_work=60), seed=seed)
    assert searched.routes is not None
    best = instance.length(proven.routes)
    assert instance.length(searched.routes) >= best - 1e-9
    assert instance.length(searched.routes) <= 1.05 * best
    for routes in (proven.routes, searched.routes):
        assert check(Plan.from_routes(instance, routes), instance).ok


def test_one_seed_and_limit_of_work_give_one_plan() -> None:
    instance = some_orders(7, 20, 2, (15,))
    plans = [
        BatchingPlanner().search(instance, stop=Stop(max_work=20), seed=3).routes for _ in range(2)
    ]
    assert plans[0] == plans[1]


def test_a_plan_to_start_from_is_never_lost() -> None:
    instance = some_orders(8, 12, 1, (15,))
    start = BatchingPlanner().search(instance, stop=Stop(max_work=40), seed=0).routes
    assert start is not None
    again = BatchingPlanner().search(instance, stop=Stop(max_work=1), seed=9, start=start)
    assert again.routes is not None
    assert instance.length(again.routes) <= instance.length(start) + 1e-9


def test_an_interrupted_proof_keeps_the_plan_and_a_valid_bound() -> None:
    instance = some_orders(9, 16, 1, (16,))
    best = ExactPlanner().search(instance, stop=Stop())
    start = BatchingPlanner().search(instance, stop=Stop(max_work=1), seed=0).routes
    stop = Stop()
    stop.request()
    found = generate(instance, stop, start=start)
    assert found.routes == start
    assert best.routes is not None
    assert found.bound <= instance.length(best.routes) + 1e-9


def test_it_proves_that_no_packing_exists() -> None:
    """Three orders of 6 fit on two trips of 11 by their sum only."""
    items = tuple(Item(f"{k}", 6, Slot(k, 3)) for k in range(3))
    instance = Instance(
        warehouse=AisleWarehouse(3, 9),
        items=items,
        orders=tuple(Order(item.id, [item.id]) for item in items),
        robots=(Robot("R1", 11, trips=2),),
    )
    found = generate(instance, Stop(max_work=30))
    assert found.routes is None
    assert found.infeasible is not None


def test_without_compiled_kernels_a_short_run_plans_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No robot waits for a compiler: with little time another search runs, and says so."""
    monkeypatch.setattr(_jit, "is_cached", lambda *_: False)
    monkeypatch.setattr("qrobot.backends.classical.aisles.slowdown", lambda: 1.0)
    instance = some_orders(10, 16, 1, (16,))
    assert takes(instance)
    assert not compiled_soon(Stop(5))
    assert compiled_soon(Stop())
    result = solve(instance, deadline=2.0)
    assert any("qrobot compile" in note for note in result.notes)


def test_the_cache_is_found_where_numba_keeps_it(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "kernels.py"
    source.write_text("text")
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    cache_folder = tmp_path / "cache"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(cache_folder))
    assert not _jit.is_cached(source, "sweep")
    (cache_folder / "here_abc").mkdir(parents=True)
    index = cache_folder / "here_abc" / _jit._index_of(source, "sweep").replace("*", "12")
    index.write_bytes(b"0.68" + hashlib.sha256(b"text").digest() + b"cortex-a72")
    assert _jit.is_cached(source, "sweep")
    assert not _jit.is_cached(source, "other")
    monkeypatch.setenv("NUMBA_CPU_NAME", "cortex-a72")
    assert _jit.is_cached(source, "sweep")
    monkeypatch.setenv("NUMBA_CPU_NAME", "cortex-a76")
    assert not _jit.is_cached(source, "sweep")
    monkeypatch.delenv("NUMBA_CPU_NAME")
    source.write_text("other")
    assert not _jit.is_cached(source, "sweep")


def test_a_limit_of_work_ends_a_proof_and_repeats_it() -> None:
    """24 orders on three trips are too many to be proven in 12 lists of batches."""
    instance = some_orders(11, 24, 1, (24,))
    found = [solve(instance, backend="exact", max_work=12, seed=1) for _ in range(2)]
    assert not found[0].is_optimal
    assert found[0].plan.to_dict() == found[1].plan.to_dict()
    assert found[0].bound == found[1].bound


def test_parts_of_one_bound_are_taken_in_turn() -> None:
    """Equal orders make equal bounds: the parts themselves are never compared."""
    items = [Item(f"{o}/{k}", 3, Slot(1 + k, 5)) for o in range(9) for k in range(2)]
    instance = Instance(
        warehouse=AisleWarehouse(4, 9),
        items=tuple(items),
        orders=tuple(Order(f"{o}", [f"{o}/0", f"{o}/1"]) for o in range(9)),
        robots=(Robot("R1", 14, trips=9),),
    )
    found = generate(instance, Stop(max_work=400))
    assert found.optimal
    assert found.routes is not None
    assert len(found.routes) == 5
