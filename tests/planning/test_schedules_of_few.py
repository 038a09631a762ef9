"""Every objective against all plans: every split, every sequence, every robot, written out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.backends.classical.exact import ExactPlanner
from qrobot.problem import AisleWarehouse, DistanceTable, Instance, Item, Node, Order, Robot, Slot
from qrobot.problem import Times as Seconds

OBJECTIVES = (
    "distance", "time", "makespan", "lateness", "trips", "robots",
    "distance=1,makespan=2", "lateness=3,time=0.5", "robots=40,makespan=1,trips=5",
)  # fmt: skip
CLOCK = st.integers(0, 120).map(float)


@st.composite
def jobs(draw: st.DrawFn, *, most: int = 4) -> Instance:
    """Return unlike robots and orders of one or two items with times, in aisles or a table."""
    orders = draw(st.integers(1, most))
    sizes = [draw(st.integers(1, 2)) for _ in range(orders)]
    if draw(st.booleans()):
        warehouse = AisleWarehouse(aisles=3, slots=4, blocks=draw(st.integers(1, 2)))
        places = st.builds(
            Slot, st.integers(0, 2), st.integers(0, 3), st.integers(0, warehouse.blocks - 1)
        )
    else:
        rows = st.lists(st.integers(1, 40).map(float), min_size=5, max_size=5)
        warehouse = DistanceTable(tuple(tuple(draw(rows)) for _ in range(5)))
        places = st.integers(1, 4).map(Node)
    items, found = [], []
    for o, size in enumerate(sizes):
        names = tuple(f"i{o}-{k}" for k in range(size))
        items += [
            Item(
                name,
                draw(st.integers(1, 4)),
                draw(places),
                pick_seconds=draw(st.sampled_from([0.0, 2.5])),
                quantity=draw(st.integers(1, 3)),
                level=draw(st.integers(0, 2)),
            )
            for name in names
        ]
        release = draw(st.sampled_from([0.0, 0.0, 10.0, 55.0]))
        due = draw(st.one_of(st.just(math.inf), CLOCK))
        deadline = draw(st.one_of(st.just(math.inf), st.integers(60, 400).map(float)))
        priority = draw(st.sampled_from([1.0, 0.0, 2.5]))
        found.append(Order(f"o{o}", names, release, max(due, release), deadline, priority))
    robots = tuple(
        Robot(
            f"R{r}",
            draw(st.sampled_from([4, 8, 12])),
            draw(st.sampled_from([0.5, 1.0, 2.0])),
            draw(st.integers(1, 3)),
            draw(st.sampled_from([0.0, 0.0, 25.0])),
        )
        for r in range(draw(st.integers(1, 3)))
    )
    times = Seconds(
        per_trip=draw(st.sampled_from([0.0, 12.0])),
        per_pick=draw(st.sampled_from([0.0, 1.5])),
        per_piece=draw(st.sampled_from([0.0, 0.5])),
        per_level=draw(st.sampled_from([0.0, 2.0])),
    )
    return Instance(warehouse, tuple(items), tuple(found), robots, times=times)


def splits(elements: Sequence[int], robots: int) -> Iterator[list[list[tuple[int, ...]]]]:
    """Yield for each robot its trips in sequence: every way to hand out the elements."""
    if not elements:
        yield [[] for _ in range(robots)]
        return
    first, *rest = elements
    for plan in splits(rest, robots):
        for r in range(robots):
            trips = plan[r]
            for t in range(len(trips)):
                yield [*plan[:r], [*trips[:t], (first, *trips[t]), *trips[t + 1 :]], *plan[r + 1 :]]
            for t in range(len(trips) + 1):
                yield [*plan[:r], [*trips[:t], (first,), *trips[t:]], *plan[r + 1 :]]


def shortest(instance: Instance, orders: tuple[int, ...]) -> float:
    nodes = [v for o in orders for v in instance.order_nodes[o]]
    return min(instance.route_length(list(route)) for route in permutations(nodes))


def value(
    objective: str, instance: Instance, plan: list[list[tuple[int, ...]]], long: dict
) -> float:
    """Return what a plan costs, ``inf`` for one that is not allowed; told in plain sums."""
    metres = seconds = late = last = 0.0
    item = {one.id: one for one in instance.items}
    for robot, trips in zip(instance.robots, plan, strict=True):
        if len(trips) > robot.trips:
            return math.inf
        clock = robot.available if trips else 0.0
        for trip in trips:
            orders = [instance.orders[o] for o in trip]
            picked = [item[name] for order in orders for name in order.items]
            if sum(one.weight for one in picked) > robot.capacity:
                return math.inf
            key = tuple(sorted(trip))
            if key not in long:
                long[key] = shortest(instance, key)
            t = instance.times
            work = t.per_trip + long[key] / robot.speed
            for one in picked:
                work += one.pick_seconds + t.per_pick
                work += t.per_piece * one.quantity + t.per_level * one.level
            clock = max([clock, *(order.release for order in orders)]) + work
            metres += long[key]
            seconds += work
            for order in orders:
                if clock > order.deadline + 1e-7:
                    return math.inf
                late += order.priority * max(0.0, clock - order.due)
        last = max(last, clock)
    told = {
        "distance": metres,
        "time": seconds,
        "makespan": last,
        "lateness": late,
        "trips": sum(map(len, plan)),
        "robots": sum(map(bool, plan)),
    }
    parts = [part.partition("=") for part in objective.split(",")]
    return sum(float(weight or 1) * told[name] for name, _, weight in parts)


@settings(deadline=None, max_examples=60)
@given(instance=jobs(), objective=st.sampled_from(OBJECTIVES))
def test_proven_plans_cost_the_least_of_all(instance: Instance, objective: str) -> None:
    long: dict[tuple[int, ...], float] = {}
    plans = splits(range(len(instance.orders)), len(instance.robots))
    least = min(value(objective, instance, plan, long) for plan in plans)
    if math.isinf(least):
        with pytest.raises(qrobot.InfeasibleError):
            qrobot.solve(instance, objective=objective, deadline=20)
        return
    result = qrobot.solve(instance, objective=objective, deadline=20)
    assert result.is_optimal
    assert result.cost == pytest.approx(least, rel=1e-7, abs=1e-7)
    assert result.bound <= least * (1 + 1e-7)
    assert qrobot.check(result.plan, instance).ok


@pytest.mark.parametrize(
    "objective",
    [*(pytest.param(o, marks=pytest.mark.slow) for o in OBJECTIVES[:-1]), OBJECTIVES[-1]],
)
def test_eight_orders_and_three_unlike_robots(objective: str) -> None:
    """All 4,140 splits, each with all hands: what depends on the sequence is left to the small."""
    places = [(0, 3), (2, 0), (1, 1), (2, 3), (0, 0), (1, 3), (2, 2), (0, 1)]
    items = tuple(Item(f"i{k}", 1 + k % 3, Slot(*at), 4.0) for k, at in enumerate(places))
    robots = (Robot("A", 4, 1.0, 2), Robot("B", 6, 0.5, 2), Robot("C", 5, 2.0, 1))
    orders = tuple(Order(f"o{k}", (f"i{k}",), due=30.0) for k in range(8))
    instance = Instance(AisleWarehouse(3, 4), items, orders, robots, times=Seconds(per_trip=7.0))
    result = qrobot.solve(instance, objective=objective, deadline=30)
    assert result.is_optimal
    long: dict[tuple[int, ...], float] = {}
    least = math.inf
    for hands in _hands(range(8), [2, 2, 1]):
        # Which trip of a robot comes first changes no distance, time, makespan or count.
        plans = [hands]
        if "lateness" in objective:
            plans = [
                [list(a), list(b), list(c)]
                for a in permutations(hands[0])
                for b in permutations(hands[1])
                for c in permutations(hands[2])
            ]
        least = min(least, *(value(objective, instance, plan, long) for plan in plans))
    assert result.cost == pytest.approx(least)


def _hands(elements: Sequence[int], most: Sequence[int]) -> Iterator[list[list[tuple[int, ...]]]]:
    """Yield every way to hand out elements, without the sequence of the trips of a robot."""
    if not elements:
        yield [[] for _ in most]
        return
    *rest, last = elements
    for plan in _hands(rest, most):
        for r, limit in enumerate(most):
            for t, trip in enumerate(plan[r]):
                yield [*plan[:r], [*plan[r][:t], (*trip, last), *plan[r][t + 1 :]], *plan[r + 1 :]]
            if len(plan[r]) < limit:
                yield [*plan[:r], [*plan[r], (last,)], *plan[r + 1 :]]


def test_deadlines_that_nobody_keeps_are_told() -> None:
    instance = Instance(
        AisleWarehouse(3, 4),
        (Item("a", 1, Slot(2, 3)),),
        (Order("o", ("a",), deadline=3.0),),
        (Robot("R", 5),),
    )
    with pytest.raises(qrobot.InfeasibleError, match="deadline"):
        qrobot.solve(instance)
    late = replace(instance, orders=(replace(instance.orders[0], deadline=math.inf, due=3.0),))
    result = qrobot.solve(late, objective="lateness")
    assert result.cost == pytest.approx(result.plan.distance - 3.0)


@settings(deadline=None, max_examples=40)
@given(instance=jobs(), objective=st.sampled_from(OBJECTIVES))
def test_the_search_finds_plans_and_bounds_that_hold(instance: Instance, objective: str) -> None:
    """Without the proof: no plan below the least of all, no bound above it, hardly ever worse."""
    long: dict[tuple[int, ...], float] = {}
    plans = splits(range(len(instance.orders)), len(instance.robots))
    least = min(value(objective, instance, plan, long) for plan in plans)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(ExactPlanner, "schedules", lambda _self, _instance: False)
        result = None
        proven = False
        try:
            result = qrobot.solve(instance, objective=objective, max_work=40)
        except qrobot.InfeasibleError as error:
            proven = error.proven
    if result is None:
        assert math.isinf(least) or not proven
        return
    assert least * (1 - 1e-7) - 1e-7 <= result.cost
    assert result.bound <= least * (1 + 1e-7) + 1e-7
    if not instance.has_deadlines:
        assert result.cost <= least * 1.1 + 1e-7
    assert qrobot.check(result.plan, instance).ok
