"""When robots are where, against a walk with a watch, and the picture of it."""

from __future__ import annotations

import csv
import io
import json
import random
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings
from report.test_picklist import planned, questions

import qrobot
from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Item, OpenFloor, Order, Point, Robot, Slot
from qrobot.report import draw_schedule, pick_lists, schedule
from qrobot.warehouse.under_policy import ROUTINGS

SCHEMA = json.loads((Path(qrobot.__file__).parent / "report" / "schedule.schema.json").read_text())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def on_a_line(*robots: Robot) -> tuple[qrobot.Instance, Plan]:
    """Return four items at 1, 2, 3 and 4 m, an order each, and a trip for each."""
    items = tuple(Item(f"i{k}", 1, Point(k, 0), pick_seconds=10.0 * k) for k in range(1, 5))
    orders = tuple(Order(item.id, (item.id,)) for item in items)
    instance = qrobot.Instance(OpenFloor(), items, orders, robots)
    return instance, Plan.from_routes(instance, [[1], [2], [3], [4]])


def test_times_are_those_of_a_walk_with_a_watch() -> None:
    found = schedule(*on_a_line(Robot("A", 1, 1.0, 3), Robot("B", 1, 0.5, 3))[::-1])
    # There and back and the picks: 12, 24, 36, 48 s with A, 14, 28, 42, 56 s with B. The longest
    # first, each to whom it brings back first: 48 to A, 42 to B, 24 to B (66, A: 72), 12 to A.
    times = {
        own.robot: [(trip.journey.items[0].id, trip.begins, trip.ends) for trip in own.trips]
        for own in found.robots
    }
    assert times == {
        "A": [("i4", 0, 48), ("i1", 48, 60)],
        "B": [("i3", 0, 42), ("i2", 42, 70)],
    }
    assert found.ends == 70
    assert [(own.driving, own.collecting) for own in found.robots] == [(10, 50), (20, 50)]
    stop = found.to_dict()["robots"][1]["trips"][1]["stops"][0]
    assert (stop["item"], stop["arrives"], stop["leaves"]) == ("i2", 46, 66)


@pytest.mark.parametrize("routing", [name for name in ROUTINGS if name != "exact"])
def test_times_are_those_of_the_ways_of_a_policy(routing: str) -> None:
    rng = random.Random(1)
    items = tuple(
        Item(f"i{k}", 1, Slot(rng.randrange(6), rng.randrange(10)), pick_seconds=3.0)
        for k in range(24)
    )
    orders = tuple(Order(item.id, (item.id,)) for item in items)
    house = AisleWarehouse(6, 10, depot_distance=2.0)
    instance = qrobot.Instance(house, items, orders, (Robot("A", 8, 0.5, 5),))
    result = qrobot.solve(instance, backend="fcfs", routing=routing, max_work=1)
    (own,) = schedule(result).robots
    for trip, of in zip(own.trips, result.plan.trips, strict=True):
        assert trip.visits[-1].distance == pytest.approx(of.distance)
        assert trip.driving == pytest.approx(of.seconds)
    (lists, *_) = pick_lists(result).lists
    assert lists.seconds == pytest.approx(own.trips[0].ends)


@settings(max_examples=50, deadline=None)
@given(questions())
def test_every_trip_follows_the_one_before_and_together_they_take_the_time(
    instance: qrobot.Instance,
) -> None:
    instance = replace(instance, robots=instance.robots[:2])
    instance = replace(instance, robots=tuple(replace(r, trips=20) for r in instance.robots))
    plan = planned(instance)
    free = instance.with_robots(None)
    data = json.loads(schedule(plan, free).to_json())
    VALIDATOR.validate(data)
    assert sum(own["ends"] for own in data["robots"]) == pytest.approx(plan.cost)
    assert max(own["ends"] for own in data["robots"]) == data["ends"]
    taken = []
    for own in data["robots"]:
        clock = 0.0
        for trip in own["trips"]:
            assert trip["begins"] == clock
            for stop in trip["stops"]:
                assert clock <= stop["arrives"] <= stop["leaves"]
                clock = stop["leaves"]
                taken.append(stop["item"])
            assert clock <= trip["ends"]
            clock = trip["ends"]
        assert clock == own["ends"] == pytest.approx(own["driving"] + own["collecting"])
    assert sorted(taken) == sorted(item.id for item in instance.items)


