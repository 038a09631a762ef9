"""Tours along one-way aisles, against networks of every slot and programmes over all subsets."""

from __future__ import annotations

import dataclasses
import itertools
import math

import networkx as nx
import numpy as np
import pytest
from numpy.random import Generator
from tours import random_aisles, random_slot, shortest_way

from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse import POLICIES, OnCrossAisle, Router, route
from qrobot.warehouse.grid import grid_of

CASES = 150


def one_way(rng: Generator, blocks: int, *, most: int = 4) -> AisleWarehouse:
    """Return a layout some of whose parts that are not closed lead in one direction only."""
    house = random_aisles(rng, blocks, most=most)
    parts = list(itertools.product(range(house.aisles), range(blocks)))
    segments = list(itertools.product(range(blocks + 1), range(house.aisles - 1)))
    along = [
        (a, b, str(rng.choice(["front", "back"])))
        for a, b in parts
        if rng.random() < 0.3 and (a, b) not in house.closed_aisles
    ]
    across = [
        (c, a, str(rng.choice(["left", "right"])))
        for c, a in segments
        if rng.random() < 0.2 and (c, a) not in house.closed_crossings
    ]
    offset = 0.0
    segment = house.depot_cross_aisle, house.depot_aisle
    if segment in segments and segment not in house.closed_crossings and rng.random() < 0.3:
        offset = house.aisle_pitch / 2
    return dataclasses.replace(
        house,
        one_way_aisles=frozenset(along),
        one_way_crossings=frozenset(across),
        depot_offset=offset,
    )


def directed(w: AisleWarehouse) -> nx.DiGraph:
    """Return every slot and crossing as a node, and every step that may be walked."""
    graph = nx.DiGraph()

    def join(one: object, other: object, length: float, on: bool = True, back: bool = True) -> None:
        graph.add_nodes_from([one, other])
        if on:
            graph.add_edge(one, other, weight=length)
        if back:
            graph.add_edge(other, one, weight=length)

    for a, b in itertools.product(range(w.aisles), range(w.blocks)):
        chain = [("x", a, b), *((a, b, s) for s in range(w.slots)), ("x", a, b + 1)]
        steps = [w.end_gap, *[w.slot_pitch] * (w.slots - 1), w.end_gap]
        open_ = (a, b) not in w.closed_aisles
        on = open_ and (a, b, "front") not in w.one_way_aisles
        back = open_ and (a, b, "back") not in w.one_way_aisles
        for (one, other), step in zip(itertools.pairwise(chain), steps, strict=True):
            join(one, other, step, on, back)
    for c, a in itertools.product(range(w.blocks + 1), range(w.aisles - 1)):
        if (c, a) in w.closed_crossings:
            continue
        on = (c, a, "left") not in w.one_way_crossings
        back = (c, a, "right") not in w.one_way_crossings
        chain, steps = [("x", a, c), ("x", a + 1, c)], [w.aisle_pitch]
        if w.depot_offset and (c, a) == (w.depot_cross_aisle, w.depot_aisle):
            chain.insert(1, "gate")
            steps = [w.depot_offset, w.aisle_pitch - w.depot_offset]
        for (one, other), step in zip(itertools.pairwise(chain), steps, strict=True):
            join(one, other, step, on, back)
    gate = "gate" if w.depot_offset else ("x", w.depot_aisle, w.depot_cross_aisle)
    join("depot", gate, w.depot_distance)
    return graph


@pytest.mark.parametrize("blocks", [1, 2, 3])
def test_distances_and_ways_are_shortest_and_keep_to_the_directions(blocks: int) -> None:
    rng = np.random.default_rng(blocks)
    unequal = cut_off = 0
    for _ in range(CASES):
        w = one_way(rng, blocks)
        slots = list(dict.fromkeys(random_slot(rng, w) for _ in range(6)))
        found, graph = w.distance_matrix(slots), directed(w)
        places = [None, *slots]
        nodes = ["depot", *((s.aisle, s.block, s.slot) for s in slots)]
        for i, node in enumerate(nodes):
            paths = nx.single_source_dijkstra_path_length(graph, node)
            expected = [paths.get(other, math.inf) for other in nodes]
            assert np.allclose(found[i], expected, rtol=0, atol=1e-9), (w, slots)
            for j, far in enumerate(expected):
                if i == j or math.isinf(far):
                    continue
                corners = w.way(places[i], places[j])
                walked = sum(math.dist(a, b) for a, b in itertools.pairwise(corners))
                assert walked == pytest.approx(far, abs=1e-9)
                assert not against(w, corners)
        unequal += not np.array_equal(found, found.T)
        cut_off += bool(np.isinf(found).any())
    assert unequal > CASES / 3
    assert cut_off > CASES / 20


def against(w: AisleWarehouse, corners: list[tuple[float, float]]) -> bool:
    """Return whether a way walks some part against its direction."""
    heights = w.cross_aisle_heights
    for one, other in itertools.pairwise(corners):
        if w.depot_distance and w.depot in (one, other):
            continue  # the depot's own way
        (x0, y0), (x1, y1) = one, other
        for aisle, block, towards in w.one_way_aisles:
            inside = min(max(y0, y1), heights[block + 1]) - max(min(y0, y1), heights[block])
            there = x0 == x1 == aisle * w.aisle_pitch and inside > 1e-9
            if there and (y1 > y0) != (towards == "back"):
                return True
        for cross, aisle, towards in w.one_way_crossings:
            left = aisle * w.aisle_pitch
            inside = min(max(x0, x1), left + w.aisle_pitch) - max(min(x0, x1), left)
            there = y0 == y1 == heights[cross] and inside > 1e-9
            if there and (x1 > x0) != (towards == "right"):
                return True
    return False


