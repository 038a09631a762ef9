"""Waves: cut as asked, planned one after the other, with a price that is honest."""

from __future__ import annotations

import dataclasses
import json
import math
import random
from collections import Counter, defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance

import qrobot
from qrobot.backends import Stop, capabilities
from qrobot.planning.waves import Wave, Waves, cut, plan_waves, running
from qrobot.planning.waves.bounding import pool_bound
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
    Stock,
    Warehouse,
)

SCHEMA = json.loads(
    (Path(qrobot.__file__).parent / "planning" / "waves" / "waves.schema.json").read_text()
)
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
HOUSES: dict[str, Warehouse] = {
    "aisles": AisleWarehouse(aisles=6, slots=5, blocks=2, depot_aisle=2),
    "floor": OpenFloor(5.0, 5.0),
    "table": DistanceTable(
        tuple(tuple(float((3 * i + 5 * j) % 7 + abs(i - j)) for j in range(9)) for i in range(9))
    ),
}


def pool_in(
    kind: str, orders: int, seed: int = 0, *, trips: int = 3, robots: int = 2, lines: int = 3
) -> Instance:
    """Return a pool of orders of a few items."""
    rng = random.Random(seed)

    def place() -> Place:
        if kind == "aisles":
            return Slot(rng.randrange(6), rng.randrange(5), rng.randrange(2))
        return (
            Point(rng.randrange(11), rng.randrange(11))
            if kind == "floor"
            else Node(rng.randrange(9))
        )

    items, lots = [], []
    for o in range(orders):
        own = [Item(f"o{o}-{k}", rng.randint(1, 4), place()) for k in range(rng.randint(1, lines))]
        items += own
        due = rng.choice([100.0, 200.0, 300.0, math.inf])
        lots.append(Order(f"o{o}", [item.id for item in own], due=due))
    fleet = tuple(Robot(f"R{r + 1}", 15, trips=trips) for r in range(robots))
    return Instance(HOUSES[kind], tuple(items), tuple(lots), fleet, name="pool", pool=True)


def stops_of(pool: Instance, orders: tuple[int, ...]) -> int:
    """Return the number of places of each order, counted from the items themselves."""
    place = {item.id: item.place for item in pool.items}
    return sum(len({place[name] for name in pool.orders[o].items}) for o in orders)


@settings(max_examples=40, deadline=None)
@given(
    kind=st.sampled_from(sorted(HOUSES)),
    by=st.sampled_from(["size", "due"]),
    orders=st.integers(0, 40),
    size=st.integers(3, 30),
    seed=st.integers(0, 10**6),
)
def test_every_order_is_in_one_wave_that_fits(
    kind: str, by: str, orders: int, size: int, seed: int
) -> None:
    pool = pool_in(kind, orders, seed)
    waves = cut(pool, by=by, size=size)
    assert sorted(o for wave in waves for o in wave) == list(range(orders))
    weight = {item.id: item.weight for item in pool.items}
    for wave in waves:
        assert wave
        assert stops_of(pool, wave) <= size
        loads = [sum(weight[name] for name in pool.orders[o].items) for o in wave]
        assert packed(loads, 6, 15), "a wave that no trips can carry"
    if by == "due":
        due = [[pool.orders[o].due for o in wave] for wave in waves]
        assert all(max(a) <= min(b) for a, b in pairwise(due))


def packed(loads: list[Any], trips: int, room: int) -> bool:
    """Return whether loads fit into trips, by trying (up to a few thousand ways)."""
    states = {(room,) * trips}
    for load in sorted(loads, reverse=True):
        states = {
            tuple(sorted((*left[:k], left[k] - load, *left[k + 1 :])))
            for left in states
            for k in range(trips)
            if left[k] >= load
        }
        states = set(sorted(states)[:2000])
    return bool(states)


def test_like_sizes_and_not_more_waves_than_needed() -> None:
    pool = pool_in("floor", 200, trips=200, lines=1)
    waves = cut(pool, size=60)
    assert [len(wave) for wave in waves] == [50] * 4
    assert len(cut(pool, size=200)) == 1


