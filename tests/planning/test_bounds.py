"""Lower bounds: never above the optimum, on any kind of instance, and useful at any size."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, permutations
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from slow import slow
from strategies import instances

import qrobot
from qrobot import _jit
from qrobot.backends import Stop
from qrobot.planning import bounding
from qrobot.planning.bounding import begin_bound, time_to_search
from qrobot.planning.bounds import (
    fewest_trips,
    forest_bound,
    most_trips,
    quick_bound,
    radial_bound,
    tours_bound,
    walk_bound,
)
from qrobot.planning.bounds.quick import shortest_ways
from qrobot.planning.run import Run
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    FloorMap,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Point,
    Robot,
    Slot,
)


def never() -> bool:
    return False


def wave(orders: int, lines: int, seed: int = 0, *, room: int = 40) -> Instance:
    """Whole orders of several lines in a large warehouse."""
    rng = np.random.default_rng(seed)
    items, lots = [], []
    for o in range(orders):
        names = [f"o{o}-{k}" for k in range(lines)]
        items += [
            Item(name, Fraction(int(rng.integers(1, 6))), Slot(*rng.integers(0, 20, 2).tolist()))
            for name in names
        ]
        lots.append(Order(f"o{o}", tuple(names)))
    total = sum(int(item.weight) for item in items)
    fleet = tuple(Robot(f"R{k}", Fraction(room)) for k in range(2 * -(-total // room)))
    layout = AisleWarehouse(aisles=20, slots=20)
    return Instance(layout, tuple(items), tuple(lots), fleet)


def as_it_is(instance: Instance) -> Instance:
    """Unchanged."""
    return instance


def on_a_floor(instance: Instance, rounding: Literal["none", "nearest"] = "none") -> Instance:
    """Its slots as points of a floor."""
    items = tuple(
        replace(i, place=Point(3.0 * i.place.aisle, 1.5 * i.place.slot))
        for i in instance.items
        if isinstance(i.place, Slot)
    )
    return replace(instance, warehouse=OpenFloor(0, 0, rounding=rounding), items=items)


def as_a_table(instance: Instance) -> Instance:
    """Its distances as a table, which is not known to obey the triangle inequality."""
    table = DistanceTable(tuple(map(tuple, instance.distances.tolist())))
    items = tuple(replace(i, place=Node(k + 1)) for k, i in enumerate(instance.items))
    return replace(instance, warehouse=table, items=items)


def radial_of_the_literature(instance: Instance) -> float:
    """Sum of 2 x farthest item x weight / largest capacity, from the items themselves."""
    d = instance.distances
    away = {item.id: d[0, k + 1] + d[k + 1, 0] for k, item in enumerate(instance.items)}
    weight = {item.id: item.weight for item in instance.items}
    room = float(max(robot.capacity for robot in instance.robots))
    return sum(
        max(away[i] for i in order.items) * float(sum(weight[i] for i in order.items)) / room
        for order in instance.orders
    )


@settings(deadline=None, max_examples=100)
@given(instances(min_items=1, max_items=7, multi_trip=True), st.booleans())
def test_no_bound_exceeds_the_optimum(instance: Instance, known: bool) -> None:
    """Whole orders, zero weights, unlike robots, asymmetric and non-metric tables."""
    expected = least_distance(instance)
    if expected is None:
        return
    least, trips = expected
    upper = least if known else math.inf
    limit = least * (1 + 1e-9) + 1e-9
    assert fewest_trips(instance) <= trips
    assert radial_bound(instance) <= quick_bound(instance) <= limit
    assert tours_bound(instance) <= limit
    assert walk_bound(instance, upper, never, 40) <= limit
    assert forest_bound(instance, upper, never, 60) <= limit


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(1, 4), st.sampled_from([4, 8, 100]))
def test_tours_of_orders_bound_plans_in_aisles(
    seed: int, orders: int, blocks: int, room: int
) -> None:
    """Never below the ways out and back; the optimum where one order is all there is."""
    rng = np.random.default_rng(seed)
    house = AisleWarehouse(aisles=3, slots=4, blocks=blocks, depot_aisle=int(rng.integers(3)))
    items = [
        Item(f"o{o}-{k}", 1, Slot(*rng.integers(0, 3, 2).tolist(), int(rng.integers(blocks))))
        for o in range(orders)
        for k in range(int(rng.integers(2, 4)))
    ]
    lots = [
        Order(f"o{o}", [i.id for i in items if i.id.startswith(f"o{o}-")]) for o in range(orders)
    ]
    fleet = (Robot("R", room, trips=orders),)
    instance = Instance(house, tuple(items), tuple(lots), fleet)
    least = least_distance(instance)
    assert least is not None
    bound = tours_bound(instance)
    assert bound <= least[0] * (1 + 1e-9)
    if instance.whole_orders:
        assert bound >= radial_bound(instance) * (1 - 1e-9)
        assert orders > 1 or bound == pytest.approx(least[0])


def test_large_waves_in_aisles_are_bounded_by_their_tours() -> None:
    instance = wave(200, 4)
    assert tours_bound(instance) > 1.2 * radial_bound(instance)
    if _jit.available():
        found = qrobot.solve(instance, backend="fcfs", max_work=1)
        assert found.bound >= tours_bound(instance) * (1 - 1e-9)


@settings(deadline=None, max_examples=40)
@given(instances(min_items=1, max_items=5, whole_orders=True))
def test_some_shortest_plan_has_no_more_than_the_most_trips(instance: Instance) -> None:
    expected = least_distance(instance)
    if expected is not None:
        assert expected[1] <= most_trips(instance)


@settings(deadline=None, max_examples=40)
@given(instances(min_items=1, max_items=7, feasible=True))
def test_shortest_ways_obey_the_triangle_and_exceed_nothing(instance: Instance) -> None:
    s = shortest_ways(instance, never)
    assert s is not None
    assert (s <= instance.stop_distances + 1e-9).all()
    for k in range(len(s)):
        assert (s <= s[:, k, None] + s[None, k, :] + 1e-9).all()
    away = (s[0] + s[:, 0]).max()
    assert radial_bound(instance) >= away * (1 - 1e-9)


@pytest.mark.parametrize("laid", [as_it_is, on_a_floor, as_a_table])
@pytest.mark.parametrize(("orders", "lines"), [(40, 1), (40, 4), (300, 1), (150, 3), (900, 1)])
def test_large_waves_are_bounded_by_their_ways_out_and_back(
    orders: int, lines: int, laid: Callable[[Instance], Instance]
) -> None:
    instance = laid(wave(orders, lines))
    bound = quick_bound(instance)
    assert bound >= radial_of_the_literature(instance) * (1 - 1e-12)
    routes = instance.first_routes()
    assert routes is not None
    assert bound <= instance.length(routes)


PLANNERS = ["auto", "batching", "savings", "seed", "fcfs", "pyvrp"]
ELSEWHERE = itertools.product(PLANNERS, ["floor", "table"])


@pytest.mark.parametrize(
    ("backend", "laid"),
    # Sequences of so many stops are too many variables for a sampler: it batches in aisles.
    [(backend, "aisles") for backend in [*PLANNERS, "neal"]]
    + [pytest.param(*case, marks=pytest.mark.slow) for case in ELSEWHERE],
)
def test_every_backend_tells_at_least_the_ways_out_and_back(backend: str, laid: str) -> None:
    """Whatever searches, and however little: the ways out and back are in its result."""
    if backend == "pyvrp":
        pytest.importorskip("pyvrp")
    instance = wave(60, 1 if backend == "pyvrp" else 2)
    if laid != "aisles":
        instance = on_a_floor(instance) if laid == "floor" else as_a_table(instance)
    found = qrobot.solve(instance, backend=backend, max_work=1)
    assert radial_of_the_literature(instance) * (1 - 1e-9) <= found.bound <= found.cost


def test_unlike_robots_are_filled_the_largest_first() -> None:
    """Radius 10 for each of four items of 2; robots hold 4, 2 and 2: three trips, not two."""
    instance = wave(4, 1)
    items = tuple(replace(i, weight=Fraction(2), place=Slot(9, 0)) for i in instance.items)
    robots = tuple(Robot(f"R{k}", Fraction(c)) for k, c in enumerate((4, 2, 2)))
    instance = replace(instance, items=items, robots=robots)
    assert radial_bound(instance) == 3 * 2 * instance.distances[0, 1]
    assert radial_of_the_literature(instance) == 2 * 2 * instance.distances[0, 1]


def test_loaded_walks_take_more_than_250_stops() -> None:
    """A few items a trip: the walks say more than the ways out and back do."""
    instance = paper_shaped(260, 40, 1)
    assert walk_bound(instance, math.inf, never, 60) > 1.02 * quick_bound(instance)


def pairs_on_a_trip(stops: int, rounding: Literal["none", "nearest"], light: int = 0) -> Instance:
    """Two stops of 4 on a robot of 10: a fifth of each trip is empty, which walks see."""
    rng = np.random.default_rng(stops)
    items = tuple(
        Item(
            f"i{k}",
            Fraction(0 if k < light else 4 - (k == light)),
            Point(*rng.integers(500, 1500, 2).tolist()),
        )
        for k in range(stops)
    )
    orders = tuple(Order(item.id, (item.id,)) for item in items)
    robots = tuple(Robot(f"R{k}", Fraction(10)) for k in range(stops))
    return Instance(OpenFloor(0, 0, rounding=rounding), items, orders, robots)


def test_loads_of_large_waves_keep_their_steps() -> None:
    """1,500 stops: rounding up to steps of 2 would leave five of a load of 10, and no bound."""
    instance = pairs_on_a_trip(1_500, "none")
    bound = walk_bound(instance, math.inf, never, 1)
    routes = instance.first_routes()
    assert routes is not None
    assert quick_bound(instance) < bound <= instance.length(routes)


@pytest.mark.parametrize("laid", [as_it_is, as_a_table])
def test_loaded_walks_go_round_few_light_stops_at_any_size(
    laid: Callable[[Instance], Instance],
) -> None:
    """Shortest ways over the stops that are left out, not over all 900."""
    instance = laid(pairs_on_a_trip(900, "nearest", light=20))
    routes = instance.first_routes()
    assert routes is not None
    bound = walk_bound(instance, math.inf, never, 1)
    assert quick_bound(instance) < bound <= instance.length(routes)


@settings(deadline=None, max_examples=40)
@given(instances(min_items=2, max_items=7, feasible=True), st.data())
def test_ways_over_some_stops_are_the_shortest_over_these(
    instance: Instance, data: st.DataObject
) -> None:
    """Against all sequences of the stops that a way may lead over."""
    d = instance.stop_distances
    over = data.draw(st.lists(st.integers(1, len(d) - 1), unique=True, max_size=3))
    s = shortest_ways(instance, never, over)
    assert s is not None
    for a, b in permutations(range(len(d)), 2):
        ways = [
            sum(d[x, y] for x, y in pairwise((a, *between, b)))
            for k in range(len(over) + 1)
            for between in permutations([v for v in over if v not in (a, b)], k)
        ]
        assert s[a, b] == pytest.approx(min(ways))


def test_loaded_walks_leave_light_stops_out_of_tables_too() -> None:
    """Stops without weight in a table that breaks the triangle inequality."""
    near = paper_shaped(12, 4, 3)
    d = near.distances.copy()
    d[3, 7] += 40.0
    light = tuple(replace(i, weight=Fraction(0)) if k < 3 else i for k, i in enumerate(near.items))
    items = tuple(replace(i, place=Node(k + 1)) for k, i in enumerate(light))
    instance = replace(near, warehouse=DistanceTable(tuple(map(tuple, d.tolist()))), items=items)
    expected = qrobot.solve(instance)
    assert expected.is_optimal
    assert quick_bound(instance) < walk_bound(instance, expected.cost, never) <= expected.cost


@pytest.mark.parametrize("backend", ["auto", slow("batching"), slow("pyvrp")])
def test_the_bound_of_a_search_does_not_depend_on_the_time_that_is_left(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even when the search ate everything: as if the machine were busy."""
    if backend == "pyvrp":
        pytest.importorskip("pyvrp")
    instance = paper_shaped(40, 5, 1)
    full = max(forest_bound(instance, math.inf, never), walk_bound(instance, math.inf, never))
    monkeypatch.setattr(bounding, "EARLY_SHARE", 1.0)
    run = Run(instance, Stop(3600.0), 0)
    begin_bound(run)
    assert run.best.bound > 0.9 * full
    run.stop.request()
    before = run.best.bound
    run.best.offer(instance.first_routes() or [])
    bounding.bound_from_below(run)
    assert run.best.bound == before


def test_time_is_kept_back_for_the_bound_and_for_the_check() -> None:
    instance = wave(250, 1)
    run = Run(instance, Stop(3600.0), 0)
    search = time_to_search(run)
    assert run.check_seconds > 0
    assert run.stop.remaining - search.remaining >= run.check_seconds
    assert time_to_search(Run(instance, Stop(), 0)).remaining == math.inf


def test_time_is_kept_back_for_the_check_on_a_large_map() -> None:
    pytest.importorskip("scipy")
    for side, kept in ((20, False), (300, True)):
        house = FloorMap((".." * side,) * side, 1.0, Point(0.5, 0.5))
        items = (Item("far", Fraction(1), Point(side - 0.5, side - 0.5)),)
        robots = (Robot("R1", Fraction(1)),)
        instance = Instance(house, items, (Order("o", ("far",)),), robots)
        run = Run(instance, Stop(60), 1)
        search = time_to_search(run)
        assert (run.check_seconds > 0) is kept
        assert run.stop.remaining - search.remaining >= run.check_seconds
