"""Ways over the cells of a map: against networkx, and in maps where anyone sees them."""

from __future__ import annotations

import math
import pickle
import re
import sys
import tomllib
from itertools import pairwise, product
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot._extras import DISTRIBUTIONS
from qrobot.errors import InputError, MissingExtraError
from qrobot.plan.ruler import Ruler
from qrobot.problem import FloorMap, Point, Pose
from qrobot.problem.floor_map import clear_line

ROOM = (
    "#########",
    "#...#...#",
    "#...#...#",
    "#...#...#",
    "#.......#",
    "#########",
)


def middle(row: int, column: int, side: float = 1.0) -> Point:
    """Return the middle of a cell, the row counted from the bottom."""
    return Point((column + 0.5) * side, (row + 0.5) * side)


def grid_graph(rows: tuple[str, ...]) -> nx.Graph:
    """Return the free cells and the steps between them, told once more and by other means."""
    free = {(r, c) for r, row in enumerate(rows[::-1]) for c, x in enumerate(row) if x == "."}
    graph = nx.Graph()
    graph.add_nodes_from(free)
    for (r, c), dr, dc in product(free, (-1, 0, 1), (-1, 0, 1)):
        around = {(r + dr, c + dc), (r + dr, c), (r, c + dc)}
        if (dr or dc) and around <= free:
            graph.add_edge((r, c), (r + dr, c + dc), weight=math.hypot(dr, dc))
    return graph


@st.composite
def maps(draw: st.DrawFn) -> tuple[tuple[str, ...], list[tuple[int, int]]]:
    """Draw the cells of a map, and some free ones of it."""
    wide, high = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    cells = draw(st.lists(st.sampled_from("....#?"), min_size=wide * high, max_size=wide * high))
    cells[draw(st.integers(0, wide * high - 1))] = "."
    rows = tuple("".join(cells[k * wide : (k + 1) * wide]) for k in range(high))
    free = [(r, c) for r, row in enumerate(rows[::-1]) for c, x in enumerate(row) if x == "."]
    return rows, draw(st.lists(st.sampled_from(free), min_size=1, max_size=6))


@settings(max_examples=150, deadline=None)
@given(maps(), st.sampled_from([0.05, 0.5, 1.0]))
def test_distances_are_those_of_dijkstra_on_the_grid(
    drawn: tuple[tuple[str, ...], list[tuple[int, int]]], side: float
) -> None:
    rows, cells = drawn
    places = [middle(*cell, side) for cell in cells]
    house = FloorMap(rows, side, places[0])
    graph = grid_graph(rows)
    found = house.distance_matrix(places)
    ruler = Ruler(house)
    assert (found == found.T).all()
    for i, a in enumerate([cells[0], *cells]):
        known = nx.single_source_dijkstra_path_length(graph, a)
        for j, b in enumerate([cells[0], *cells]):
            length = known.get(b, math.inf) * side
            assert found[i, j] == pytest.approx(length)
            ends = [None if k == 0 else places[k - 1] for k in (i, j)]
            assert ruler.leg(*ends) == pytest.approx(length)


@settings(max_examples=60, deadline=None)
@given(maps(), st.floats(0.0, 3.0))
def test_obstacles_are_inflated_by_the_radius(
    drawn: tuple[tuple[str, ...], list[tuple[int, int]]], radius: float
) -> None:
    rows, cells = drawn
    high, wide = len(rows), len(rows[0])
    taken = [
        (r, c)
        for r in range(-1, high + 1)
        for c in range(-1, wide + 1)
        if not (0 <= r < high and 0 <= c < wide and rows[::-1][r][c] == ".")
    ]
    for cell in cells:
        apart = min(math.dist(cell, other) for other in taken)
        if abs(apart - radius) < 1e-6:
            continue
        if apart > radius:
            house = FloorMap(rows, 1.0, middle(*cell), radius=radius)
            assert Ruler(house).leg(None, middle(*cell)) == 0.0
            assert Ruler(house).leg(None, Point(*house.depot)) == 0.0
        else:
            with pytest.raises(InputError, match="is nearer to a wall than the radius"):
                FloorMap(rows, 1.0, middle(*cell), radius=radius)


