"""Whoever makes a question of another keeps what orders and robots say of time."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import pytest

import qrobot
from qrobot.plan import Plan, as_picked
from qrobot.planning import state_at
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot, Stock, Times
from qrobot.warehouse import under_policy

USUAL = {Order: Order("o", ("i",)), Robot: Robot("r", 1)}


def unusual() -> Instance:
    """Return a question in which no field of an order or a robot has its default."""
    items = tuple(Item(f"i{k}", 1, Slot(k, 2), article="nut", level=2) for k in range(2))
    orders = tuple(Order(f"o{k}", (f"i{k}",), 5.0, 700.0, 900.0, 2.5) for k in range(2))
    robots = tuple(Robot(f"R{k}", 2, 0.5, 4, 3.0) for k in range(2))
    stock = tuple(Stock("nut", Slot(k, 2), 1) for k in range(2))
    instance = Instance(
        AisleWarehouse(3, 4), items, orders, robots, stock=stock, times=Times(1.0, 2.0, 3.0, 4.0)
    )
    for one in (*orders, *robots):
        for field in dataclasses.fields(one):
            assert getattr(one, field.name) != getattr(USUAL[type(one)], field.name), field.name
    return instance


def through_a_file(instance: Instance, folder: Path) -> Instance:
    qrobot.write(instance, folder / "one.json")
    return qrobot.read(folder / "one.json")


WAYS: dict[str, Callable[[Instance, Path], Instance]] = {
    "solved": lambda instance, _: qrobot.solve(instance, deadline=20).instance,
    "picked": lambda instance, _: as_picked(instance, qrobot.solve(instance).plan.picks),
    "split": lambda instance, _: instance.split_orders(),
    "policy": lambda instance, _: under_policy(instance, "s-shape"),
    "file": through_a_file,
    "more robots": lambda instance, _: instance.with_robots(3),
    "state": lambda instance, _: state_at(qrobot.solve(instance).plan, instance, 1.0).instance,
}


@pytest.mark.parametrize("way", WAYS)
def test_nothing_that_is_said_of_time_is_lost(way: str, tmp_path: Path) -> None:
    instance = unusual()
    made = WAYS[way](instance, tmp_path)
    assert made.times == instance.times
    for before, after in ((instance.orders, made.orders), (instance.robots, made.robots)):
        for one, other in zip(before, after, strict=False):
            names = {field.name for field in dataclasses.fields(one)} - {"id", "items"}
            assert {n: getattr(one, n) for n in names} == {n: getattr(other, n) for n in names}


def test_no_limit_of_robots_is_one_trip_of_each() -> None:
    free = unusual().with_robots(None)
    assert [robot.trips for robot in free.robots] == [1, 1]
    assert all(robot.available == 3.0 and robot.speed == 0.5 for robot in free.robots)
    Plan.from_routes(free, [[1], [2]])
