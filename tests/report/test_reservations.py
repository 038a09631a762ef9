"""Robots in narrow aisles: nobody meets, and time is lost only by waiting."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.plan import Plan
from qrobot.problem import AisleWarehouse, Instance, Item, OpenFloor, Order, Point, Robot, Slot
from qrobot.problem import Times as Seconds
from qrobot.report import schedule


@st.composite
def crowds(draw: st.DrawFn) -> tuple[Instance, Plan]:
    """Return many trips in few aisles, by several robots."""
    blocks = draw(st.integers(1, 3))
    house = AisleWarehouse(
        3, 5, blocks, aisle_pitch=3.0, end_gap=1.5,
        depot_distance=draw(st.sampled_from([0.0, 2.0])), depot_aisle=draw(st.integers(0, 2)),
    )  # fmt: skip
    places = st.builds(Slot, st.integers(0, 2), st.integers(0, 4), st.integers(0, blocks - 1))
    count = draw(st.integers(2, 14))
    items = tuple(
        Item(f"i{k}", 1, draw(places), pick_seconds=draw(st.sampled_from([0.0, 4.0, 30.0])))
        for k in range(count)
    )
    orders = tuple(
        Order(item.id, (item.id,), release=draw(st.sampled_from([0.0, 0.0, 20.0])))
        for item in items
    )
    robots = tuple(
        Robot(f"R{r}", 3, draw(st.sampled_from([0.7, 1.0, 1.6])), 20)
        for r in range(draw(st.integers(2, 5)))
    )
    times = Seconds(per_trip=draw(st.sampled_from([0.0, 5.0])))
    instance = Instance(house, items, orders, robots, times=times)
    return instance, qrobot.solve(instance, backend="fcfs", max_work=1).plan


@settings(max_examples=40, deadline=None)
@given(crowds(), st.integers(1, 2))
def test_no_more_robots_than_may_be_are_in_a_sub_aisle(
    crowd: tuple[Instance, Plan], most: int
) -> None:
    instance, plan = crowd
    found = schedule(plan, instance, per_aisle=most)
    free = schedule(plan, instance)
    house = instance.warehouse
    assert isinstance(house, AisleWarehouse)
    stays = defaultdict(list)
    for own, alone in zip(found.robots, free.robots, strict=True):
        for trip, easy in zip(own.trips, alone.trips, strict=True):
            # What a trip takes longer than without others is what it waits.
            assert trip.ends - trip.begins == pytest.approx(easy.ends - easy.begins + trip.waiting)
            assert trip.waiting >= -1e-9
            assert trip.visits[-1].distance == pytest.approx(easy.visits[-1].distance)
            for item, visit in zip(trip.journey.items, trip.visits, strict=False):
                # The robot stands at a slot while it is in its sub-aisle.
                place = item.place
                assert isinstance(place, Slot)
                assert any(
                    (stay.aisle, stay.block) == (place.aisle, place.block)
                    and stay.enters <= trip.begins + visit.arrives + 1e-9
                    and trip.begins + visit.leaves <= stay.leaves + 1e-9
                    for stay in trip.inside
                )
            for stay in trip.inside:
                stays[stay.aisle, stay.block].append((stay.enters, stay.leaves))
                assert stay.leaves - stay.enters >= 0
            # Stays take no less than the metres inside the aisles at the robot's speed.
            driven = sum(stay.leaves - stay.enters for stay in trip.inside) - trip.collecting
            inside = sum(
                abs(max(v, 0.0) - max(y, 0.0))  # the depot may stand in front of its aisle
                for leg in trip.journey.legs
                for (x, y), (u, v) in pairwise(leg)
                if x == u
            )
            assert driven == pytest.approx(inside / trip.journey.robot.speed)
        for before, after in pairwise(own.trips):
            assert after.begins >= before.ends - 1e-9
    for times in stays.values():
        for moment in sorted(enters for enters, _ in times):
            there = sum(a <= moment + 1e-9 and moment + 2e-9 < b for a, b in times)
            assert there <= most
    assert found.ends >= free.ends - 1e-9
    assert found.undisturbed == pytest.approx(free.ends)


def test_two_robots_wait_for_each_other_at_the_crossing() -> None:
    house = AisleWarehouse(2, 4, aisle_pitch=3.0, end_gap=1.0)
    items = (Item("a", 1, Slot(0, 3), 10.0), Item("b", 1, Slot(0, 0), 10.0))
    orders = (Order("A", ("a",)), Order("B", ("b",)))
    instance = Instance(house, items, orders, (Robot("R1", 1), Robot("R2", 1)))
    plan = Plan.from_routes(instance, [[1], [2]])
    found = schedule(plan, instance, per_aisle=1)
    # R1 is 4 m in, picks, and is back after 18 s; R2 waits so long, then takes 1 + 10 + 1 s.
    assert [own.ends for own in found.robots] == [18.0, 30.0]
    assert [own.trips[0].waiting for own in found.robots] == [0.0, 18.0]
    assert "robots wait 18 s, the last is back 12 s later" in found.to_text()
    assert schedule(plan, instance, per_aisle=2).ends == 18.0


def test_where_there_are_no_aisles_it_is_refused() -> None:
    items = (Item("a", 1, Point(1, 1)),)
    instance = Instance(OpenFloor(), items, (Order("A", ("a",)),), (Robot("R1", 1),))
    plan = Plan.from_routes(instance, [[1]])
    with pytest.raises(qrobot.InputError, match="no aisles"):
        schedule(plan, instance, per_aisle=1)
    house = replace(instance, warehouse=AisleWarehouse(2, 4), items=(Item("a", 1, Slot(0, 1)),))
    with pytest.raises(qrobot.InputError, match="below 1"):
        schedule(Plan.from_routes(house, [[1]]), house, per_aisle=0)