@pytest.mark.parametrize("blocks", [1, 2, 3])
def test_tours_are_shortest(blocks: int) -> None:
    """From the depot and back, and between slots."""
    rng = np.random.default_rng(10 + blocks)
    reached = 0
    for case in range(CASES):
        w = one_way(rng, blocks)
        if not w.is_one_way:
            continue
        picks = [random_slot(rng, w) for _ in range(rng.integers(1, 8))]
        start, end = (random_slot(rng, w) if case % 3 == k else None for k in (1, 2))
        ends = [place for place in (start, end) if place is not None]
        d = w.distance_matrix([*picks, *ends])
        first, last = (0 if place is None else len(d) - 1 for place in (start, end))
        rows = [first, *range(1, len(picks) + 1), last]
        expected = shortest_way(d[np.ix_(rows, rows)].tolist())
        tour = Router(w).tour(picks, start=start, end=end)
        assert tour.length == pytest.approx(expected, abs=1e-9), (w, picks, start, end)
        if math.isinf(expected):
            assert tour.sequence == ()
            continue
        reached += 1
        assert tour.is_shortest
        assert sorted(tour.sequence) == list(range(len(picks)))
        stops = [first, *(i + 1 for i in tour.sequence), last]
        assert d[stops[:-1], stops[1:]].sum() == pytest.approx(expected, abs=1e-9)
    assert reached > CASES / 4


def test_a_direction_never_shortens_a_tour_and_a_mirror_changes_nothing() -> None:
    rng = np.random.default_rng(4)
    longer = 0
    for _ in range(CASES):
        w = one_way(rng, int(rng.integers(1, 4)))
        picks = [random_slot(rng, w) for _ in range(rng.integers(1, 7))]
        length = Router(w).length(picks)
        free = dataclasses.replace(w, one_way_aisles=frozenset(), one_way_crossings=frozenset())
        assert Router(free, compiled=False).length(picks) <= length + 1e-9
        longer += Router(free, compiled=False).length(picks) < length - 1e-9
        assert Router(w).length(picks[1:]) <= length + 1e-9
        last = w.aisles - 1
        swapped = {"left": "right", "right": "left"}
        mirrored = dataclasses.replace(
            w,
            depot_aisle=last - w.depot_aisle - (w.depot_offset > 0),
            depot_offset=w.aisle_pitch - w.depot_offset if w.depot_offset else 0.0,
            closed_aisles=frozenset((last - a, b) for a, b in w.closed_aisles),
            closed_crossings=frozenset((c, last - 1 - a) for c, a in w.closed_crossings),
            one_way_aisles=frozenset((last - a, b, t) for a, b, t in w.one_way_aisles),
            one_way_crossings=frozenset(
                (c, last - 1 - a, swapped[t]) for c, a, t in w.one_way_crossings
            ),
        )
        moved = [Slot(last - p.aisle, p.slot, p.block) for p in picks]
        assert Router(mirrored).length(moved) == pytest.approx(length, abs=1e-9)
    assert longer > CASES / 5


def test_fifteen_stops_are_exact_and_more_are_said_not_to_be() -> None:
    """Where a direction is no restriction, the sweep knows the shortest tours of any number."""
    rng = np.random.default_rng(9)
    free = AisleWarehouse(9, 12, 2, depot_aisle=4)
    # Nobody needs to pass this segment but to come home from the first aisle.
    only = dataclasses.replace(free, one_way_crossings=frozenset({(2, 7, "right")}))
    gaps = []
    for count in (15, 15, 25, 40, 60):
        slots = [Slot(a, s, b) for a in range(8) for s in range(12) for b in range(2)]
        picks = [slots[i] for i in rng.choice(len(slots), count, replace=False)]
        tour, shortest = Router(only).tour(picks), Router(free, compiled=False).length(picks)
        assert tour.is_shortest == (count <= 15)
        if tour.is_shortest:
            assert tour.length == pytest.approx(shortest)
        assert tour.length >= shortest - 1e-9
        gaps.append(tour.length / shortest - 1)
    assert max(gaps) < 0.05


def test_all_picks_of_a_one_way_aisle_are_one_stop() -> None:
    rows = frozenset((a, 0, "back" if a % 2 == 0 else "front") for a in range(10))
    w = AisleWarehouse(10, 20, one_way_aisles=rows)
    tour = Router(w).tour([Slot(a, s) for a in range(10) for s in range(20)])
    assert tour.is_shortest
    assert tour.length == 10 * 21 + 2 * 9 * 3
    for a in range(10):
        inside = [i - 20 * a for i in tour.sequence if i // 20 == a]
        assert inside == sorted(range(20), reverse=a % 2 == 1)


def test_what_takes_no_directions_says_so() -> None:
    w = AisleWarehouse(3, 4, one_way_aisles=frozenset({(1, 0, "back")}))
    for policy in POLICIES:
        if policy in ("shortest", "as-given"):
            way = route(w, [Slot(1, 2), Slot(2, 1)], policy)
            assert not any(against(w, list(leg)) for leg in way.legs)
            continue
        with pytest.raises(InputError, match="walked both ways, some are one-way; use shortest"):
            route(w, [Slot(1, 2)], policy)
    with pytest.raises(InputError, match="the sweep over aisles takes no one-way aisles"):
        grid_of(w)
    with pytest.raises(InputError, match="start: along one-way aisles a tour starts and ends at"):
        Router(w).tour([Slot(1, 2)], start=OnCrossAisle(0, 1))