def test_the_lines_of_the_file_are_those_of_the_data() -> None:
    instance, plan = on_a_line(Robot("A", 1, 1.0, 3), Robot("=B", 1, 0.5, 3))
    found = schedule(plan, instance)
    rows = list(csv.DictReader(io.StringIO(found.to_csv())))
    stops = [
        (own["robot"], stop["item"], stop["leaves"])
        for own in found.to_dict()["robots"]
        for trip in own["trips"]
        for stop in trip["stops"]
    ]
    assert [
        (row["robot"].lstrip("'"), row["item"], float(row["leaves"])) for row in rows if row["item"]
    ] == stops
    assert [row["location"] for row in rows if not row["item"]] == ["depot"] * 4
    assert {row["robot"] for row in rows} == {"A", "'=B"}  # never a formula


def test_the_table_says_who_stays_home_and_who_is_last() -> None:
    lines = schedule(*on_a_line(Robot("A", 1, 1.0, 9), Robot("B", 1, 0.001, 9))[::-1]).to_text()
    assert "without a trip: B" in lines
    assert "all robots are back after 120 s, A last; together they work 120 s" in lines


def test_a_bar_a_trip_as_long_as_the_trip(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    instance, plan = on_a_line(Robot("A", 1, 1.0, 3), Robot("B", 1, 0.5, 3))
    found = schedule(plan, instance)
    draw_schedule(found, tmp_path / "bars.svg")
    root = ET.parse(tmp_path / "bars.svg").getroot()
    widths = {}
    for node in root.iter():
        if found_id := re.fullmatch(r"trip-(\d+)", node.get("id") or ""):
            path = next(iter(node)).get("d") or ""
            xs = [float(x) for x in re.findall(r"[ML] ([\d.]+) ", path)]
            widths[int(found_id[1])] = max(xs) - min(xs)
    long = {t.journey.number: t.ends - t.begins for own in found.robots for t in own.trips}
    assert widths.keys() == long.keys()
    scale = widths[1] / long[1]
    assert all(widths[n] == pytest.approx(scale * seconds, rel=1e-4) for n, seconds in long.items())


@pytest.mark.slow
def test_many_robots_and_odd_names_are_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    count = 400
    items = tuple(Item(f"i{k}", 1, Point(k + 1, 0)) for k in range(count))
    orders = tuple(Order(item.id, (item.id,)) for item in items)
    robots = tuple(Robot(f"R{k}" if k else "\U0001f916", 1) for k in range(count))
    instance = qrobot.Instance(OpenFloor(), items, orders, robots)
    found = schedule(Plan.from_routes(instance, [[k + 1] for k in range(count)]), instance)
    notes = draw_schedule(found, tmp_path / "bars.png")
    assert (tmp_path / "bars.png").stat().st_size
    assert any("font" in note for note in notes)
    assert not draw_schedule(found, tmp_path / "bars.svg")


def test_a_plan_that_is_wrong_has_no_schedule() -> None:
    instance, plan = on_a_line(Robot("A", 1, 1.0, 9))
    with pytest.raises(qrobot.InputError, match=r"not right .*`qrobot check` lists all"):
        schedule(replace(plan, trips=plan.trips[:-1]), instance)


def test_the_schema_describes_all_that_is_written() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    data = schedule(*on_a_line(Robot("A", 1, 1.0, 9))[::-1]).to_dict()
    parts = SCHEMA["$defs"]
    assert set(data) == set(SCHEMA["properties"])
    own = data["robots"][0]
    assert set(own) == set(parts["robot"]["properties"])
    assert set(own["trips"][0]) == set(parts["trip"]["properties"])
    assert set(own["trips"][0]["stops"][0]) == set(parts["stop"]["properties"])
    del own["trips"][0]["stops"][0]["leaves"]
    assert not VALIDATOR.is_valid(data)


def test_missed_due_times_and_deadlines_are_told() -> None:
    """Waiting for others may take a plan past a deadline that it keeps by itself."""
    house = AisleWarehouse(2, 4, aisle_pitch=3.0, end_gap=1.0)
    items = (Item("a", 1, Slot(0, 3), 10.0), Item("b", 1, Slot(0, 0), 10.0))
    orders = (Order("A", ("a",), due=10.0), Order("B", ("b",), deadline=25.0))
    instance = qrobot.Instance(house, items, orders, (Robot("R1", 1), Robot("R2", 1)))
    plan = Plan.from_routes(instance, [[1], [2]], seats=[(0, 0), (1, 0)])
    text = schedule(plan, instance).to_text()
    assert "1 of 1 orders with a due time are late: A by 8 s" in text
    assert "all 1 orders with a deadline are back in time" in text
    text = schedule(plan, instance, per_aisle=1).to_text()
    assert "1 of 1 orders with a deadline are late: B by 5 s" in text
