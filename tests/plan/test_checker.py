"""The checker: right plans pass, and every way of breaking one is found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plans import plans, restated

from qrobot.plan import Plan, Trip, check
from qrobot.problem import Instance

Mutation = Callable[[Plan, Instance, Callable[[int], int]], Plan | None]
"""Breaks one property of a plan, or returns None where there is nothing to break."""

MUTATIONS: dict[str, tuple[str, Mutation]] = {}


def breaks(kind: str) -> Callable[[Mutation], Mutation]:
    def register(mutation: Mutation) -> Mutation:
        MUTATIONS[mutation.__name__] = (kind, mutation)
        return mutation

    return register


def with_trip(plan: Plan, index: int, **changes: object) -> Plan:
    trips = list(plan.trips)
    trips[index] = replace(trips[index], **changes)
    return replace(plan, trips=tuple(trips))


def without(stops: Iterable[str], index: int) -> tuple[str, ...]:
    return tuple(s for i, s in enumerate(stops) if i != index)


@breaks("missing")
def one_item_left_behind(plan, instance, pick):
    t = pick(len(plan.trips))
    stops = plan.trips[t].stops
    return restated(with_trip(plan, t, stops=without(stops, pick(len(stops)))), instance)


@breaks("missing")
def a_whole_trip_left_out(plan, instance, pick):
    t = pick(len(plan.trips))
    trips = tuple(trip for i, trip in enumerate(plan.trips) if i != t)
    return restated(replace(plan, trips=trips), instance)


@breaks("repeated")
def one_item_twice_on_one_trip(plan, instance, pick):
    t = pick(len(plan.trips))
    stops = plan.trips[t].stops
    return restated(with_trip(plan, t, stops=(*stops, stops[pick(len(stops))])), instance)


@breaks("repeated")
def one_item_on_two_trips(plan, instance, pick):
    if len(plan.trips) < 2:
        return None
    one, other = plan.trips[0].stops, plan.trips[-1].stops
    return restated(with_trip(plan, 0, stops=(*one, other[pick(len(other))])), instance)


@breaks("unknown")
def an_item_of_nobody(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, stops=(*plan.trips[t].stops, "nobody's"))


@breaks("split")
def an_order_split(plan, instance, pick):
    order_of = {item: order for order in instance.orders for item in order.items}
    if len(plan.trips) < 2:
        return None
    for t, trip in enumerate(plan.trips):
        for s, stop in enumerate(trip.stops):
            if len(order_of[stop].items) > 1:
                to = (t + 1) % len(plan.trips)
                moved = with_trip(plan, t, stops=without(trip.stops, s))
                moved = with_trip(moved, to, stops=(*plan.trips[to].stops, stop))
                return restated(moved, instance)
    return None


@breaks("split")
def a_plan_of_split_orders(plan, instance, pick):
    return replace(plan, split=True)


@breaks("orders")
def an_order_not_listed(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, orders=plan.trips[t].orders[1:])


@breaks("orders")
def an_order_listed_twice(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, orders=(*plan.trips[t].orders, plan.trips[t].orders[0]))


@breaks("orders")
def an_order_listed_that_is_not_collected(plan, instance, pick):
    t = pick(len(plan.trips))
    other = plan.trips[(t + 1) % len(plan.trips)].orders[0] if len(plan.trips) > 1 else "none"
    return with_trip(plan, t, orders=(*plan.trips[t].orders, other))


@breaks("orders")
def an_order_of_another_name(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, orders=(*plan.trips[t].orders[:-1], "another"))


@breaks("load")
def a_load_misstated(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, load=plan.trips[t].load * 1.001 + 0.001)


@breaks("load")
def a_load_that_is_no_number(plan, instance, pick):
    return with_trip(plan, pick(len(plan.trips)), load=math.nan)


@breaks("robot")
def an_unknown_robot(plan, instance, pick):
    return with_trip(plan, pick(len(plan.trips)), robot="stranger")


@breaks("turns")
def one_trip_too_many(plan, instance, pick):
    robot = instance.robots[0]
    if len(plan.trips) <= robot.trips:
        return None
    trips = tuple(replace(t, robot=robot.id) for t in plan.trips)
    return restated(replace(plan, trips=trips), instance)


@breaks("empty")
def an_empty_trip(plan, instance, pick):
    nothing = Trip(instance.robots[0].id, (), (), 0.0, 0.0, 0.0)
    return replace(plan, trips=(*plan.trips, nothing))


@breaks("distance")
def a_trip_shortened(plan, instance, pick):
    t = pick(len(plan.trips))
    if not plan.trips[t].distance:
        return None
    return with_trip(plan, t, distance=plan.trips[t].distance * (1 - 1e-5))


@breaks("distance")
def a_trip_lengthened(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, distance=plan.trips[t].distance * (1 + 1e-5) + 1e-5)


@breaks("distance")
def a_trip_without_end(plan, instance, pick):
    return with_trip(plan, pick(len(plan.trips)), distance=math.inf)


@breaks("distance")
def a_sequence_changed_but_not_its_distance(plan, instance, pick):
    for t, trip in enumerate(plan.trips):
        for i, j in combinations(range(len(trip.stops)), 2):
            stops = list(trip.stops)
            stops[i], stops[j] = stops[j], stops[i]
            changed = with_trip(plan, t, stops=tuple(stops))
            true = restated(changed, instance).trips[t].distance
            if not math.isclose(trip.distance, true, rel_tol=1e-5):
                return changed
    return None


@breaks("time")
def a_driving_time_misstated(plan, instance, pick):
    t = pick(len(plan.trips))
    return with_trip(plan, t, seconds=plan.trips[t].seconds * 1.01 + 0.01)


@breaks("total")
def a_total_shortened(plan, instance, pick):
    return replace(plan, distance=plan.distance * (1 - 1e-5)) if plan.distance else None


@breaks("total")
def a_total_lengthened(plan, instance, pick):
    return replace(plan, distance=plan.distance * (1 + 1e-5) + 1e-5)


@breaks("total")
def a_total_that_is_no_number(plan, instance, pick):
    return replace(plan, distance=math.nan)


@pytest.mark.parametrize("name", MUTATIONS)
@settings(max_examples=40, suppress_health_check=[HealthCheck.filter_too_much])
@given(data=st.data())
def test_every_mutation_is_found(name: str, data: st.DataObject) -> None:
    plan, instance = data.draw(plans(min_items=3, multi_trip=True))
    kind, mutation = MUTATIONS[name]
    mutated = mutation(plan, instance, lambda n: data.draw(st.integers(0, max(n - 1, 0))))
    assume(mutated is not None)
    report = check(mutated, instance)
    assert not report.ok
    assert kind in {p.kind for p in report.problems}


@given(plans(multi_trip=True))
def test_a_right_plan_passes(drawn: tuple[Plan, Instance]) -> None:
    plan, instance = drawn
    report = check(plan, instance)
    assert report.ok, str(report)
    assert report.problems == ()
    assert math.isclose(report.distance, plan.distance, rel_tol=1e-9, abs_tol=1e-9)


@given(plans(multi_trip=True, whole_orders=True))
def test_a_split_instance_allows_split_orders(drawn: tuple[Plan, Instance]) -> None:
    plan, whole = drawn
    instance = whole.split_orders()
    restated_plan = restated(replace(plan, split=True), instance)
    assert check(restated_plan, instance).ok
    assert {p.kind for p in check(plan, instance).problems} <= {"orders"}


@given(plans(min_items=1), st.integers(1, 10**9))
def test_an_overload_however_small_is_found(drawn: tuple[Plan, Instance], divisor: int) -> None:
    plan, instance = drawn
    trip = max(plan.trips, key=lambda t: t.load)
    weight = {item.id: item.weight for item in instance.items}
    load = sum((weight[s] for s in trip.stops), Fraction(0))
    assume(load > 0)

    def held(capacity: Fraction) -> Instance:
        robots = [replace(r, capacity=capacity) for r in instance.robots if r.id == trip.robot]
        rest = [r for r in instance.robots if r.id != trip.robot]
        return replace(instance, robots=(*rest, *robots))

    assert check(plan, held(load)).ok or len(plan.trips) > 1
    overloaded = {p.text for p in check(plan, held(load - load / divisor / 2)).problems}
    assert any(f"robot {trip.robot} holds" in text for text in overloaded)
    assert not any(f"robot {trip.robot} holds" in p.text for p in check(plan, held(load)).problems)
