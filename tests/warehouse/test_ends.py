"""Tours from depots with several ways, and from one place to another, on a graph of their own."""

import math
from dataclasses import replace
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from numpy.random import Generator
from tours import random_aisles, random_slot, shortest_way

from qrobot import _jit
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse import OnCrossAisle, Router

CASES = 120

End = Slot | OnCrossAisle | None


def graph_of(w: AisleWarehouse, ends: list[End]) -> nx.Graph:
    """Every slot, crossing and end as a node, at its metres along aisles and cross aisles."""
    graph = nx.Graph()
    inner: dict[tuple[int, int], list[tuple[float, object]]] = {}
    for end in ends:
        if isinstance(end, OnCrossAisle):
            graph.add_node(end)
            inner.setdefault((end.cross_aisle, end.aisle), []).append((end.offset, end))
    gate = w.depot_cross_aisle, w.depot_aisle
    inner.setdefault(gate, []).append((w.depot_offset, "gate"))
    graph.add_edge("depot", "gate", weight=w.depot_distance)
    for aisle, length in w.depot_ways:
        graph.add_edge("depot", (aisle, w.depot_cross_aisle), weight=length)
    for a in range(w.aisles):
        for b in range(w.blocks):
            front, back = w.gaps[b]
            slots = [Slot(a, s, b) for s in range(w.slots)]
            steps = [front, *[w.slot_pitch] * (w.slots - 1), back]
            graph.add_nodes_from(slots)
            if (a, b) not in w.closed_aisles:
                chain = [(a, b), *slots, (a, b + 1)]
                for (one, other), step in zip(pairwise(chain), steps, strict=True):
                    graph.add_edge(one, other, weight=step)
    for c in range(w.blocks + 1):
        for a in range(w.aisles):
            add_segment(graph, w, (a, c), sorted(inner.get((c, a), []), key=lambda spot: spot[0]))
    return graph


def add_segment(
    graph: nx.Graph, w: AisleWarehouse, left: tuple[int, int], spots: list[tuple[float, object]]
) -> None:
    """Add a cross aisle from one crossing to the next, with the places that are on it."""
    a, c = left
    for offset, node in spots:
        if offset == 0:
            graph.add_edge(left, node, weight=0)
    row = [(0.0, left), *(spot for spot in spots if spot[0] > 0), (w.aisle_pitch, (a + 1, c))]
    if a + 1 < w.aisles and (c, a) not in w.closed_crossings:
        for (x, one), (y, other) in pairwise(row):
            graph.add_edge(one, other, weight=y - x)


def way_lengths(w: AisleWarehouse, nodes: list[End]) -> list[list[float]]:
    graph = graph_of(w, nodes)
    names = ["depot" if node is None else node for node in nodes]
    rows = [nx.single_source_dijkstra_path_length(graph, name) for name in names]
    return [[row.get(name, math.inf) for name in names] for row in rows]


def random_layout(rng: Generator, blocks: int) -> AisleWarehouse:
    """Return a layout, in half of the cases with closed parts; depots at a crossing, beside one,
    or with several ways."""
    w = random_aisles(rng, blocks, most=5)
    change: dict[str, object] = {}
    if rng.random() < 0.4:
        change["depot_offset"] = w.aisle_pitch * float(rng.integers(1, 4)) / 4
    elif rng.random() < 0.8:
        others = [a for a in range(w.aisles) if a != w.depot_aisle and rng.random() < 0.7]
        change["depot_ways"] = tuple(
            (a, w.aisle_pitch * abs(a - w.depot_aisle) + float(rng.integers(-1, 2))) for a in others
        )
    try:
        return replace(w, **change)  # type: ignore[arg-type]
    except InputError:  # not between open aisles, or a short cut
        return w


