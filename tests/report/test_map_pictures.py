"""Maps and lanes behind the ways: in pictures and on pages."""

from __future__ import annotations

import base64
import io
import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import qrobot
from qrobot.plan import Plan
from qrobot.problem import FloorMap, Instance, LaneNetwork, Point
from qrobot.report import pick_lists, picklist_page, plot
from qrobot.report.map_shapes import beside, extent, shades, walls

pytest.importorskip("matplotlib")

EXAMPLES = Path(__file__).parents[2] / "examples/maps"
SVG = "{http://www.w3.org/2000/svg}"


def planned(name: str, **warehouse: object) -> tuple[Instance, Plan]:
    """Return an example, its warehouse changed, and a plan of it."""
    instance = qrobot.read(EXAMPLES / name)
    if warehouse:
        instance = replace(instance, warehouse=replace(instance.warehouse, **warehouse))
    return instance, qrobot.solve(instance, backend="exact").plan


def drawn(plan: Plan, instance: Instance, path: Path) -> ET.Element:
    plot(plan, path, instance)
    return ET.parse(path).getroot()


def test_the_cells_of_a_map_are_behind_the_ways(tmp_path: Path) -> None:
    instance, plan = planned("on-map.json")
    picture = drawn(plan, instance, tmp_path / "plan.svg")
    (image,) = picture.iter(f"{SVG}image")
    data = image.get("{http://www.w3.org/1999/xlink}href", "").partition("base64,")[2]
    pixels = np.array(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB"))
    house = instance.warehouse
    assert isinstance(house, FloorMap)
    text = "".join(house.rows)
    wall = (pixels == (0xB4, 0xBE, 0xC9)).all(axis=2).mean()
    # The part of the picture that is wall is that of the cells: to a pixel at each edge.
    assert wall == pytest.approx(text.count("#") / len(text), rel=0.05)
    order = [e.get("id") for e in picture.iter() if e.get("id")]
    ways = [f"trip-{k}-way" for k in (1, 2)]
    assert order.index("map") < min(map(order.index, ways))


def test_the_same_map_gives_the_same_picture(tmp_path: Path) -> None:
    instance, plan = planned("on-map.json")
    for name in ("a.svg", "b.svg"):
        plot(plan, tmp_path / name, instance)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_lanes_are_behind_the_ways(tmp_path: Path) -> None:
    instance, plan = planned("on-lanes.json")
    picture = drawn(plan, instance, tmp_path / "plan.svg")
    house = instance.warehouse
    assert isinstance(house, LaneNetwork)
    groups = {e.get("id"): e for e in picture.iter(f"{SVG}g")}
    assert len(list(groups["lanes"].iter(f"{SVG}path"))) == len(house.lanes)
    heads = len(list(groups["one-ways"].iter(f"{SVG}use"))) or len(
        list(groups["one-ways"].iter(f"{SVG}path"))
    )
    assert heads == len(house.one_ways) == 20


@pytest.mark.parametrize("name", ["on-map.json", "on-lanes.json"])
def test_many_trips_get_small_maps_with_the_ground(name: str, tmp_path: Path) -> None:
    instance = qrobot.read(EXAMPLES / name)
    many = replace(
        instance,
        items=tuple(
            replace(item, id=f"{item.id} {k}") for k in range(2) for item in instance.items
        ),
        orders=tuple(
            qrobot.problem.Order(f"{item.id} {k}", (f"{item.id} {k}",))
            for k in range(2)
            for item in instance.items
        ),
        robots=tuple(qrobot.Robot(f"R{k}", 10) for k in range(20)),
    )
    plan = Plan.from_routes(many, [[k + 1] for k in range(20)])
    picture = drawn(plan, many, tmp_path / "plan.svg")
    ids = {e.get("id") for e in picture.iter()}
    assert {f"alone-{instance.warehouse.kind}", instance.warehouse.kind} <= ids


def test_pages_have_walls_and_lanes(tmp_path: Path) -> None:
    page = picklist_page(pick_lists(*planned("on-map.json")[::-1]), "a4")
    (racks,) = re.findall(r'<path class="rack"[^>]* d="([^"]+)"', page)
    assert racks.count("z") == 4 + 4 + 1  # the sides of the hall, the racks, the pillar
    instance, plan = planned("on-lanes.json")
    page = picklist_page(pick_lists(plan, instance), "a4")
    lanes = re.findall(r'<path class="lane" d="([^"]+)"', page)
    assert len(lanes) == 2
    assert all(d.count("L") == len(instance.warehouse.lanes) for d in lanes)
    plot(plan, tmp_path / "plan.html", instance)
    assert 'class="lane"' in (tmp_path / "plan.html").read_text()


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 8), st.integers(1, 8), st.data(), st.floats(-4, 4))
def test_rectangles_cover_the_occupied_cells_once(
    wide: int, high: int, data: st.DataObject, yaw: float
) -> None:
    cells = data.draw(st.lists(st.sampled_from(".#?"), min_size=wide * high, max_size=wide * high))
    cells[0] = "."
    rows = tuple("".join(cells[k * wide : (k + 1) * wide]) for k in range(high))
    house = FloorMap(rows, 0.5, Point(0.25, high / 2 - 0.25))
    covered = np.zeros((high, wide), dtype=int)
    for (left, low), _, (right, top), _ in walls(house):
        r, c = (slice(round(a * 2), round(b * 2)) for a, b in ((low, top), (left, right)))
        covered[r, c] += 1
    assert covered[::-1].tolist() == [[int(cell == "#") for cell in row] for row in rows]
    depot = Point(
        0.25 * math.cos(yaw) - (high / 2 - 0.25) * math.sin(yaw) + 3,
        0.25 * math.sin(yaw) + (high / 2 - 0.25) * math.cos(yaw) - 2,
    )
    turned = FloorMap(rows, 0.5, depot, (3, -2, yaw))
    left, low, right, top = extent(turned)
    for corners in walls(turned):
        for x, y in corners:
            assert left - 1e-9 <= x <= right + 1e-9
            assert low - 1e-9 <= y <= top + 1e-9
    assert shades(turned).shape == (high, wide, 3)


def test_large_maps_are_drawn_coarser_on_pages() -> None:
    rows = tuple("#" + "." * 998 + "#" if k % 2 else "." * 1000 for k in range(500))
    house = FloorMap(rows, 0.05, Point(10, 10))
    # Two columns of walls, of blocks of five cells each: one rectangle a side.
    assert len(walls(house)) == 2


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=2, max_size=8),
    st.floats(0.01, 0.2),
)
def test_lines_beside_a_way_keep_their_distance_on_the_right(
    points: list[tuple[int, int]], off: float
) -> None:
    way = [(float(x), float(y)) for x, y in points]
    moved = [b for a, b in pairwise([None, *way]) if a != b]
    if len(moved) < 2:
        return
    (track,) = beside([[way]], 2 * off, 100.0)
    first, last = track.corners[0], track.corners[-1]
    for at, (a, b) in ((first, moved[:2]), (last, moved[-2:])):
        length = math.dist(a, b)
        cross = (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])
        assert -cross / length == pytest.approx(off)  # to the right of its direction
    assert track.stops == []
    two = beside([[way], [way]], 1.0, 0.3)
    assert math.dist(two[0].corners[0], two[1].corners[0]) == pytest.approx(0.15)
