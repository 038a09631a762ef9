"""Tables in which some ways do not exist: whoever plans, bounds or judges copes with them."""

from __future__ import annotations

import itertools
import json
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import assignments

import qrobot
from qrobot.errors import InfeasibleError, InputError
from qrobot.models import Penalties, build_model
from qrobot.planning.bounds import forest_bound, quick_bound, walk_bound
from qrobot.problem import DistanceTable, Instance, Item, Node, Order, Robot

INF = math.inf
LOCAL = ("auto", "exact", "batching", "pyvrp", "neal", "tabu", "descent", "qaoa-swap")
PLANNERS = ("auto", "exact", "batching", "pyvrp")


def table(
    rows: list[list[float]], weights: list[int], capacity: int, robots: int, trips: int = 1
) -> Instance:
    items = tuple(Item(f"i{k + 1}", w, Node(k + 1)) for k, w in enumerate(weights))
    return Instance(
        warehouse=DistanceTable(tuple(map(tuple, rows))),
        items=items,
        orders=tuple(Order(item.id, (item.id,)) for item in items),
        robots=tuple(Robot(f"R{k + 1}", capacity, trips=trips) for k in range(robots)),
    )


def least(one: Instance) -> float:
    """Try every sequence and every cut of it, with nothing of the package but the table."""
    assert isinstance(one.warehouse, DistanceTable)
    d, n = one.warehouse.matrix, len(one.items)
    seats = sum(min(robot.trips, n) for robot in one.robots)
    best = INF
    for tour in itertools.permutations(range(1, n + 1)):
        for cuts in itertools.product((False, True), repeat=n - 1):
            trips: list[list[int]] = [[]]
            for node, cut in zip(tour, (*cuts, False), strict=True):
                trips[-1].append(node)
                if cut:
                    trips.append([])
            loads = [sum((one.items[v - 1].weight for v in t), Fraction(0)) for t in trips]
            if len(trips) <= seats and max(loads) <= one.robots[0].capacity:
                length = sum(d[a][b] for t in trips for a, b in itertools.pairwise([0, *t, 0]))
                best = min(best, length)
    return best


@st.composite
def sparse(draw: st.DrawFn, *, most: int = 4, solvable: bool = False) -> Instance:
    """Draw tables in which most ways are missing; where wanted, with those of at least one plan."""
    n = draw(st.integers(1, most))
    way = st.sampled_from([INF, INF, 1.0, 2.0, 3.5, 7.0, 20.0])
    rows = [[draw(way) for _ in range(n + 1)] for _ in range(n + 1)]
    weights = [draw(st.integers(0, 4)) for _ in range(n)]
    capacity, robots = draw(st.integers(4, 9)), draw(st.integers(1, 2))
    if solvable:
        nodes = draw(st.permutations(range(1, n + 1)))
        trips = [nodes] if draw(st.booleans()) else [[node] for node in nodes]
        capacity = max(capacity, *(sum(weights[v - 1] for v in trip) for trip in trips))
        robots = max(robots, len(trips))
        for a, b in (way for t in trips for way in itertools.pairwise([0, *t, 0])):
            rows[a][b] = draw(st.sampled_from([1.0, 2.0, 20.0]))
    return table(rows, weights, capacity, robots)


@settings(max_examples=150, deadline=None)
@given(sparse())
def test_every_answer_is_the_one_of_all_sequences(one: Instance) -> None:
    best = least(one)
    if best == INF:
        with pytest.raises(
            (InputError, InfeasibleError), match=r"no way leads|does not exist|load|share a trip"
        ):
            qrobot.solve(one, backend="exact", max_work=100)
        return
    for backend in ("auto", "exact"):
        result = qrobot.solve(one, backend=backend, max_work=100)
        assert (result.cost, result.is_optimal) == (pytest.approx(best), True)
    for bound in (
        quick_bound(one),
        forest_bound(one, best, lambda: False, 20),
        walk_bound(one, best, lambda: False, 20),
    ):
        assert bound <= best * (1 + 1e-9)


