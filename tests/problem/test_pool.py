"""Pools: read whole whatever their size, with no distances of all places together."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from pathlib import Path

import pytest

import qrobot
from qrobot.problem import MAX_STOPS, Instance, Item, OpenFloor, Order, Point, Robot, validity
from qrobot.problem.formats import write

STOPS = MAX_STOPS + 500


def large(pool: bool = True) -> Instance:
    """Return more orders of one item, each in a place of its own, than one plan may have."""
    places = [Point(float(k % 50), float(k // 50)) for k in range(STOPS)]
    items = tuple(Item(f"i{k}", Fraction(1), place) for k, place in enumerate(places))
    orders = tuple(Order(item.id, (item.id,)) for item in items)
    return Instance(OpenFloor(), items, orders, (Robot("R1", 10, trips=STOPS),), pool=pool)


def test_a_pool_is_written_and_read_and_has_no_distances(tmp_path: Path) -> None:
    file = tmp_path / "pool.json"
    write(large(), file)
    with pytest.raises(qrobot.InputError, match=f"{STOPS} stops .* are more than the {MAX_STOPS}"):
        qrobot.read(file)
    pool = qrobot.read(file, pool=True)
    assert pool == dataclasses.replace(large(), name=pool.name)
    with pytest.raises(qrobot.InputError, match="plan them in waves"):
        _ = pool.distances
    with pytest.raises(qrobot.InputError, match="plan them in waves"):
        qrobot.solve(pool, max_work=1)


def test_a_pool_of_csv_orders(tmp_path: Path) -> None:
    lines = [f"o{k // 4};i{k};1,5;{k % 50};{k // 50}" for k in range(STOPS)]
    (tmp_path / "orders.csv").write_text("\n".join(["order;item;weight;x;y", *lines]))
    (tmp_path / "layout.json").write_text(
        '{"schema": "qrobot.instance/1", "robots": {"count": 2, "capacity": 40},'
        ' "warehouse": {"kind": "floor", "depot": {"x": 0, "y": 0}}}'
    )
    pool = qrobot.read(tmp_path / "orders.csv", pool=True, robots=3, capacity=60)
    assert (len(pool.orders), pool.size, len(pool.robots)) == (STOPS // 4, STOPS, 3)
    assert pool.split_orders().pool
    with pytest.raises(qrobot.InputError, match="plan them in waves"):
        qrobot.read(tmp_path / "orders.csv")


def test_a_pool_has_a_limit_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(validity, "MAX_POOL", STOPS - 1)
    with pytest.raises(qrobot.InputError, match=f"{STOPS} items are more than the {STOPS - 1}"):
        large()
    with pytest.raises(qrobot.InputError, match="stops"):
        large(pool=False)