def random_end(rng: Generator, w: AisleWarehouse, picks: list[Slot]) -> End:
    match rng.integers(5):
        case 0:
            return None
        case 1:
            return random_slot(rng, w)
        case 2:
            return replace(picks[0]) if picks else random_slot(rng, w)
        case _:
            aisle = int(rng.integers(w.aisles))
            offset = w.aisle_pitch * float(rng.integers(4)) / 4 * (aisle < w.aisles - 1)
            return OnCrossAisle(int(rng.integers(w.blocks + 1)), aisle, offset)


@pytest.mark.parametrize("blocks", [1, 2, 3, 4])
def test_tours_from_any_depot_are_shortest(blocks: int) -> None:
    rng = np.random.default_rng(100 + blocks)
    several = 0
    for _ in range(CASES):
        w = random_layout(rng, blocks)
        picks = [random_slot(rng, w) for _ in range(rng.integers(1, 7))]
        ways = way_lengths(w, [None, *picks, None])
        expected = shortest_way(ways)
        router = Router(w, compiled=False)
        tour = router.tour(picks)
        assert router.length(picks) == pytest.approx(expected, abs=1e-9), (w, picks)
        assert tour.length == pytest.approx(expected, abs=1e-9), (w, picks)
        if math.isfinite(expected):
            several += len(w.doors) > 1
            assert sorted(tour.sequence) == list(range(len(picks)))
            stops = [0, *(i + 1 for i in tour.sequence), 0]
            walked = sum(ways[a][b] for a, b in pairwise(stops))
            assert walked == pytest.approx(expected, abs=1e-9)
    assert several > CASES / 4


@pytest.mark.parametrize("blocks", [1, 2, 3, 4])
def test_tours_from_place_to_place_are_shortest(blocks: int) -> None:
    rng = np.random.default_rng(200 + blocks)
    reached = 0
    for _ in range(CASES):
        w = random_layout(rng, blocks)
        picks = [random_slot(rng, w) for _ in range(rng.integers(7))]
        if rng.random() < 0.3:  # start, end and picks in one sub-aisle
            picks = [replace(pick, aisle=0, block=0) for pick in picks]
        start, end = random_end(rng, w, picks), random_end(rng, w, picks[::-1])
        ways = way_lengths(w, [start, *picks, end])
        closed = any((pick.aisle, pick.block) in w.closed_aisles for pick in picks)
        expected = math.inf if closed else shortest_way(ways)
        tour = Router(w).tour(picks, start=start, end=end)
        assert tour.length == pytest.approx(expected, abs=1e-9), (w, picks, start, end)
        if math.isfinite(expected):
            reached += 1
            assert sorted(tour.sequence) == list(range(len(picks)))
            stops = [0, *(i + 1 for i in tour.sequence), len(picks) + 1]
            walked = sum(ways[a][b] for a, b in pairwise(stops))
            assert walked == pytest.approx(expected, abs=1e-9), (w, picks, start, end)
    assert reached > CASES / 2


@pytest.mark.skipif(not _jit.available(), reason="numba is not installed")
@pytest.mark.parametrize("blocks", [1, 2, 3])
def test_numba_finds_the_same_lengths_from_any_depot(blocks: int) -> None:
    rng = np.random.default_rng(300 + blocks)
    for _ in range(60):
        w = random_layout(rng, blocks)
        picks = [random_slot(rng, w) for _ in range(rng.integers(1, 7))]
        plain = Router(w, compiled=False).length(picks)
        assert Router(w, compiled=True).length(picks) == pytest.approx(plain, abs=1e-9)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        (OnCrossAisle(0, 3), "aisle"),
        (OnCrossAisle(2, 0), "cross_aisle"),
        (OnCrossAisle(0, 2, 1.0), "aisle"),
        (OnCrossAisle(0, 0, 3.5), "offset"),
        (Slot(0, 9), "slot 9 is outside the layout"),
    ],
)
def test_a_start_outside_the_layout_is_refused(start: End, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Router(AisleWarehouse(3, 3)).tour([Slot(0, 0)], start=start)
