"""Distances against oracles that share no code with them."""

from __future__ import annotations

import itertools
import math
import time

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import aisle_warehouses, instances

from qrobot.errors import InputError
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Point,
    Robot,
    Slot,
)


def fine_graph(w: AisleWarehouse) -> nx.Graph:
    """Every slot and every crossing as a node: nothing clever."""
    graph = nx.Graph()
    for a, length in ((w.depot_aisle, w.depot_distance), *w.depot_ways)[bool(w.depot_offset) :]:
        graph.add_edge("depot", ("x", a, w.depot_cross_aisle), weight=length)
    if w.depot_offset:
        a, c, gate = w.depot_aisle, w.depot_cross_aisle, "beside the depot"
        graph.add_edge("depot", gate, weight=w.depot_distance)
        graph.add_edge(("x", a, c), gate, weight=w.depot_offset)
        graph.add_edge(gate, ("x", a + 1, c), weight=w.aisle_pitch - w.depot_offset)
    for a in range(w.aisles):
        for b in range(w.blocks):
            chain = [("x", a, b), *((a, b, s) for s in range(w.slots)), ("x", a, b + 1)]
            graph.add_nodes_from(chain)
            front, back = w.block_gaps[b] if w.block_gaps else (w.end_gap, w.end_gap)
            steps = [front, *[w.slot_pitch] * (w.slots - 1), back]
            if (a, b) not in w.closed_aisles:
                for (one, other), step in zip(itertools.pairwise(chain), steps, strict=True):
                    graph.add_edge(one, other, weight=step)
    for c in range(w.blocks + 1):
        for a in range(w.aisles - 1):
            if (c, a) not in w.closed_crossings:
                graph.add_edge(("x", a, c), ("x", a + 1, c), weight=w.aisle_pitch)
    return graph


def all_slots(w: AisleWarehouse) -> list[Slot]:
    return [Slot(a, s, b) for a in range(w.aisles) for b in range(w.blocks) for s in range(w.slots)]


def length(way: list[tuple[float, float]]) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(way))


def walked(w: AisleWarehouse, way: list[tuple[float, float]]) -> float:
    """Return the length of a way; the depot's ways to crossings are as long as the layout says."""
    heights = [0.0]
    for front, back in w.block_gaps or [(w.end_gap, w.end_gap)] * w.blocks:
        heights.append(heights[-1] + front + (w.slots - 1) * w.slot_pitch + back)
    doors = {(a * w.aisle_pitch, heights[w.depot_cross_aisle]): d for a, d in w.depot_ways}
    total = 0.0
    for one, other in itertools.pairwise(way):
        far = other if one == w.depot else one
        stated = doors.get(far, math.inf) if w.depot in (one, other) else math.inf
        straight = one[0] == other[0] or one[1] == other[1]
        total += min(stated, math.dist(one, other) if straight else math.inf)
    return total


@settings(max_examples=60, deadline=None)
@given(aisle_warehouses(closed=True))
def test_aisle_distances_are_shortest_paths_on_the_fine_graph(w: AisleWarehouse) -> None:
    slots = all_slots(w)
    found = w.distance_matrix(slots)
    graph = fine_graph(w)
    nodes = ["depot", *((s.aisle, s.block, s.slot) for s in slots)]
    for i, node in enumerate(nodes):
        paths = nx.single_source_dijkstra_path_length(graph, node)
        expected = [paths.get(other, math.inf) for other in nodes]
        assert np.allclose(found[i], expected, rtol=0, atol=1e-9)
    assert (found == found.T).all()
    assert (np.diag(found) == 0).all()