def test_neighbours_are_together_in_aisles() -> None:
    pool = pool_in("aisles", 60, trips=60, lines=1)
    aisle = {item.id: item.place.aisle for item in pool.items if isinstance(item.place, Slot)}
    waves = [[aisle[pool.orders[o].items[0]] for o in wave] for wave in cut(pool, size=20)]
    assert all(max(a) <= min(b) for a, b in pairwise(waves))


def test_neighbours_are_together_around_the_depot() -> None:
    pool = pool_in("floor", 60, trips=60, lines=1)
    at = {i.id: i.place for i in pool.items if isinstance(i.place, Point)}

    def angle(order: Order) -> float:
        place = at[order.items[0]]
        return math.atan2(place.y - 5, place.x - 5)

    waves = [[angle(pool.orders[o]) for o in wave] for wave in cut(pool, size=20)]
    assert all(max(a) <= min(b) for a, b in pairwise(waves))


@pytest.mark.parametrize("zones", ["blocks", "0-1,2-5", "0,1,2,3-5"])
def test_zones_are_where_most_items_lie(zones: str) -> None:
    pool = pool_in("aisles", 40, trips=40)
    place = {item.id: item.place for item in pool.items if isinstance(item.place, Slot)}
    bounds = {"0-1,2-5": (2,), "0,1,2,3-5": (1, 2, 3)}.get(zones, ())

    def zone(spot: Slot) -> int:
        return spot.block if zones == "blocks" else sum(spot.aisle >= b for b in bounds)

    waves = cut(pool, by="zone", zones=zones, size=1000)
    homes = []
    for wave in waves:
        counted = [Counter(zone(place[n]) for n in pool.orders[o].items) for o in wave]
        common = set.intersection(
            *({z for z, n in count.items() if n == max(count.values())} for count in counted)
        )
        assert common
        homes.append(min(common))
    assert len(set(homes)) == len(homes) == (2 if zones == "blocks" else len(bounds) + 1)


@pytest.mark.parametrize(
    ("wish", "says"),
    [
        ({"by": "colour"}, "by: 'colour' is no way to cut; use one of: size, due, zone"),
        ({"size": 0}, "size: 0 is not 1 to 2500 stops"),
        ({"size": 2501}, "size: 2501 is not 1 to 2500 stops"),
        ({"size": 1}, "alone has 2 stops, more than the 1 of a wave; give more"),
        ({"by": "zone", "zones": "left"}, "zones: 'left' is no range of aisles"),
        ({"by": "zone", "zones": "0-4"}, "zones: aisle 5 is in no zone; give each aisle one"),
        ({"by": "zone", "zones": "0-4,4-5"}, "zones: aisle 4 is in two zones"),
    ],
)
def test_what_cannot_be_cut_is_refused(wish: dict[str, Any], says: str) -> None:
    with pytest.raises(qrobot.InputError) as refused:
        cut(pool_in("aisles", 20), **wish)
    assert says in str(refused.value)


def test_zones_need_aisles_and_orders_need_a_robot() -> None:
    with pytest.raises(qrobot.InputError, match="zones are blocks or aisles"):
        cut(pool_in("floor", 3), by="zone")
    pool = pool_in("floor", 5)
    small = dataclasses.replace(pool, robots=(Robot("R1", 1),))
    with pytest.raises(qrobot.InfeasibleError, match="no robot holds more than 1"):
        cut(small)


@settings(max_examples=25, deadline=None)
@given(kind=st.sampled_from(sorted(HOUSES)), orders=st.integers(1, 6), seed=st.integers(0, 10**6))
def test_no_plan_is_below_the_bound_of_the_pool(kind: str, orders: int, seed: int) -> None:
    pool = pool_in(kind, orders, seed, trips=6, lines=2)
    least = least_distance(dataclasses.replace(pool, pool=False))
    assert least is not None
    assert 0 <= pool_bound(pool) <= least[0] + 1e-9


def test_one_order_in_aisles_is_bounded_by_its_shortest_tour() -> None:
    pool = pool_in("aisles", 1, seed=8, lines=6)
    least = least_distance(dataclasses.replace(pool, pool=False))
    assert least is not None
    assert pool_bound(pool) == pytest.approx(least[0])