@settings(max_examples=60, deadline=None)
@given(maps(), st.integers(1, 3), st.floats(0.0, 1.6))
def test_the_checker_measures_coarse_and_inflated_maps_alike(
    drawn: tuple[tuple[str, ...], list[tuple[int, int]]], coarse: int, radius: float
) -> None:
    rows, cells = drawn
    places = []
    for cell in cells:
        try:
            house = FloorMap(rows, 0.1, middle(*cell, 0.1), radius=radius / 10, coarse=coarse)
        except InputError:
            continue
        places.append(middle(*cell, 0.1))
    if not places:
        return
    house = FloorMap(rows, 0.1, places[0], radius=radius / 10, coarse=coarse)
    found = house.distance_matrix(places)
    ruler = Ruler(house)
    ends = [None, *places]
    for i, j in product(range(len(ends)), repeat=2):
        assert ruler.leg(ends[i], ends[j]) == pytest.approx(found[i, j])


@settings(max_examples=60, deadline=None)
@given(
    maps(), st.floats(-4, 4), st.floats(-50, 50), st.floats(-50, 50), st.sampled_from([0.0, 0.9])
)
def test_a_map_that_is_turned_and_moved_has_the_same_distances(
    drawn: tuple[tuple[str, ...], list[tuple[int, int]]],
    yaw: float, x: float, y: float, radius: float,
) -> None:  # fmt: skip
    rows, cells = drawn
    plain = [middle(*cell) for cell in cells]
    turned = [
        Point(
            x + p.x * math.cos(yaw) - p.y * math.sin(yaw),
            y + p.x * math.sin(yaw) + p.y * math.cos(yaw),
        )
        for p in plain
    ]
    house = FloorMap(rows, 1.0, plain[0], radius=radius)
    other = FloorMap(rows, 1.0, turned[0], (x, y, yaw), radius=radius)
    np.testing.assert_allclose(house.distance_matrix(plain), other.distance_matrix(turned))
    for a, b in product(range(len(plain)), repeat=2):
        if not math.isfinite(house.distance_matrix([plain[a], plain[b]])[1, 2]):
            continue
        way = house.way(plain[a], plain[b])
        image = other.way(turned[a], turned[b])
        assert len(way) == len(image)
        for (px, py), at in zip(way, image, strict=True):
            assert at == pytest.approx(
                (
                    x + px * math.cos(yaw) - py * math.sin(yaw),
                    y + px * math.sin(yaw) + py * math.cos(yaw),
                ),
                abs=1e-6,
            )


@settings(max_examples=100, deadline=None)
@given(maps())
def test_ways_stay_on_free_cells_and_are_no_longer_than_their_length(
    drawn: tuple[tuple[str, ...], list[tuple[int, int]]],
) -> None:
    rows, cells = drawn
    places = [middle(*cell) for cell in cells]
    house = FloorMap(rows, 1.0, places[0])
    lengths = house.distance_matrix(places)
    for i, place in enumerate(places, 1):
        if not math.isfinite(lengths[0, i]):
            continue
        way = house.way(None, place)
        assert (way[0], way[-1]) == ((places[0].x, places[0].y), (place.x, place.y))
        assert sum(map(math.dist, way, way[1:])) <= lengths[0, i] + 1e-9
        for (ax, ay), (bx, by) in pairwise(way):
            for k in range(201):
                x, y = ax + (bx - ax) * k / 200, ay + (by - ay) * k / 200
                assert rows[-1 - math.floor(y)][math.floor(x)] == "."


def test_a_way_goes_round_a_wall() -> None:
    house = FloorMap(ROOM, 1.0, middle(4, 3))
    # Down three, past the foot of the wall without touching its corner, and up again.
    assert house.distance_matrix([middle(4, 5)])[0, 1] == pytest.approx(3 + 2 + 3)
    assert house.way(None, middle(4, 5)) == [(3.5, 4.5), (3.5, 1.5), (5.5, 1.5), (5.5, 4.5)]


def test_no_way_passes_between_cells_that_touch_at_a_corner() -> None:
    house = FloorMap(("#..", "..#"), 1.0, middle(0, 0))
    assert house.distance_matrix([middle(1, 2)])[0, 1] == pytest.approx(3)
    closed = FloorMap((".#", "#."), 1.0, middle(1, 0))
    assert math.isinf(closed.distance_matrix([middle(0, 1)])[0, 1])


def test_lines_past_a_corner_are_not_clear() -> None:
    ok = np.array([[True, True], [False, True]])
    assert not clear_line((0, 0), (1, 1), ok)
    assert clear_line((0, 1), (1, 1), ok)


