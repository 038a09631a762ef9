"""One large number among the distances: the plan does not depend on what the number is."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from slow import slow

import qrobot
from qrobot.models import Penalties
from qrobot.problem import DistanceTable, Instance, Item, Node, Order, Point, Robot

MARKERS = (1_000.0, 999_999_999.0, 1e9, 2.0**31 - 1, 1e15, 1e300, math.inf)


def marked(marker: float, items: int, seed: int, share: float, *, whole: bool = True) -> Instance:
    """Distances of 1 to 99, some of them replaced by a marker."""
    rng = np.random.default_rng(seed)
    d = rng.integers(1, 100, (items + 1, items + 1)).astype(float)
    if not whole:
        d += rng.random(d.shape)
    d[rng.random(d.shape) < share] = marker
    things = tuple(Item(f"i{k}", Fraction(1), Node(k)) for k in range(1, items + 1))
    return Instance(
        DistanceTable(tuple(map(tuple, d.tolist()))),
        things,
        tuple(Order(i.id, (i.id,)) for i in things),
        tuple(Robot(f"R{k}", Fraction(-(-items // 3))) for k in range(4)),
    )


@pytest.mark.parametrize("whole", [True, slow(False)])
@pytest.mark.parametrize("backend", ["pyvrp", "pyvrp-plain", "batching", "auto"])
def test_the_plan_is_the_same_whatever_the_marker(backend: str, whole: bool) -> None:
    if backend.startswith("pyvrp"):
        pytest.importorskip("pyvrp")
    plans = []
    for marker in MARKERS:
        instance = marked(marker, 14, 3, 0.15, whole=whole)
        result = qrobot.solve(instance, backend=backend, max_work=60)
        assert result.cost < 1_000
        plans.append((result.cost, result.bound, [t.stops for t in result.plan.trips]))
    assert all(plan == plans[0] for plan in plans)


@pytest.mark.parametrize("marker", MARKERS)
def test_samplers_get_plans_without_marked_ways(marker: float) -> None:
    result = qrobot.solve(marked(marker, 8, 3, 0.15), backend="neal", max_work=50)
    assert result.cost < 1_000


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 6), st.integers(0, 500), st.sampled_from([0.1, 0.4]), st.booleans())
def test_marked_ways_change_no_optimum(n: int, seed: int, share: float, whole: bool) -> None:
    """The distances that solvers see keep the least distance, unless every plan needs one."""
    instance = marked(1e9, n, seed, share, whole=whole)
    seen = least_distance(instance)
    raw = marked(1e5, n, seed, share, whole=whole)  # small enough to be taken as it is
    expected = least_distance(replace(raw, name="raw"))
    assert seen is not None
    assert expected is not None
    if expected[0] < 1e5:
        assert seen[0] == pytest.approx(expected[0])
        assert qrobot.solve(instance, max_work=50).cost == pytest.approx(expected[0])


def test_a_long_way_that_every_plan_needs_keeps_its_length() -> None:
    matrix = ((0.0, 5.0, 9e8), (5.0, 0.0, 8e8), (9e8, 8e8, 0.0))
    things = tuple(Item(f"i{k}", Fraction(1), Node(k)) for k in (1, 2))
    orders = tuple(Order(i.id, (i.id,)) for i in things)
    instance = Instance(DistanceTable(matrix), things, orders, (Robot("R1", Fraction(2)),))
    assert qrobot.solve(instance).cost == 9e8 + 8e8 + 5


def test_the_note_names_the_marked_way() -> None:
    notes = qrobot.solve(marked(999_999_999.0, 8, 1, 0.1), max_work=20).notes
    assert any("longer than a whole plan" in note and "write null" in note for note in notes)
    plain = qrobot.solve(marked(99.0, 8, 1, 0.1), max_work=20).notes
    assert not any("whole plan" in note for note in plain)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["pyvrp", "batching"])
def test_a_place_far_off_does_not_spoil_the_rest_and_is_named(backend: str) -> None:
    """With room for one item a trip, the rest is planned as if the far item were not there."""
    if backend == "pyvrp":
        pytest.importorskip("pyvrp")
    near = paper_shaped(24, 6, 2)
    robots = (*near.robots, Robot("far", Fraction(1000)))
    least = qrobot.solve(near, backend=backend, max_work=500).cost
    assert not near.notes
    for far in (1e6, 5e8):
        odd = Item("typo", Fraction(1000), Point(far, 50.0))
        items, orders = (*near.items, odd), (*near.orders, Order("typo", ("typo",)))
        instance = replace(near, items=items, orders=orders, robots=robots)
        result = qrobot.solve(instance, backend=backend, max_work=500)
        rest = sum(trip.distance for trip in result.plan.trips if "typo" not in trip.stops)
        assert rest <= 1.05 * least, far
        assert any(note.startswith("typo lies") for note in result.notes)


def test_markers_do_not_set_the_weights_of_models() -> None:
    weights = [Penalties.measured(marked(m, 6, 1, 0.1), "reduced") for m in (MARKERS[0], 1e9)]
    assert weights[0].step == weights[1].step < 1_000
