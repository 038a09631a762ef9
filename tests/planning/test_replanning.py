"""Plans in progress: states against a walk with a watch, new plans against what must hold."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning.test_schedules_of_few import jobs

import qrobot
from qrobot.plan import Plan
from qrobot.planning import State, read_state, replan, state_at
from qrobot.planning.state import RobotState
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot, Stock
from qrobot.report import schedule

SCHEMA = json.loads((Path(qrobot.__file__).parent / "planning" / "state.schema.json").read_text())
MORNING = Path(__file__).resolve().parents[2] / "examples" / "morning.json"


def morning() -> tuple[Instance, qrobot.Plan]:
    instance = qrobot.read(MORNING)
    return instance, qrobot.solve(instance, objective="makespan").plan


@settings(deadline=None, max_examples=40)
@given(instance=jobs(), share=st.floats(0, 1.1), lost=st.booleans())
def test_what_is_done_is_what_the_schedule_says(
    instance: Instance, share: float, lost: bool
) -> None:
    try:
        result = qrobot.solve(instance, objective="makespan", max_work=20)
    except qrobot.InfeasibleError:
        return
    assert result.measures is not None
    now = share * result.measures.makespan
    state = state_at(result.plan, instance, now)
    found = schedule(result)
    delivered, on_board = set(), set()
    for own in found.robots:
        for trip in own.trips:
            if trip.ends <= now:
                delivered |= set(trip.journey.trip.orders)
            elif trip.begins <= now:
                on_board |= {
                    item.id
                    for item, visit in zip(trip.journey.items, trip.visits, strict=False)
                    if trip.begins + visit.leaves <= now
                }
    assert set(state.delivered) == delivered
    assert {item for one in state.robots for item in one.picked} == on_board
    robots = state.robots
    if lost:
        robots = (replace(robots[0], lost=True), *robots[1:])
    _holds(replace(state, robots=robots))


def _holds(state: State) -> None:
    """Hold a new plan to the rules, whatever has happened."""
    try:
        found = replan(state, objective="makespan", max_work=5)
    except qrobot.InfeasibleError:
        return
    brought = {order for one in found.finishing for order in state.plan.trips[one.trip - 1].orders}
    planned: set[str] = set()
    if found.result is not None:
        assert qrobot.check(found.result.plan, found.result.instance).ok
        planned = {order for trip in found.result.plan.trips for order in trip.orders}
        assert not planned & (brought | set(state.delivered) | set(state.cancelled))
        lost = {one.robot for one in state.robots if one.lost}
        assert not lost & {trip.robot for trip in found.result.plan.trips}
        first = schedule(found.result)
        assert all(trip.begins >= state.now for own in first.robots for trip in own.trips)
    items = {order.id: set(order.items) for order in state.instance.orders}
    expected = {
        name
        for name, own in items.items()
        if name not in state.cancelled and name not in state.delivered and own - set(state.missing)
    }
    assert expected <= planned | brought
    assert set(found.unchanged) <= set(found.untouched)


@settings(deadline=None, max_examples=25)
@given(data=st.data(), instance=jobs())
def test_whatever_happens_nothing_is_lost(data: st.DataObject, instance: Instance) -> None:
    relaxed = replace(
        instance, orders=tuple(replace(order, deadline=math.inf) for order in instance.orders)
    )
    try:
        result = qrobot.solve(relaxed, objective="makespan", max_work=20)
    except qrobot.InfeasibleError:
        return
    assert result.measures is not None
    now = data.draw(st.floats(0, 1)) * result.measures.makespan
    state = state_at(result.plan, relaxed, now)
    on_board = {item for one in state.robots for item in one.picked}
    ids = [order.id for order in relaxed.orders if order.id not in state.delivered]
    free = [item.id for item in relaxed.items if item.id not in on_board]
    new = Order("new", ("n",), release=data.draw(st.sampled_from([0.0, 500.0])))
    item = replace(relaxed.items[0], id="n", weight=1)
    changed = replace(
        state,
        instance=replace(relaxed, items=(*relaxed.items, item), orders=(*relaxed.orders, new)),
        cancelled=tuple(data.draw(st.sets(st.sampled_from(ids)))) if ids else (),
        missing=tuple(data.draw(st.sets(st.sampled_from(free)))) if free else (),
    )
    _holds(changed)


def test_trips_that_nothing_changes_stay_as_they_were() -> None:
    instance, plan = morning()
    state = state_at(plan, instance, 60.0)
    found = replan(state, objective="makespan", max_work=20)
    assert found.untouched
    assert found.unchanged == found.untouched
    assert not found.changes
    waiting = next(
        order for n, trip in enumerate(plan.trips, 1) if n in found.untouched
        for order in trip.orders
    )  # fmt: skip
    without = replan(replace(state, cancelled=(waiting,)), objective="makespan", max_work=20)
    assert len(without.untouched) == len(found.untouched) - 1


def closing(state: State, *parts: tuple[int, int]) -> State:
    """Return a state in whose warehouse some sub-aisles are closed."""
    house = state.instance.warehouse
    assert isinstance(house, AisleWarehouse)
    blocked = replace(house, closed_aisles=frozenset(parts))
    return replace(state, instance=replace(state.instance, warehouse=blocked))


def in_three_aisles(**of_robot: Any) -> Instance:
    """Return an order in each of three aisles, and a robot that carries one of them."""
    items = tuple(Item(f"i{k}", 1, Slot(k, 3)) for k in range(3))
    orders = tuple(Order(f"o{k}", (f"i{k}",)) for k in range(3))
    house = AisleWarehouse(4, 6, 2, aisle_pitch=3.0, end_gap=1.0)
    return Instance(house, items, orders, (Robot("R", 1, trips=5, **of_robot),))


def test_orders_behind_a_blocked_aisle_wait_and_the_rest_is_planned(tmp_path: Path) -> None:
    instance = in_three_aisles(available=1.0)
    plan = qrobot.solve(instance).plan
    state = closing(state_at(plan, instance, 0.0), (1, 0))
    state.save(tmp_path / "state.json")
    found = replan(read_state(tmp_path / "state.json"), max_work=5)
    assert "order o1 has to wait: no way leads to i1" in found.changes
    assert found.result is not None
    assert {o for trip in found.result.plan.trips for o in trip.orders} == {"o0", "o2"}
    assert qrobot.check(found.result.plan, found.result.instance).ok


def test_a_robot_under_way_goes_around_a_blocked_aisle_or_comes_home_without() -> None:
    instance = in_three_aisles()
    instance = replace(instance, robots=(Robot("R", 3),))
    result = qrobot.solve(instance)
    state = state_at(result.plan, instance, 0.0)
    as_planned = replan(state).finishing[0]
    assert as_planned.back == pytest.approx(result.plan.distance)
    (trip,) = result.plan.trips
    around = replan(closing(state, (3, 0))).finishing[0]
    assert around == as_planned  # nothing of its way is closed
    without = replan(closing(state, (1, 0)))
    assert set(without.finishing[0].stops) == set(trip.stops) - {"i1"}
    assert "no way leads to i1: robot R comes home without" in without.changes
    # Two picks 4 m deep in aisles 0 and 2, or twice through the block: the shorter way.
    assert without.finishing[0].back == pytest.approx(2 * 6.0 + min(4 * 4.0, 2 * 7.0))


def test_a_robot_in_a_blocked_aisle_must_be_marked() -> None:
    instance = replace(in_three_aisles(), robots=(Robot("R", 3),))
    result = qrobot.solve(instance)
    state = state_at(result.plan, instance, 0.0)
    (trip,) = result.plan.trips
    inside = replace(state, robots=(replace(state.robots[0], picked=trip.stops[:1]),))
    aisle = int(trip.stops[0][1:])
    with pytest.raises(qrobot.InputError, match=r"no way leads robot R home.*mark it as lost"):
        replan(closing(inside, (aisle, 0)))


def test_old_trips_that_the_robots_cannot_make_are_planned_anew() -> None:
    """Each old trip and the new order would be a trip of A, which may make two."""
    house = AisleWarehouse(3, 4)
    items = tuple(Item(f"i{k}", w, Slot(k, 2)) for k, w in enumerate((6, 6, 3)))
    orders = tuple(Order(f"o{k}", (f"i{k}",)) for k in range(3))
    fleet = (Robot("A", 10, trips=2, available=5.0), Robot("B", 1, trips=9, available=5.0))
    old = Instance(house, items[:2], orders[:2], fleet)
    state = state_at(qrobot.solve(old).plan, old, 0.0)
    found = replan(replace(state, instance=replace(old, items=items, orders=orders)), max_work=5)
    assert found.result is not None
    assert qrobot.check(found.result.plan, found.result.instance).ok
    assert "planned anew" in found.changes[-1]


def test_many_orders_are_planned_anew_by_the_usual_search() -> None:
    """Every order was a trip of a robot that has broken down; the other may make two trips."""
    items = tuple(Item(f"i{k}", 1, Slot(k % 3, k % 4)) for k in range(20))
    orders = tuple(Order(f"o{k}", (f"i{k}",)) for k in range(20))
    fleet = (Robot("A", 1, trips=20, available=5.0), Robot("B", 10, trips=2, available=5.0))
    instance = Instance(AisleWarehouse(3, 4), items, orders, fleet)
    plan = Plan.from_routes(replace(instance, robots=fleet[:1]), [[k] for k in range(1, 21)])
    state = state_at(plan, instance, 0.0)
    lost = replace(state, robots=(replace(state.robots[0], lost=True), state.robots[1]))
    for objective in ("distance", "makespan"):
        found = replan(lost, objective=objective, max_work=30)
        assert found.result is not None
        assert {trip.robot for trip in found.result.plan.trips} == {"B"}
        assert qrobot.check(found.result.plan, found.result.instance).ok


def test_a_plan_whose_places_were_chosen_can_be_replanned() -> None:
    items = tuple(Item(f"i{k}", 1, Slot(k, 2), article="nut") for k in range(3))
    orders = tuple(Order(f"o{k}", (f"i{k}",), due=50.0) for k in range(3))
    stock = (*(Stock("nut", Slot(k, 2), 1) for k in range(3)), Stock("nut", Slot(0, 0), 3))
    fleet = (Robot("R", 2, trips=5, available=1.0),)
    instance = Instance(AisleWarehouse(3, 4), items, orders, fleet, stock=stock)
    result = qrobot.solve(instance)
    assert result.plan.picks
    assert [order.due for order in result.instance.orders] == [50.0] * 3
    found = replan(state_at(result.plan, instance, 0.0), max_work=5)
    assert found.result is not None
    assert qrobot.check(found.result.plan, found.result.instance).ok
    assert found.unchanged == found.untouched


def test_a_state_comes_back_from_its_file(tmp_path: Path) -> None:
    instance, plan = morning()
    state = replace(state_at(plan, instance, 100.0), cancelled=("G",), missing=("H1",))
    state.save(tmp_path / "state.json")
    jsonschema.Draft202012Validator(SCHEMA).validate(
        json.loads((tmp_path / "state.json").read_text())
    )
    assert read_state(tmp_path / "state.json") == state


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"now": -1}, "now"),
        ({"now": "soon"}, "now"),
        ({"cancelled": ["nobody"]}, r"cancelled\[0\]"),
        ({"missing": "H1"}, "missing"),
        ({"cancelled": ["A"], "delivered": ["A"]}, r"cancelled\[0\]"),
        ({"robots": [{"robot": "R9"}]}, r"robots\[0\]"),
        ({"robots": [{"robot": "R1"}, {"robot": "R1"}]}, r"robots\[1\]"),
        ({"robots": [{"robot": "R1", "trip": 99}]}, r"robots\[0\]\.trip"),
        ({"robots": [{"robot": "R1", "picked": ["A1"]}]}, r"robots\[0\]\.picked"),
        ({"robots": [{"robot": "R1", "lost": "yes"}]}, r"robots\[0\]\.lost"),
        ({"schema": "qrobot.plan/1"}, "schema"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_a_state_that_cannot_be_is_refused(
    tmp_path: Path, change: dict[str, Any], place: str
) -> None:
    instance, plan = morning()
    path = tmp_path / "state.json"
    state_at(plan, instance, 60.0).save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(qrobot.InputError, match=rf"state\.json.*{place}"):
        read_state(path)


def test_an_item_on_board_of_the_wrong_robot_is_refused() -> None:
    instance, plan = morning()
    other = next(trip for trip in plan.trips if trip.robot != plan.trips[0].robot)
    with pytest.raises(qrobot.InputError, match="is not on trip 1"):
        State(
            instance, plan, 1.0,
            robots=(RobotState(plan.trips[0].robot, 1, (other.stops[0],)),),
        )  # fmt: skip
    with pytest.raises(qrobot.InputError, match="delivered and still under way"):
        State(
            instance, plan, 1.0, delivered=(plan.trips[0].orders[0],),
            robots=(RobotState(plan.trips[0].robot, 1),),
        )  # fmt: skip