@settings(max_examples=60, deadline=None)
@given(aisle_warehouses(closed=True), st.data())
def test_a_way_is_as_long_as_its_distance_and_keeps_to_the_aisles(
    w: AisleWarehouse, data: st.DataObject
) -> None:
    places = data.draw(st.lists(st.sampled_from(all_slots(w)), min_size=1, max_size=4))
    distances = w.distance_matrix(places)
    ends = [None, *places]
    for i, j in itertools.product(range(len(ends)), repeat=2):
        if i == j or not math.isfinite(distances[i, j]):
            continue
        way = w.way(ends[i], ends[j])
        assert way[0] == (w.depot if i == 0 else w.position(places[i - 1]))
        assert way[-1] == (w.depot if j == 0 else w.position(places[j - 1]))
        assert walked(w, way) == pytest.approx(distances[i, j], abs=1e-9)
        for one, other in itertools.pairwise(way):
            assert_on_grid(w, one, other)


def assert_on_grid(w: AisleWarehouse, one: tuple[float, float], other: tuple[float, float]) -> None:
    """Along one open aisle or one open cross aisle, or on the depot's own lead."""
    if (w.depot_distance or w.depot_ways) and w.depot in (one, other):
        return
    heights = [0.0]
    for front, back in w.block_gaps or [(w.end_gap, w.end_gap)] * w.blocks:
        heights.append(heights[-1] + front + (w.slots - 1) * w.slot_pitch + back)
    (x0, y0), (x1, y1) = one, other
    if x0 == x1:
        aisle = round(x0 / w.aisle_pitch)
        assert aisle * w.aisle_pitch == pytest.approx(x0)
        low, high = sorted((y0, y1))
        for block in range(w.blocks):
            inside = min(high, heights[block + 1]) - max(low, heights[block])
            assert inside <= 1e-9 or (aisle, block) not in w.closed_aisles
    else:
        assert y0 == y1
        cross = min(range(w.blocks + 1), key=lambda c: abs(heights[c] - y0))
        assert heights[cross] == pytest.approx(y0)
        low, high = sorted((x0, x1))
        for aisle in range(w.aisles - 1):
            inside = min(high, (aisle + 1) * w.aisle_pitch) - max(low, aisle * w.aisle_pitch)
            assert inside <= 1e-9 or (cross, aisle) not in w.closed_crossings


def test_a_layout_by_hand() -> None:
    w = AisleWarehouse(
        aisles=3, blocks=2, slots=4, aisle_pitch=3, slot_pitch=1, end_gap=1, depot_distance=2
    )
    assert w.block_lengths == (5, 5)
    d = w.distance_matrix([Slot(0, 0), Slot(0, 3), Slot(2, 3), Slot(1, 0, block=1)])
    assert d[0].tolist() == [0, 3, 6, 12, 11]
    assert d[1, 2] == 3  # straight along the aisle
    assert d[2, 3] == 1 + 6 + 1  # over the middle cross aisle
    assert d[2, 4] == 1 + 3 + 1
    assert length(w.way(None, Slot(2, 3))) == 12
    assert w.way(Slot(0, 3), Slot(1, 0, block=1)) == [(0, 4), (0, 5), (3, 5), (3, 6)]


def test_a_serpentine_of_closures_is_followed() -> None:
    """Alternate cross-aisle segments closed: the way runs through every aisle."""
    closed = frozenset((a % 2, a) for a in range(9))
    w = AisleWarehouse(aisles=10, slots=3, closed_crossings=closed)
    far = w.distance_matrix([Slot(9, 1)])[0, 1]
    graph = fine_graph(w)
    assert far == nx.dijkstra_path_length(graph, "depot", (9, 0, 1))
    assert length(w.way(None, Slot(9, 1))) == pytest.approx(far)


