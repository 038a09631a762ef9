"""Pictures: parsed as XML; every trip's way passes every stop of it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from scenes import CASES, LAYOUT, points, question, shared, slots

import qrobot
from qrobot.plan import Plan
from qrobot.problem import (
    AisleWarehouse,
    Instance,
    OpenFloor,
    Point,
    Slot,
    Warehouse,
)
from qrobot.report import plot
from qrobot.report.palette import DEPOT, colour_of
from qrobot.report.scene import scene_of

pytest.importorskip("matplotlib")

SVG = "{http://www.w3.org/2000/svg}"
HREF = "{http://www.w3.org/1999/xlink}href"


def drawn(instance: Instance, plan: Plan, tmp_path: Path) -> ET.Element:
    path = tmp_path / "plan.svg"
    plot(plan, path, instance)
    return ET.fromstring(path.read_text())


def by_id(root: ET.Element, name: str) -> ET.Element:
    found = [e for e in root.iter() if e.get("id") == name]
    assert len(found) == 1, name
    return found[0]


def flattened(path: str) -> list[tuple[float, float]]:
    """Return the points of an SVG path with its curves cut into short lines."""
    found: list[tuple[float, float]] = []
    for command, numbers in re.findall(r"([MLQ])([^MLQ]*)", path):
        xy = [float(v) for v in numbers.split()]
        if command in "ML":
            found.append((xy[0], xy[1]))
            continue
        (ax, ay), (cx, cy, bx, by) = found[-1], xy
        for k in range(1, 9):
            t = k / 8
            found.append(
                (
                    (1 - t) ** 2 * ax + 2 * t * (1 - t) * cx + t * t * bx,
                    (1 - t) ** 2 * ay + 2 * t * (1 - t) * cy + t * t * by,
                )
            )
    return found


def distance(at: tuple[float, float], line: list[tuple[float, float]]) -> float:
    best = math.inf
    for (ax, ay), (bx, by) in pairwise(line):
        length = math.dist((ax, ay), (bx, by))
        t = ((at[0] - ax) * (bx - ax) + (at[1] - ay) * (by - ay)) / length**2 if length else 0
        t = min(1.0, max(0.0, t))
        best = min(best, math.dist(at, (ax + t * (bx - ax), ay + t * (by - ay))))
    return best


@pytest.mark.parametrize("name", CASES)
def test_every_way_passes_every_stop_of_its_trip(name: str, tmp_path: Path) -> None:
    instance = CASES[name]
    plan = shared(instance, trips=min(len(instance.robots), 15))
    root = drawn(instance, plan, tmp_path)
    depot = by_id(root, "depot").find(f".//{SVG}use")
    assert depot is not None
    for n, trip in enumerate(plan.trips, 1):
        way = by_id(root, f"trip-{n}-way").find(f".//{SVG}path")
        assert way is not None
        line = flattened(way.get("d", ""))
        marks = by_id(root, f"trip-{n}-stops").iter(f"{SVG}use")
        stops = [(float(m.get("x", "nan")), float(m.get("y", "nan"))) for m in marks]
        assert len(stops) == len(trip.stops)
        # Lanes move ways a little; on the floor the marks stay where the items are.
        assert all(distance(at, line) < 4.0 for at in stops)
        home = float(depot.get("x", "nan")), float(depot.get("y", "nan"))
        assert math.dist(line[0], home) < 40
        assert math.dist(line[-1], home) < 40


def test_trips_have_ways_of_their_own(tmp_path: Path) -> None:
    """Three trips past the same slots are drawn beside each other."""
    instance = question(LAYOUT, [Slot(6, 3), Slot(6, 4), Slot(6, 5)])
    root = drawn(instance, shared(instance), tmp_path)
    ways = []
    for n in (1, 2, 3):
        path = by_id(root, f"trip-{n}-way").find(f".//{SVG}path")
        assert path is not None
        ways.append(set(flattened(path.get("d", ""))[1:-1]))
    assert not any(a & b for a, b in combinations(ways, 2))


def test_the_warehouse_is_on_the_picture(tmp_path: Path) -> None:
    instance = CASES["closed"]
    root = drawn(instance, shared(instance), tmp_path)
    ids = {e.get("id") for e in root.iter()}
    assert {"floor", "racks", "depot", "closed-1", "closed-2", "closed-3", "title"} <= ids
    assert {"trip-1-picks", "trip-2-picks", "trip-3-picks", "trip-1-arrows"} <= ids
    hatched = by_id(root, "closed-1").find(f".//{SVG}path")
    assert hatched is not None
    assert "url(#" in hatched.get("style", "")
    texts = "".join(root.itertext())
    for text in ("depot", "R1", "R2", "R3", "closed", "aisle 0"):
        assert text in texts
    outlines = by_id(root, "racks").findall(f".//{SVG}path")
    uses = by_id(root, "racks").findall(f".//{SVG}use")
    assert max(len(outlines), len(uses)) == 8 * 10 * 2 * 2


def test_robots_have_the_colours_of_the_paper(tmp_path: Path) -> None:
    def channels(colour: str) -> tuple[int, ...]:
        return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))

    red, blue, yellow = (channels(colour_of(k).fill) for k in range(3))
    assert red[0] > 200 > 2 * max(red[1:])
    assert blue[2] > 180 > 90 > blue[0]
    assert min(yellow[:2]) > 170 > 50 > yellow[2]
    fills = [colour_of(k).fill for k in range(60)]
    assert len(set(fills)) == 60
    assert DEPOT not in fills
    instance = CASES["aisles"]
    root = drawn(instance, shared(instance), tmp_path)
    for n in (1, 2, 3):
        way = by_id(root, f"trip-{n}-way").find(f".//{SVG}path")
        assert way is not None
        assert f"stroke: {colour_of(n - 1).fill}" in way.get("style", "")


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_the_same_plan_gives_the_same_file(suffix: str, tmp_path: Path) -> None:
    instance = CASES["closed"]
    one, two = tmp_path / f"one.{suffix}", tmp_path / f"two.{suffix.upper()}"
    for path in (one, two):
        plot(shared(instance), path, instance)
    assert one.read_bytes() == two.read_bytes()
    start = {"svg": b"<?xml", "png": b"\x89PNG\r\n"}[suffix]
    assert one.read_bytes().startswith(start)
    assert b"matplotlib.org" not in one.read_bytes()


def test_a_result_says_how_good_it_is(tmp_path: Path) -> None:
    instance = question(OpenFloor(), [Point(3, 4)], name="three & <four>")
    result = qrobot.solve(instance, deadline=5)
    path = tmp_path / "plan.svg"
    qrobot.plot(result, path)
    texts = "".join(ET.fromstring(path.read_text()).itertext())
    assert "three & <four>: 10 m, proven optimal" in texts
    worse = replace(result, is_optimal=False, bound=8.0)
    assert scene_of(worse).title.endswith("10 m, at most 25.0% above the optimum")
    unknown = replace(result, is_optimal=False, bound=0.0)
    assert scene_of(unknown).title.endswith("10 m")


@pytest.mark.parametrize("house", [OpenFloor(), LAYOUT])
def test_nothing_to_do_is_a_picture_too(house: Warehouse, tmp_path: Path) -> None:
    assert "depot" in "".join(drawn(question(house, []), Plan((), 0.0), tmp_path).itertext())


def test_everything_in_one_place(tmp_path: Path) -> None:
    instance = question(OpenFloor(), [Point(0, 0)] * 4)
    assert drawn(instance, shared(instance, 2), tmp_path) is not None
    aisles = question(LAYOUT, [Slot(1, 1)] * 5)
    assert drawn(aisles, shared(aisles, 3), tmp_path) is not None


def test_what_is_not_picked_is_shown_grey(tmp_path: Path) -> None:
    for instance in (CASES["euclid"], CASES["aisles"]):
        plan = shared(instance)
        root = drawn(instance, replace(plan, trips=plan.trips[:2]), tmp_path)
        assert by_id(root, "not-picked") is not None


def test_several_trips_of_a_robot_are_told_apart(tmp_path: Path) -> None:
    instance = question(OpenFloor(), points(6), robots=1)
    robots = (replace(instance.robots[0], trips=3),)
    instance = replace(instance, robots=robots)
    root = drawn(instance, shared(instance), tmp_path)
    assert "R1, trip 2" in "".join(root.itertext())
    second = by_id(root, "trip-2-way").find(f".//{SVG}path")
    assert second is not None
    assert "stroke-dasharray" in second.get("style", "")


@pytest.mark.slow
@pytest.mark.parametrize("house", ["aisles", "floor"])
def test_a_thousand_items_are_drawn(house: str, tmp_path: Path) -> None:
    layout = AisleWarehouse(aisles=20, slots=30, blocks=3, depot_aisle=9, depot_distance=2.0)
    instance = (
        question(layout, slots(layout, 1000), robots=30)
        if house == "aisles"
        else question(OpenFloor(25.0, 25.0), points(1000), robots=80)
    )
    plan = shared(instance, 30 if house == "aisles" else 80)
    root = drawn(instance, plan, tmp_path)
    assert sum(1 for e in root.iter() if re.fullmatch(r"trip-\d+-way", e.get("id") or "")) == len(
        plan.trips
    )
    plot(plan, tmp_path / "plan.png", instance)
