"""Lanes: no way hides another, and every way still passes its stops."""

from __future__ import annotations

import math
from itertools import combinations, pairwise

import pytest
from hypothesis import given, settings
from plans import plans

from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Instance, Slot
from qrobot.report.labels import placed, spread
from qrobot.report.lanes import XY, Lanes, rounded

WIDE = (100.0, 100.0)


def segment_distance(at: XY, a: XY, b: XY) -> float:
    length = math.dist(a, b)
    if length == 0:
        return math.dist(at, a)
    t = ((at[0] - a[0]) * (b[0] - a[0]) + (at[1] - a[1]) * (b[1] - a[1])) / length**2
    t = min(1.0, max(0.0, t))
    return math.dist(at, (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))


def distance_to_line(at: XY, corners: list[XY]) -> float:
    if len(corners) == 1:
        return math.dist(at, corners[0])
    return min(segment_distance(at, a, b) for a, b in pairwise(corners))


def test_a_way_by_itself_runs_in_the_middle() -> None:
    way = [[(0, 0), (0, 5), (3, 5)], [(3, 5), (3, 0), (0, 0)]]
    (line,) = Lanes([way], margin=0.1).lines(step=1, widths=WIDE)
    assert line.corners == [(0, 0), (0, 5), (3, 5), (3, 0), (0, 0)]
    assert line.stops == [(3, 5)]


def test_in_and_back_out_are_two_lanes() -> None:
    (line,) = Lanes([[[(0, 0), (0, 5)], [(0, 5), (0, 0)]]], margin=0.1).lines(step=1, widths=WIDE)
    assert sorted(x for x, _ in line.corners) == [-0.5, -0.5, 0.5, 0.5]
    assert line.stops == [(0, 5)]  # the middle of the turn


def test_two_trips_on_one_aisle_are_two_lanes_as_wide_as_there_is_room() -> None:
    way = [[(0, 0), (0, 9)], [(0, 9), (4, 9)]]
    lanes = Lanes([way, way, way], margin=0.1)
    assert lanes.widest_gap((3.0, 6.0)) == 1.0
    xs = sorted(line.corners[0][0] for line in lanes.lines(step=1, widths=(3, 1.5)))
    assert xs == [-0.5, 0.0, 0.5]


def test_ways_that_never_meet_share_the_middle() -> None:
    first = [[(0, 0), (0, 4)], [(0, 4), (3, 4)]]
    second = [[(0, 6), (0, 9)], [(0, 9), (3, 9)]]
    lines = Lanes([first, second], margin=1).lines(step=1, widths=WIDE)
    assert [line.corners[0][0] for line in lines] == [0, 0]


def test_a_trip_that_never_leaves_the_depot() -> None:
    here = [(2.0, 2.0)]
    (line,) = Lanes([[here, here, here]], margin=1).lines(step=1, widths=WIDE)
    assert line.corners == here
    assert line.stops == [*here, *here]
    assert rounded(line.corners, 1) == [("move", (2.0, 2.0))]


def legs_of(plan: Plan, instance: Instance) -> list[list[list[XY]]]:
    place = {item.id: item.place for item in instance.items}
    found = []
    for trip in plan.trips:
        places = [None, *(place[s] for s in trip.stops), None]
        found.append([instance.warehouse.way(a, b) for a, b in pairwise(places)])
    return found


def test_a_slanting_way_from_the_depot_leads_past_its_stop() -> None:
    """A further way of the depot, to the crossing of another aisle, and back the same way."""
    way = [[(0.25, -0.5), (0.0, 0.0), (0.0, 0.25)], [(0.0, 0.25), (0.0, 0.0), (0.25, -0.5)]]
    (line,) = Lanes([way], margin=1e-6).lines(step=1e-3, widths=WIDE)
    (stop,) = line.stops
    assert math.dist(stop, (0.0, 0.25)) < 0.01
    assert all(math.dist(end, (0.25, -0.5)) < 0.01 for end in (line.corners[0], line.corners[-1]))


@settings(max_examples=60)
@given(plans(min_items=1, max_items=9, kinds=["aisles"], multi_trip=True))
def test_lines_pass_their_stops_and_no_line_hides_another(drawn: tuple[Plan, Instance]) -> None:
    plan, instance = drawn
    layout = instance.warehouse
    assert isinstance(layout, AisleWarehouse)
    place = {item.id: item.place for item in instance.items}
    lines = Lanes(legs_of(plan, instance), margin=1e-6).lines(step=1e-3, widths=WIDE)
    for trip, line in zip(plan.trips, lines, strict=True):
        assert len(line.stops) == len(trip.stops)
        for stop, at in zip(trip.stops, line.stops, strict=True):
            slot = place[stop]
            assert isinstance(slot, Slot)
            assert math.dist(at, layout.position(slot)) < 0.1
            assert distance_to_line(at, line.corners) < 1e-9
    segments = [s for line in lines for s in pairwise(line.corners)]
    for (a, b), (c, d) in combinations(segments, 2):
        for axis in (0, 1):  # axis: across; the other one: along
            if a[axis] == b[axis] == c[axis] == d[axis]:
                low = max(min(a[1 - axis], b[1 - axis]), min(c[1 - axis], d[1 - axis]))
                high = min(max(a[1 - axis], b[1 - axis]), max(c[1 - axis], d[1 - axis]))
                assert high - low < 0.1  # they touch at a turn at most


def test_corners_are_rounded_but_not_past_the_middle_of_a_side() -> None:
    steps = rounded([(0, 0), (0, 1), (10, 1)], radius=2)
    assert steps == [
        ("move", (0, 0)),
        ("line", (0, 0.5)),
        ("control", (0, 1)),
        ("curve", (0.5, 1)),
        ("line", (10, 1)),
    ]


def test_points_that_coincide_are_spread() -> None:
    assert spread([(0, 0), (5, 5), (0, 0)], gap=2) == [(-1, 0), (5, 5), (1, 0)]
    assert len(set(spread([(1, 1)] * 7, gap=1))) == 7


@pytest.mark.parametrize(("way", "side"), [([(0, 0), (90, 0)], "right"), ([], "left")])
def test_a_label_stands_where_no_way_runs(way: list[XY], side: str) -> None:
    ((offset, across, _),) = placed([(0, 0)], [(20, 8)], 5, [((0, 0), 5)], [way] if way else [])
    assert across == side  # the side of the text that is set at the point
    assert (offset[0] < 0) == (side == "right")
