"""The animated page: its times and places against the plan."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from report.animated import XY, Page, at, page_of, timed
from scenes import CASES, LAYOUT, shared

import qrobot
from qrobot.plan import OBJECTIVES, Plan
from qrobot.problem import AisleWarehouse
from qrobot.problem.checks import canonical
from qrobot.report import check_picture_path


def off(point: XY, line: list[XY]) -> float:
    """Return how far a point is from a line of several parts."""
    best = math.dist(point, line[0])
    for a, b in pairwise(line):
        length = math.dist(a, b)
        along = sum((q - p) * (r - p) for p, q, r in zip(a, b, point, strict=True))
        share = min(max(along / length**2, 0), 1) if length else 0.0
        nearest = [p + share * (q - p) for p, q in zip(a, b, strict=True)]
        best = min(best, math.dist(point, nearest))
    return best


@pytest.mark.parametrize("case", CASES)
def test_robots_are_where_and_when_a_walk_would_have_them(case: str, tmp_path: Path) -> None:
    instance = timed(CASES[case])
    plan = shared(instance, 14 if case == "many" else 3)
    data = Page(page_of(plan, instance, tmp_path)).data
    items = {item.id: item for item in instance.items}
    speeds = {robot.id: robot.speed for robot in instance.robots}
    metres: list[XY] = []
    drawn: list[XY] = []
    assert len(data["robots"]) == len(plan.trips)  # each makes one
    for trip, robot in zip(plan.trips, data["robots"], strict=True):
        (shown,) = robot["trips"]
        stops = [items[stop] for stop in trip.stops]
        ways = instance.warehouse.distance_matrix([item.place for item in stops])
        clock = 0.0
        for k, item in enumerate(stops):
            clock += float(ways[k, k + 1]) / speeds[trip.robot]
            assert shown["arrives"][k] == pytest.approx(clock, abs=2e-3)
            metres.append(instance.warehouse.position(item.place))
            drawn.append(at(shown, clock))
            clock += item.pick_seconds
            assert shown["leaves"][k] == pytest.approx(clock, abs=2e-3)
            assert shown["labels"][k].endswith(f": {item.id}")
        clock += float(ways[len(stops), 0]) / speeds[trip.robot]
        assert shown["end"] == pytest.approx(clock, abs=2e-3)
        assert shown["t"] == sorted(shown["t"])
        metres.append(instance.warehouse.depot)
        drawn.append(at(shown, clock))
    assert data["end"] == pytest.approx(max(r["trips"][0]["end"] for r in data["robots"]))
    # One scale for both directions, y downwards, fits all stops: but for the lane in the aisle.
    (scale, left, top), lane = fitted(metres, drawn)
    house = instance.warehouse
    wide = scale * (house.aisle_pitch if isinstance(house, AisleWarehouse) else 0.0)
    assert lane <= max(0.3 * wide, 15.0 if case == "manhattan" else 0.2)
    # And between the stops they keep to the real ways.
    for trip, robot in zip(plan.trips, data["robots"], strict=True):
        (shown,) = robot["trips"]
        places = [None, *(items[stop].place for stop in trip.stops), None]
        times = [
            0.0,
            *(t for pair in zip(shown["arrives"], shown["leaves"], strict=True) for t in pair),
            shown["end"],
        ]
        for k, (a, b) in enumerate(pairwise(places)):
            line = [(left + scale * x, top - scale * y) for x, y in house.way(a, b)]
            for moment in np.linspace(times[2 * k], times[2 * k + 1], 9):
                assert off(at(shown, float(moment)), line) <= lane + 1.5


def fitted(metres: list[XY], drawn: list[XY]) -> tuple[tuple[float, float, float], float]:
    """Return scale and shift from metres to the drawing, and the largest distance that is left."""
    rows, values = [], []
    for (x, y), (px, py) in zip(metres, drawn, strict=True):
        rows += [(x, 1, 0), (-y, 0, 1)]
        values += [px, py]
    found, *_ = np.linalg.lstsq(np.array(rows, dtype=float), np.array(values), rcond=None)
    rest = (np.array(rows) @ found - values).reshape(-1, 2)
    return (float(found[0]), float(found[1]), float(found[2])), float(np.hypot(*rest.T).max())


def test_the_time_of_all_robots_is_that_of_the_objective(tmp_path: Path) -> None:
    instance = timed(CASES["closed"])
    plan = shared(instance)
    timed_plan = Plan.from_routes(instance, plan.routes(instance), OBJECTIVES["time"])
    data = Page(page_of(timed_plan, instance, tmp_path)).data
    total = sum(trip["end"] - trip["start"] for r in data["robots"] for trip in r["trips"])
    assert total == pytest.approx(timed_plan.cost, abs=0.01)


def test_a_robot_makes_its_trips_one_after_the_other(tmp_path: Path) -> None:
    instance = CASES["aisles"]
    instance = replace(instance, robots=(replace(instance.robots[0], trips=3),))
    (robot,) = Page(page_of(shared(instance), instance, tmp_path)).data["robots"]
    assert robot["trips"][0]["start"] == 0
    for before, after in pairwise(robot["trips"]):
        assert after["start"] == before["end"]
    assert robot["picks"] == instance.size == sum(len(t["labels"]) for t in robot["trips"])
    assert len({trip["fill"] for trip in robot["trips"]}) == 3


NAMES = st.text(st.sampled_from("<>&\"'=+-/\\{}%#; abשלום\u0301"), min_size=1, max_size=14).filter(
    lambda name: name.strip() != ""
)


@settings(max_examples=40, deadline=None)
@given(st.lists(NAMES, min_size=4, max_size=4, unique_by=canonical))
def test_odd_names_are_text_and_nothing_else(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    plain = CASES["aisles"]
    one = replace(
        plain,
        items=(replace(plain.items[0], id=names[0], article="</script><b>&amp;"),),
        orders=(qrobot.Order(names[1], (names[0],)),),
        robots=(replace(plain.robots[0], id=names[2]),),
        name=names[3],
    )
    page = Page(page_of(Plan.from_routes(one, [[1]]), one, tmp_path_factory.mktemp("odd")))
    assert page.tags.count("script") == 1
    assert set(page.tags) <= {
        "html", "head", "meta", "title", "link", "style", "body", "main", "h1", "p", "noscript",
        "div", "button", "input", "output", "label", "select", "option", "figure", "svg", "rect",
        "path", "g", "text", "circle", "polygon", "table", "caption", "thead", "tr", "th", "tbody",
        "td", "span", "script",
    }  # fmt: skip
    assert page.data["robots"][0]["trips"][0]["labels"][0].endswith(": </script><b>&amp;")


def test_a_page_needs_no_drawing_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert "<svg" in page_of(shared(CASES["table"]), CASES["table"], tmp_path)


def test_only_a_plan_moves() -> None:
    with pytest.raises(qrobot.InputError, match=r"end it with \.svg or \.png$"):
        check_picture_path("gaps.html")


def test_two_trips_in_one_slot_have_a_part_of_it_each(tmp_path: Path) -> None:
    plain = CASES["aisles"]
    place = plain.items[0].place
    one = replace(
        plain,
        warehouse=LAYOUT,
        items=tuple(replace(item, place=place) for item in plain.items[:2]),
        orders=plain.orders[:2],
    )
    text = page_of(Plan.from_routes(one, [[1], [2]]), one, tmp_path)
    boxes = [part.split('"') for part in text.split('class="mark" ')[1:]]
    (x1, w1), (x2, w2) = sorted((float(b[1]), float(b[5])) for b in boxes)
    assert x1 + w1 == pytest.approx(x2, abs=0.02)
    assert w1 == w2
