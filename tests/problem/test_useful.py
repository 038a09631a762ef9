"""How long a way may be in a useful plan, and what that costs to find out."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from oracles import least_distance
from strategies import instances

from qrobot.problem import DistanceTable, Instance, Item, Node, Order, Robot, useful


def test_places_of_many_stops_ask_for_no_packing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stops that lie in one place are entered for nothing; the tree over all places is long."""
    points = np.array([(7.0 * (k % 5), 3.0 * (k // 5)) for k in range(25)] * 2)
    d = np.abs(points[:, None] - points[None]).sum(axis=2)
    instance = Instance(
        warehouse=DistanceTable(tuple(map(tuple, d.tolist()))),
        items=tuple(Item(f"i{k}", Fraction(1), Node(k)) for k in range(1, 50)),
        orders=tuple(Order(f"o{k}", (f"i{k}",)) for k in range(1, 50)),
        robots=tuple(Robot(f"R{k}", Fraction(5)) for k in range(10)),
    )
    monkeypatch.setattr(useful, "insert_orders", lambda *_, **__: pytest.fail("orders were packed"))
    assert math.isinf(instance.longest_useful)
    assert (instance.stop_distances == d).all()


@given(instances(max_items=6, whole_orders=True))
def test_no_plan_is_shorter_than_the_tree(instance: Instance) -> None:
    least = least_distance(instance)
    if least is not None and instance.stops:
        assert useful._spanning(instance.stop_distances) <= least[0] * (1 + 1e-9) + 1e-9


def test_a_fault_in_a_large_table_is_found_wherever_it_is() -> None:
    """Blocks of rows are looked at one after the other; names are those of the worst triangle."""
    rng = np.random.default_rng(3)
    points = rng.integers(0, 50, (600, 2))
    d = np.abs(points[:, None] - points[None]).sum(axis=2).astype(float)
    for i, j in ((0, 599), (300, 7), (599, 598)):
        wrong = d.copy()
        wrong[i, j] += 400.0
        told = DistanceTable(tuple(map(tuple, wrong.tolist()))).notes(
            wrong, (), [f"p{k}" for k in range(600)]
        )
        assert any(f"p{i} to p{j} is {wrong[i, j]:g}, but" in note for note in told), told