@settings(max_examples=25, deadline=None)
@given(sparse(solvable=True), st.sampled_from(LOCAL))
def test_no_backend_takes_a_way_that_does_not_exist(one: Instance, backend: str) -> None:
    best = least(one)
    assert best < INF
    try:
        result = qrobot.solve(one, backend=backend, max_work=200)
    except InfeasibleError:
        assert backend not in ("auto", "exact")  # a search may find none of a few plans
        return
    assert result.bound * (1 - 1e-9) <= best <= result.cost * (1 + 1e-9)
    json.loads(json.dumps(result.to_dict(), allow_nan=False))


@settings(max_examples=15, deadline=None)
@given(sparse(most=2, solvable=True))
def test_under_safe_penalties_the_lowest_energy_is_the_best_plan(one: Instance) -> None:
    best = least(one)
    assert best < INF
    for encoding in ("compact", "reduced"):
        model = build_model(one, encoding=encoding, penalties=Penalties.safe(one))
        n = model.num_variables
        if n > 16:
            continue
        bits = assignments(n)
        energies = model.bqm.energies((bits, list(model.variables)))
        lowest = dict(zip(model.variables, bits[int(np.argmin(energies))].tolist(), strict=True))
        assert float(energies.min()) == pytest.approx(best)
        assert model.decode(lowest).distance == pytest.approx(best)


ONE_WAY = [[0, 1, INF], [INF, 0, 1], [1, INF, 0]]


def test_a_one_way_circuit_is_one_trip(tmp_path: Path) -> None:
    one = table(ONE_WAY, [1, 1], 2, 2)
    assert one.notes == ("no way leads directly from depot to i2, and 2 more are missing",)
    qrobot.write(one, tmp_path / "one.json")
    assert "Infinity" not in (tmp_path / "one.json").read_text()
    again = qrobot.read(tmp_path / "one.json")
    assert again == one
    assert qrobot.solve(again).cost == 3
    lonely = table(ONE_WAY, [1, 1], 1, 2)
    with pytest.raises(InfeasibleError, match="does without a way that does not exist"):
        qrobot.solve(lonely)


def test_the_checker_names_the_way() -> None:
    one = table(ONE_WAY, [1, 1], 2, 2)
    report = qrobot.check(qrobot.Plan.from_routes(one, [[2, 1]]), one)
    assert [str(p) for p in report.problems] == [
        "trip 1: no way leads directly from depot to i2, from i2 to i1, from i1 to depot",
    ]
    assert report.to_dict()["distance"] is None
    model = build_model(one.with_robots(1))
    text = [v.text for v in model.decode(model.encode([[2, 1]])).violations]
    assert "no way leads directly from depot to i2" in text


def test_random_larger_tables_agree_with_a_large_number_in_the_place_of_missing_ways() -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        n = 9
        rows = rng.integers(1, 60, (n + 1, n + 1)).astype(float)
        rows[rng.random((n + 1, n + 1)) < 0.4] = INF
        weights = rng.integers(1, 5, n).tolist()
        marked = np.where(np.isinf(rows), 1e5, rows)
        expected = qrobot.solve(table(marked.tolist(), weights, 12, 3), backend="exact").cost
        one = table(rows.tolist(), weights, 12, 3)
        assert expected < 1e5
        for backend in PLANNERS:
            found = qrobot.solve(one, backend=backend, max_work=300)
            assert found.cost >= expected - 1e-9
            if backend in ("auto", "exact"):
                assert found.cost == pytest.approx(expected)


@pytest.mark.parametrize("value", [-1.0, INF, math.nan, 1e300])
def test_the_diagonal_is_not_used_whatever_it_holds(value: float) -> None:
    rows = [[value if i == j else float(1 + i + j) for j in range(4)] for i in range(4)]
    one = table(rows, [1, 1, 1], 3, 1)
    result = qrobot.solve(one)
    assert result.cost == least(table(rows, [1, 1, 1], 3, 1))
    at_the_depot = Instance(
        warehouse=one.warehouse,
        items=(Item("a", 1, Node(0)), Item("b", 1, Node(1)), Item("c", 1, Node(1))),
        orders=(Order("o", ("a", "b", "c")),),
        robots=(Robot("R1", 5),),
    )
    assert qrobot.solve(at_the_depot).cost == 4