def test_nobody_makes_the_distances_of_a_large_pool(monkeypatch: pytest.MonkeyPatch) -> None:
    pool = pool_in("aisles", 3000, trips=3000)
    asked = []
    whole = AisleWarehouse.distance_matrix

    def spy(house: AisleWarehouse, places: Any) -> Any:
        asked.append(len(places))
        return whole(house, places)

    wide = AisleWarehouse(aisles=60, slots=60, blocks=2)
    items = tuple(
        dataclasses.replace(item, place=Slot(k % 60, k // 60 % 60, k % 2))
        for k, item in enumerate(pool.items)
    )
    pool = dataclasses.replace(pool, warehouse=wide, items=items)
    assert len(pool.places) > 2500
    monkeypatch.setattr(AisleWarehouse, "distance_matrix", spy)
    assert len(cut(pool)) == 3
    assert pool_bound(pool) > 0
    assert max(asked) <= 200


def planned(pool: Instance, **wish: Any) -> Waves:
    return plan_waves(pool, max_work=50, **wish)


@pytest.mark.parametrize("kind", sorted(HOUSES))
def test_all_orders_are_planned_once_and_the_price_is_that_of_the_plans(kind: str) -> None:
    pool = pool_in(kind, 24, trips=8)
    told: list[Wave] = []
    waves = planned(pool, size=14, compare=True, pairs=True, on_wave=told.append)
    assert waves.is_complete
    assert list(waves.waves) == told
    VALIDATOR.validate(json.loads(waves.to_json()))
    taken = Counter(s for w in waves.waves for trip in w.plan.trips for s in trip.stops)
    assert taken == Counter(item.id for item in pool.items)
    lengths = [trip.distance for w in waves.waves for trip in w.plan.trips]
    assert waves.cost == pytest.approx(math.fsum(lengths))
    assert waves.gap is not None
    assert waves.bound <= waves.cost == pytest.approx(waves.bound * (1 + waves.gap))
    whole = waves.compared[-1]
    assert whole.waves == tuple(range(1, waves.expected + 1))
    assert whole.apart == pytest.approx(waves.cost)
    assert whole.together >= max(whole.bound, waves.bound) - 1e-9
    text = waves.to_text()
    assert "in one plan, with as much time" in text
    assert len(waves.compared) == 1 + waves.expected // 2
    for pair in waves.compared[:-1]:
        own = [w.plan.cost for w in waves.waves if w.number in pair.waves]
        assert pair.apart == pytest.approx(sum(own))


def test_waves_begin_when_the_last_robot_is_back() -> None:
    pool = pool_in("floor", 12, trips=4)
    waves = planned(pool, by="due", size=9)
    watch = 0.0
    for wave in waves.waves:
        assert wave.begins == pytest.approx(watch)
        spent: dict[str, float] = defaultdict(float)
        for trip in wave.plan.trips:
            spent[trip.robot] += trip.distance
        for order in wave.instance.orders:
            asked = next(o for o in pool.orders if o.id == order.id)
            assert order.due == pytest.approx(max(0.0, asked.due - watch))
        watch += max(spent.values())
    late = {name for w in waves.waves for name in waves.late(w)}
    for wave in waves.waves:
        for trip in wave.plan.trips[-1:]:
            asked = next(o for o in pool.orders if o.id == trip.orders[0])
            own = [t.distance for t in wave.plan.trips if t.robot == trip.robot]
            assert (trip.orders[0] in late) == (wave.begins + sum(own) > asked.due)


def test_a_deadline_that_a_late_wave_cannot_keep_is_told() -> None:
    pool = pool_in("floor", 12)
    last = cut(pool, size=9)[-1][0]
    orders = [
        dataclasses.replace(order, due=math.inf, deadline=1.0 if o == last else math.inf)
        for o, order in enumerate(pool.orders)
    ]
    with pytest.raises(qrobot.InfeasibleError, match="must be back at 1 s; cut by due, or use"):
        planned(dataclasses.replace(pool, orders=tuple(orders)), size=9)


def test_waves_share_a_stock() -> None:
    """Two places have enough for all together, the nearer one for one wave only."""
    items = tuple(Item(f"i{k}", 1, Slot(5, 4), article="bolt") for k in range(6))
    orders = tuple(Order(f"o{k}", (item.id,)) for k, item in enumerate(items))
    stock = (Stock("bolt", Slot(5, 4), 6), Stock("bolt", Slot(2, 0), 3))
    pool = Instance(
        HOUSES["aisles"], items, orders, (Robot("R1", 1, trips=1),), stock=stock, pool=True
    )
    waves = planned(pool)
    assert waves.expected == 6
    taken = Counter[Place]()
    for wave in waves.waves:
        for pick in wave.plan.picks:
            taken[pick.place] += pick.quantity
    assert taken.total() == 6
    assert taken[Slot(2, 0)] == 3, "what is near is taken first, and not twice"
    with pytest.raises(qrobot.InputError, match="share a stock"):
        planned(pool, size=2, pairs=True)


def test_interrupted_waves_are_planned_again_and_finished_ones_stay(tmp_path: Path) -> None:
    pool = pool_in("floor", 18, trips=4)
    stop = Stop()

    def after_two(wave: Wave) -> None:
        if wave.number == 2:
            stop.request()

    first = planned(pool, size=9, folder=tmp_path, stop=stop, on_wave=after_two)
    assert (len(first.waves), first.is_complete, first.gap) == (2, False, None)
    assert "go on with --resume" in first.to_text()
    VALIDATOR.validate(json.loads((tmp_path / "waves.json").read_text()))
    kept = (tmp_path / "wave-001.plan.json").read_bytes()
    broken = json.loads((tmp_path / "wave-002.plan.json").read_text())
    broken["result"]["ended"] = "interrupted"
    (tmp_path / "wave-002.plan.json").write_text(json.dumps(broken))
    with pytest.raises(qrobot.InputError, match="has waves already; go on with --resume"):
        planned(pool, size=9, folder=tmp_path)
    for other, what in (
        ({"size": 10}, "with another size"),
        ({"size": 9, "by": "due"}, "with another by"),
        ({"size": 9, "seed": 1}, "with another seed"),
    ):
        with pytest.raises(qrobot.InputError, match=what):
            planned(pool, folder=tmp_path, resume=True, **other)
    with pytest.raises(qrobot.InputError, match="of another pool"):
        planned(pool_in("floor", 19, trips=4), size=9, folder=tmp_path, resume=True)
    again = planned(pool, size=9, folder=tmp_path, resume=True)
    assert again.is_complete
    assert (tmp_path / "wave-001.plan.json").read_bytes() == kept
    apart = planned(pool, size=9)
    assert [w.plan.cost for w in again.waves] == pytest.approx([w.plan.cost for w in apart.waves])
    for wave in again.waves:
        question = tmp_path / f"wave-{wave.number:03d}.json"
        assert qrobot.check(tmp_path / f"wave-{wave.number:03d}.plan.json", question).ok
    (tmp_path / "waves.json").write_text("{}")
    with pytest.raises(qrobot.InputError, match="is not a summary of schema"):
        planned(pool, size=9, folder=tmp_path, resume=True)


@pytest.mark.parametrize(
    ("wish", "says"),
    [
        ({"objective": "makespan"}, "objective: 'makespan' of several waves is no sum; use one"),
        ({"deadline": 0}, "deadline"),
    ],
)
def test_what_waves_cannot_do_is_refused(wish: dict[str, Any], says: str) -> None:
    with pytest.raises(qrobot.InputError) as refused:
        plan_waves(pool_in("floor", 4), **wish)
    assert says in str(refused.value)


def test_remote_backends_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    far = dataclasses.replace(capabilities("neal"), local=False)
    monkeypatch.setattr(running, "capabilities", lambda _: far)
    with pytest.raises(qrobot.InputError, match="backend neal is remote; name a local one"):
        plan_waves(pool_in("floor", 4), backend="neal")


def test_a_pool_that_is_too_large_cannot_be_compared() -> None:
    pool = pool_in("floor", 2600, trips=2600, lines=1)
    with pytest.raises(
        qrobot.InputError, match="compare: the pool cannot be planned at once: 2600"
    ):
        plan_waves(pool, compare=True)


def test_a_shared_deadline_leaves_no_wave_without_a_plan() -> None:
    waves = plan_waves(pool_in("floor", 30, trips=6), size=9, deadline=0.2)
    assert waves.is_complete
