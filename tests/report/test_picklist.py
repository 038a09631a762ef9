"""Pick lists against the plan and the question, counted again from nothing but them."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

import qrobot
from qrobot.plan import OBJECTIVES, Plan
from qrobot.report import pick_lists

SCHEMA = json.loads((Path(qrobot.__file__).parent / "report" / "picklist.schema.json").read_text())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def planned(instance: qrobot.Instance) -> Plan:
    """Return some plan: as few trips as the sequence of the orders gives."""
    routes: list[list[int]] = [[]]
    room = int(min(instance.capacities))
    for nodes, weight in zip(instance.order_nodes, instance.order_weights, strict=True):
        if sum(int(instance.weights[v - 1]) for v in routes[-1]) + int(weight) > room:
            routes.append([])
        routes[-1] += nodes
    mixed = [sorted(route, key=lambda v: (v * 7) % 5) for route in routes]
    return Plan.from_routes(instance.with_robots(None), mixed, OBJECTIVES["time"])


@st.composite
def questions(draw: st.DrawFn) -> qrobot.Instance:
    one = draw(instances(min_items=1, heterogeneous=False))
    one = replace(
        one,
        items=tuple(
            replace(
                item,
                pick_seconds=draw(st.sampled_from([0.0, 2.5, 8.0])),
                quantity=draw(st.integers(1, 4)),
                article=draw(st.sampled_from(["", "drill"])),
            )
            for item in one.items
        ),
        robots=tuple(
            replace(robot, speed=draw(st.sampled_from([0.5, 1.5]))) for robot in one.robots[:1]
        ),
    )
    return one.with_robots(None)


@settings(max_examples=60, deadline=None)
@given(questions())
def test_every_item_once_in_the_sequence_of_the_plan(instance: qrobot.Instance) -> None:
    plan = planned(instance)
    data = json.loads(pick_lists(plan, instance).to_json())
    VALIDATOR.validate(data)
    document = plan.to_dict()
    items = {item.id: item for item in instance.items}
    order_of = {name: order.id for order in instance.orders for name in order.items}
    assert len(data["trips"]) == len(document["trips"])
    taken = Counter(pick["item"] for trip in data["trips"] for pick in trip["picks"])
    assert taken == Counter(items.keys())
    for number, (trip, of) in enumerate(zip(data["trips"], document["trips"], strict=True), 1):
        assert (trip["trip"], trip["robot"]) == (number, of["robot"])
        assert [pick["item"] for pick in trip["picks"]] == of["stops"]
        assert [pick["stop"] for pick in trip["picks"]] == list(range(1, len(of["stops"]) + 1))
        load = Fraction(0)
        for pick in trip["picks"]:
            item = items[pick["item"]]
            load += item.weight
            assert pick["load"] == float(load)
            assert pick["quantity"] == item.quantity
            assert pick["article"] == (item.article or item.id)
            assert pick["order"] == order_of[item.id]
        assert trip["load"] == float(load) == pytest.approx(of["load"])
        # One basket an order, numbered as they are first needed.
        assert [b["order"] for b in trip["baskets"]] == of["orders"]
        assert [b["basket"] for b in trip["baskets"]] == list(range(1, len(of["orders"]) + 1))
        for basket in trip["baskets"]:
            own = [pick for pick in trip["picks"] if pick["order"] == basket["order"]]
            assert {pick["basket"] for pick in own} == {basket["basket"]}
            assert basket["quantity"] == sum(pick["quantity"] for pick in own)
            assert basket["load"] == pytest.approx(sum(pick["weight"] for pick in own))
    assert sum(trip["seconds"] for trip in data["trips"]) == pytest.approx(plan.cost)
    assert sum(trip["distance"] for trip in data["trips"]) == pytest.approx(plan.distance)


def test_times_are_those_of_a_walk_with_a_watch() -> None:
    warehouse = qrobot.problem.OpenFloor()
    places = (qrobot.problem.Point(3, 4), qrobot.problem.Point(3, 4), qrobot.problem.Point(3, 0))
    instance = qrobot.Instance(
        warehouse,
        tuple(qrobot.Item(f"i{k}", 1, place, k + 1.0) for k, place in enumerate(places)),
        (qrobot.Order("A", ("i0", "i2")), qrobot.Order("B", ("i1",))),
        (qrobot.Robot("R1", 9, speed=0.5),),
    )
    plan = Plan.from_routes(instance, [[1, 2, 3]])
    (one,) = pick_lists(plan, instance).lists
    assert [pick.distance for pick in one.picks] == [5, 5, 9]
    # 5 m at half a metre a second, 1 s and 2 s for the picks; 8 s more to the last one, 3 s there.
    assert [pick.seconds for pick in one.picks] == [11, 13, 24]
    assert one.seconds == 30
    assert [(pick.basket, pick.order) for pick in one.picks] == [(1, "A"), (2, "B"), (1, "A")]


NAMES = st.text(
    st.sampled_from("=+-@'\"<>&;,|/\\{}%# abשלום١漢😀\u0301"), min_size=1, max_size=12
).filter(lambda name: name.strip() != "")


@settings(max_examples=80, deadline=None)
@given(st.lists(NAMES, min_size=3, max_size=3, unique_by=qrobot.problem.checks.canonical), NAMES)
def test_odd_names_come_through_and_are_never_formulas(names: list[str], robot: str) -> None:
    places = [qrobot.problem.Point(k, 0) for k in range(3)]
    instance = qrobot.Instance(
        qrobot.problem.OpenFloor(),
        tuple(qrobot.Item(name, 1, place) for name, place in zip(names, places, strict=True)),
        tuple(qrobot.Order(name, (name,)) for name in names),
        (qrobot.Robot(robot, 9),),
    )
    lists = pick_lists(Plan.from_routes(instance, [[2, 3, 1]]), instance, [robot])
    kept = [instance.items[k].id for k in (1, 2, 0)]
    data = json.loads(lists.to_json())
    assert [pick["article"] for pick in data["trips"][0]["picks"]] == kept
    assert data["trips"][0]["robot"] == instance.robots[0].id
    rows = list(csv.DictReader(io.StringIO(lists.to_csv(), newline="")))
    assert [row["article"].replace("'", "") for row in rows] == [n.replace("'", "") for n in kept]
    for row in rows:
        assert not any(cell.lstrip(' "').startswith(("=", "+", "-", "@")) for cell in row.values())
    assert all(name in lists.to_text() for name in kept)


def test_only_the_robots_that_are_asked_for() -> None:
    instance = qrobot.read(EXAMPLES / "paper-7-items.json")
    result = qrobot.solve(instance)
    both = pick_lists(result)
    assert [one.robot for one in both.lists] == ["R1", "R2"]
    assert pick_lists(result, robots=["R2"]).lists == both.lists[1:]
    with pytest.raises(qrobot.InputError, match="'R3' is not a robot here; use one of: R1, R2"):
        pick_lists(result, robots=["R3"])


def test_a_robot_that_stays_home_has_no_list() -> None:
    instance = qrobot.read(EXAMPLES / "paper-7-items.json").with_robots(3)
    lists = pick_lists(qrobot.solve(instance, max_work=50), robots=["R3"])
    assert lists.lists == ()
    assert lists.to_text() == "no trips\n"
    VALIDATOR.validate(lists.to_dict())


def test_a_robot_of_several_trips_has_a_list_each() -> None:
    instance = qrobot.read(EXAMPLES / "paper-7-items.json")
    instance = replace(instance, robots=(replace(instance.robots[0], trips=2),))
    lists = pick_lists(qrobot.solve(instance)).lists
    assert [(one.robot, one.turn, one.turns) for one in lists] == [("R1", 1, 2), ("R1", 2, 2)]


def test_a_plan_that_is_wrong_has_no_pick_lists() -> None:
    instance = qrobot.read(EXAMPLES / "paper-7-items.json")
    plan = qrobot.solve(instance).plan
    with pytest.raises(
        qrobot.InputError, match=r"not right for this instance: nobody collects items 1, 6, 7"
    ):
        pick_lists(replace(plan, trips=plan.trips[:1]), instance)
    with pytest.raises(qrobot.InputError, match="give its instance too"):
        pick_lists(plan)


def test_the_schema_describes_all_that_is_written() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    data = pick_lists(qrobot.solve(qrobot.read(EXAMPLES / "orders.csv"), max_work=50)).to_dict()
    VALIDATOR.validate(data)
    parts = SCHEMA["$defs"]
    assert set(data) == set(SCHEMA["properties"])
    trip = data["trips"][0]
    assert set(trip) == set(parts["trip"]["properties"])
    assert set(trip["picks"][0]) == set(parts["pick"]["properties"])
    assert set(trip["baskets"][0]) == set(parts["basket"]["properties"])
    del trip["picks"][0]["basket"]
    assert not VALIDATOR.is_valid(data)
