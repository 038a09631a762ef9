"""Tables: the same with and without a terminal, every stop in them."""

from __future__ import annotations

from fractions import Fraction

import qrobot
from qrobot._text import columns, shortened
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot
from qrobot.report import table


def test_every_trip_and_stop_is_listed() -> None:
    items = tuple(Item(f"item-{k}", Fraction(1, 2), Point(k % 7, k // 7)) for k in range(30))
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    robots = (Robot("left", Fraction(8)), Robot("right", Fraction(8)))
    instance = Instance(OpenFloor(), items, orders, robots)
    result = qrobot.solve(instance, backend="batching", max_work=50)
    text = table(result)
    lines = text.splitlines()
    assert lines[0].split() == [
        "trip", "robot", "load", "distance", "time", "orders", "stops", "in", "sequence",
    ]  # fmt: skip
    assert max(map(len, lines)) < 110
    words = text.split()
    listed = [word for word in words if word.startswith("item-")]
    assert listed == [stop for trip in result.plan.trips for stop in trip.stops]
    assert "/ 8" in text
    assert "\x1b" not in text


def test_columns_are_aligned() -> None:
    text = columns(["a", "number"], [["long cell", "1"], ["b", "12.5"]], numbers=frozenset({1}))
    assert text.splitlines() == [
        "a          number",
        "---------  ------",
        "long cell       1",
        "b            12.5",
    ]


def test_texts_are_shortened() -> None:
    assert shortened("abcdef", 6) == "abcdef"
    assert shortened("abcdefg", 6) == "abcde…"