@given(
    st.sampled_from(["euclidean", "manhattan"]),
    st.sampled_from(["none", "nearest"]),
    st.lists(st.tuples(st.integers(-50, 50), st.integers(-50, 50)), min_size=1, max_size=6),
)
def test_floor_distances_are_plain_geometry(
    metric: str, rounding: str, points: list[tuple[int, int]]
) -> None:
    floor = OpenFloor(3.5, -2.0, metric, rounding)  # type: ignore[arg-type]
    places = [Point(x / 2, y / 2) for x, y in points]
    found = floor.distance_matrix(places)
    xy = [floor.depot, *((p.x, p.y) for p in places)]
    for i, j in itertools.product(range(len(xy)), repeat=2):
        plain = math.dist(xy[i], xy[j])
        if metric == "manhattan":
            plain = abs(xy[i][0] - xy[j][0]) + abs(xy[i][1] - xy[j][1])
        expected = math.floor(plain + 0.5) if rounding == "nearest" else plain
        assert found[i, j] == pytest.approx(expected, abs=1e-12)
        way = floor.way(None if i == 0 else places[i - 1], None if j == 0 else places[j - 1])
        assert length(way) == pytest.approx(plain, abs=1e-9)


def test_a_table_gives_its_rows_whatever_its_depot() -> None:
    table = DistanceTable(((0, 1, 2), (3, 0, 4), (5, 6, 0)), depot_node=1)
    assert table.distance_matrix([Node(2), Node(0)]).tolist() == [[0, 4, 3], [6, 0, 5], [1, 2, 0]]


def test_the_diagonal_of_a_table_is_not_used() -> None:
    table = DistanceTable(((9, 1), (1, math.inf)))
    items = (Item("a", 1, Node(1)), Item("b", 1, Node(1)), Item("c", 1, Node(0)))  # type: ignore
    one = Instance(table, items, (Order("o", ("a", "b", "c")),), (Robot("R1", 9),))  # type: ignore
    assert one.distances.tolist() == [[0, 1, 1, 0], [1, 0, 0, 1], [1, 0, 0, 1], [0, 1, 1, 0]]


@settings(max_examples=50, deadline=None)
@given(instances())
def test_items_in_one_place_share_a_row(one: Instance) -> None:
    d = one.distances
    assert d.shape == (one.size + 1, one.size + 1)
    assert not d.flags.writeable
    assert (d == one.warehouse.distance_matrix([i.place for i in one.items])).all()
    assert len(one.places) + 1 == len(one.place_distances)


def many(count: int, w: AisleWarehouse) -> Instance:
    items = tuple(
        Item(f"i{k}", 1, Slot(k * 7 % w.aisles, k * 11 % w.slots, k % w.blocks))  # type: ignore
        for k in range(count)
    )
    orders = (Order("all", tuple(i.id for i in items)),)
    return Instance(w, items, orders, (Robot("R1", count),))  # type: ignore[arg-type]


@pytest.mark.parametrize("closed", [frozenset(), frozenset({(3, 0)})])
def test_two_thousand_items_take_less_than_a_second(closed: frozenset[tuple[int, int]]) -> None:
    w = AisleWarehouse(aisles=41, blocks=3, slots=31, closed_crossings=closed)
    one = many(2000, w)
    assert len(one.places) == 2000
    start = time.process_time()
    _ = one.distances
    assert time.process_time() - start < 1.0


def test_ten_thousand_items_are_made_at_once() -> None:
    w = AisleWarehouse(aisles=20, blocks=2, slots=50)
    start = time.process_time()
    one = many(10_000, w)
    assert one.place_distances.shape == (len(one.places) + 1,) * 2
    assert one.weights.sum() == 10_000
    assert time.process_time() - start < 1.0


def test_an_unreachable_slot_is_named() -> None:
    w = AisleWarehouse(aisles=3, slots=2, closed_aisles=frozenset({(1, 0)}))
    items = (Item("free", 1, Slot(0, 0)), Item("shut", 1, Slot(1, 0)))  # type: ignore[arg-type]
    one = Instance(w, items, (Order("o", ("free", "shut")),), (Robot("R1", 9),))  # type: ignore
    with pytest.raises(InputError) as caught:
        _ = one.distances
    assert str(caught.value) == (
        "items[1].at: no way leads from the depot to items shut and back; "
        "move the items, or open an aisle"
    )
