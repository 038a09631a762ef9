"""Trips and robots: the cheapest assignment, and the soonest done, against all of them."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot.plan.dealing import _cheapest, deal
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

PRICES = st.one_of(st.integers(0, 9).map(float), st.floats(0, 100), st.just(float("inf")))


@given(st.data())
def test_no_assignment_is_cheaper(data: st.DataObject) -> None:
    columns = data.draw(st.integers(1, 5))
    rows = data.draw(st.integers(0, columns))
    costs = np.array(
        [[data.draw(PRICES) for _ in range(columns)] for _ in range(rows)], dtype=float
    ).reshape(rows, columns)
    least = min(
        sum((costs[i, c] for i, c in enumerate(chosen)), 0.0)
        for chosen in permutations(range(columns), rows)
    )
    if np.isinf(least):
        with pytest.raises(ValueError, match="do not fit"):
            _cheapest(costs)
        return
    found = _cheapest(costs)
    assert len(set(found)) == rows
    assert sum((costs[i, c] for i, c in enumerate(found)), 0.0) == pytest.approx(least)


@st.composite
def fleets(draw: st.DrawFn, *, alike: bool = False) -> tuple[Instance, list[list[int]]]:
    """Return robots and trips of one item each, on a line."""
    sizes = st.just(9) if alike else st.integers(1, 9)
    robots = tuple(
        Robot(f"R{r}", draw(sizes), 1.0 if alike else draw(st.sampled_from([0.5, 1.0, 2.0])),
              5 if alike else draw(st.integers(1, 3)))
        for r in range(draw(st.integers(1, 3)))
    )  # fmt: skip
    items = tuple(
        Item(f"{i}", draw(st.integers(1, max(int(r.capacity) for r in robots))),
             Point(draw(st.integers(0, 20)), 0))
        for i in range(draw(st.integers(1, 5)))
    )  # fmt: skip
    orders = tuple(Order(item.id, (item.id,)) for item in items)
    instance = Instance(warehouse=OpenFloor(), items=items, orders=orders, robots=robots)
    return instance, [[1 + i] for i in draw(st.permutations(range(len(items))))]


def ends(instance: Instance, routes: list[list[int]], robots: list[int]) -> float | None:
    """Return when the last robot is back; None where they cannot make these trips."""
    back = [0.0] * len(instance.robots)
    for route, r in zip(routes, robots, strict=True):
        if sum(instance.items[v - 1].weight for v in route) > instance.robots[r].capacity:
            return None
        back[r] += instance.route_length(route) / instance.robots[r].speed
    counts = [robots.count(r) for r in range(len(back))]
    if any(n > robot.trips for n, robot in zip(counts, instance.robots, strict=True)):
        return None
    return max(back)


def soonest(instance: Instance, routes: list[list[int]]) -> float | None:
    """Return the soonest end of all ways to deal the trips."""
    every = product(range(len(instance.robots)), repeat=len(routes))
    known = [end for robots in every if (end := ends(instance, routes, list(robots))) is not None]
    return min(known, default=None)


@given(fleets())
def test_trips_are_dealt_wherever_the_robots_can_make_them(
    fleet: tuple[Instance, list[list[int]]],
) -> None:
    instance, routes = fleet
    turns = sum(robot.trips for robot in instance.robots)
    if len(routes) > turns:
        with pytest.raises(ValueError, match=f"{len(routes)} trips for"):
            deal(instance, routes)
        return
    dealt = deal(instance, routes)
    # What no robots can carry is dealt all the same: the checker says what is wrong.
    possible = soonest(instance, routes) is not None
    assert (ends(instance, routes, [r for r, _ in dealt]) is not None) == possible
    for r in {r for r, _ in dealt}:
        turns = sorted(turn for robot, turn in dealt if robot == r)
        assert turns == list(range(len(turns)))


@given(fleets(alike=True))
def test_the_last_of_like_robots_is_back_soon(fleet: tuple[Instance, list[list[int]]]) -> None:
    """At most 4/3 - 1/3K of the soonest end (Graham 1969)."""
    instance, routes = fleet
    count = len(instance.robots)
    best = soonest(instance, routes)
    assert best is not None
    end = ends(instance, routes, [r for r, _ in deal(instance, routes)])
    assert end is not None
    assert end <= best * (4 / 3 - 1 / (3 * count)) + 1e-9


@given(fleets())
def test_the_sequence_of_the_trips_does_not_matter(
    fleet: tuple[Instance, list[list[int]]],
) -> None:
    instance, routes = fleet
    if len(routes) > sum(robot.trips for robot in instance.robots):
        return
    one = dict(zip(map(tuple, routes), deal(instance, routes), strict=True))
    again = routes[::-1]
    assert dict(zip(map(tuple, again), deal(instance, again), strict=True)) == one