@pytest.mark.parametrize(
    ("at", "problem"),
    [
        ((0.5, 0.5), "pose 'shelf' at (0.5, 0.5) of hall.yaml lies in a wall; move it to a free"),
        ((2.5, 1.5), "lies where the map knows nothing; move it to a free cell, or map the place"),
        ((-0.1, 1.5), "is outside the map; move it, or correct the origin of the map"),
        ((7.0, 1.5), "is outside the map"),
        ((1.5, 1.5), "is nearer to a wall than the radius of the robots, 1; move it, or give a"),
    ],
)
def test_a_pose_where_no_robot_can_stand_is_told(at: tuple[float, float], problem: str) -> None:
    rows = ("#######", "#.?...#", "#.?...#", "#.....#", "#.?...#", "#######")
    house = FloorMap(
        rows, 1.0, Point(4.5, 2.5), poses=(("shelf", at),), radius=1.0, source="hall.yaml"
    )
    with pytest.raises(InputError) as caught:
        house.check(Pose("shelf"))
    assert problem in str(caught.value)


def test_coarse_cells_are_free_all_over_or_not_at_all() -> None:
    rows = ("......", "......", "....#.", "......")
    house = FloorMap(rows, 0.5, Point(0.25, 0.25), coarse=2)
    assert house.walkable.tolist() == [[True, True, False], [True, True, True]]
    with pytest.raises(InputError, match="is in a cell of 1 that is not free all over; move it"):
        house.check(Point(2.25, 0.25))
    odd = FloorMap(("...", "...", "..."), 0.5, Point(0.25, 0.25), coarse=2)
    assert odd.walkable.tolist() == [[True, False], [False, False]]  # beside it nothing is known


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"rows": ()}, "cells: 0 rows of 0 cells are not 1 to"),
        ({"rows": ("..", ".")}, r"cells\[1\]: has 1 cells where the first row has 2"),
        ({"rows": ("..", ".x")}, r"cells\[1\]: holds 'x'; use . for free"),
        ({"resolution": 0.0}, "resolution: 0 is not 0.001 to 1000"),
        ({"radius": -1.0}, "radius: -1 is not 0 to 1000"),
        ({"origin": (0.0, math.nan, 0.0)}, "origin.y: nan is not"),
        ({"depot_place": Pose("dok")}, "depot: 'dok' is not a pose; did you mean dock?"),
        ({"poses": (("a", (0, 0)), ("a", (1, 1)))}, "poses: the pose 'a' is given twice"),
        ({"coarse": 0}, "cell: 0 cells"),
    ],
)
def test_maps_that_make_no_sense_are_refused(change: dict[str, object], problem: str) -> None:
    given_ = {"rows": ("..", ".."), "resolution": 1.0, "depot_place": Point(0.5, 0.5)}
    given_["poses"] = (("dock", (0.5, 0.5)),)
    with pytest.raises(InputError, match=problem):
        FloorMap(**{**given_, **change})  # type: ignore[arg-type]


def test_a_place_of_another_kind_is_refused() -> None:
    from qrobot.problem import Node

    house = FloorMap(ROOM, 1.0, middle(1, 1))
    with pytest.raises(InputError, match="node 3 is not on a map; a map needs a pose, or x and y"):
        house.check(Node(3))


def test_too_much_work_is_refused_with_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qrobot.problem.shortest_ways.MAX_VISITS", 30)
    house = FloorMap(ROOM, 1.0, middle(1, 1))
    with pytest.raises(InputError, match=r"warehouse.cell: 2 places on 25 nodes .*; plan on"):
        house.distance_matrix([middle(4, 5)])


def test_a_map_goes_to_helpers_without_what_is_derived() -> None:
    house = FloorMap(ROOM, 1.0, middle(1, 1))
    bare = len(pickle.dumps(house))
    house.distance_matrix([middle(4, 5)])
    assert len(pickle.dumps(house)) == bare
    assert pickle.loads(pickle.dumps(house)) == house
    assert hash(house) == hash(pickle.loads(pickle.dumps(house)))


@pytest.mark.parametrize(("module", "radius"), [("scipy.sparse", 0.0), ("scipy.ndimage", 0.5)])
def test_without_scipy_the_extra_is_named(
    module: str, radius: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("qrobot._extras.extras", lambda: {"maps": frozenset({"scipy"})})
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=r"^a map needs .* pip install 'qrobot\[maps\]'"):
        FloorMap(ROOM, 1.0, middle(1, 1), radius=radius).distance_matrix([middle(4, 5)])


def test_the_extra_has_all_that_maps_need() -> None:
    text = (Path(qrobot.__file__).parents[1] / "pyproject.toml").read_text()
    held = tomllib.loads(text)["project"]["optional-dependencies"]["maps"]
    names = {re.split(r"[>=<\[]", one)[0] for one in held}
    for module in ("scipy", "PIL", "yaml"):
        assert DISTRIBUTIONS.get(module, module) in names
