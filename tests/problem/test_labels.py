"""Labels of bins: written, read, and said by plans, pick lists, schedules and pictures."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from fractions import Fraction
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

import qrobot
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.planning import rank_orders
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot, Stock
from qrobot.problem.formats.native import parse_native, to_text
from qrobot.report import pick_lists, schedule, table

SCHEMA = json.loads((Path(qrobot.__file__).parent / "problem" / "instance.schema.json").read_text())
names = st.text("AB01-é", min_size=1, max_size=9)
goods = st.fixed_dictionaries(
    {},
    optional={
        "label": names,
        "level": st.integers(0, 9),
        "volume": st.integers(0, 9_999).map(lambda n: Fraction(n, 1000)),
        "category": names,
    },
)


@settings(max_examples=60, deadline=None)
@given(instances(min_items=1), st.data())
def test_what_is_written_is_read_again(one: Instance, data: st.DataObject) -> None:
    items = tuple(dataclasses.replace(item, **data.draw(goods)) for item in one.items)
    stock = ()
    if data.draw(st.booleans()):
        bins = data.draw(st.fixed_dictionaries({}, optional={"label": names, "level": st.just(2)}))
        stock = (Stock("nut", items[0].place, 3, **bins),)
    one = dataclasses.replace(one, items=items, stock=stock)
    text = to_text(one)
    jsonschema.Draft202012Validator(SCHEMA).validate(json.loads(text))
    again = parse_native(text)
    assert again == one
    assert again.items == items  # with the fractions of the volumes


def labelled() -> Instance:
    """Two bins above each other, one without a label."""
    items = (
        Item("a", 1, Slot(0, 1), label="A01-02-1", level=1),
        Item("b", 2, Slot(0, 1), label="A01-02-2", level=2),
        Item("c", 3, Slot(1, 2)),
    )
    return Instance(
        AisleWarehouse(aisles=2, slots=4), items, (Order("o", ("a", "b", "c")),), (Robot("R1", 9),)
    )


def test_everything_that_names_a_bin_says_its_label() -> None:
    one = labelled()
    result = qrobot.solve(one, max_work=20)
    label = {item.id: item.label for item in one.items}
    words = {**label, "c": "aisle 1, slot 2, left"}
    (trip,) = result.plan.trips
    assert trip.labels == tuple(label[stop] for stop in trip.stops)
    assert Plan.from_dict(json.loads(json.dumps(result.plan.to_dict()))) == result.plan
    for text in (table(result), " ".join(result.plan.rows()[0])):
        assert "a (A01-02-1)" in text
        assert "b (A01-02-2)" in text
    (only,) = pick_lists(result).lists
    assert [pick.location for pick in only.picks] == [words[stop] for stop in trip.stops]
    rows = list(csv.DictReader(io.StringIO(schedule(result).to_csv())))
    assert [row["location"] for row in rows] == [*(words[stop] for stop in trip.stops), "depot"]


def test_the_animated_page_and_the_floor_say_labels(tmp_path: Path) -> None:
    result = qrobot.solve(labelled(), max_work=20)
    qrobot.plot(result, tmp_path / "x.html")
    assert "A01-02-1: a" in (tmp_path / "x.html").read_text()
    flat = qrobot.read(Path(__file__).parents[2] / "examples" / "three-items.json")
    first = dataclasses.replace(flat.items[0], label="North 7")
    flat = dataclasses.replace(flat, items=(first, *flat.items[1:]))
    pytest.importorskip("matplotlib")
    qrobot.plot(qrobot.solve(flat, max_work=20), tmp_path / "x.svg")
    assert "North 7 (1)" in (tmp_path / "x.svg").read_text()


def test_a_plan_with_the_wrong_labels_is_found_out() -> None:
    one = labelled()
    plan = qrobot.solve(one, max_work=20).plan
    (trip,) = plan.trips
    for wrong in (("A01-02-9", *trip.labels[1:]), tuple(reversed(trip.labels))):
        bad = dataclasses.replace(plan, trips=(dataclasses.replace(trip, labels=wrong),))
        assert {problem.kind for problem in qrobot.check(bad, one).problems} == {"label"}
    unsaid = dataclasses.replace(plan, trips=(dataclasses.replace(trip, labels=()),))
    assert qrobot.check(unsaid, one).ok
    data = plan.to_dict()
    data["trips"][0]["labels"].pop()
    with pytest.raises(InputError, match=r"trips\[0\]\.labels: does not have a label for each"):
        Plan.from_dict(data)


def test_an_article_from_its_stock_has_the_label_of_the_bin_that_it_is_taken_from() -> None:
    near, far = Slot(0, 0), Slot(1, 3)
    stock = (Stock("nut", near, 2, 1, "A-1"), Stock("nut", far, 4, 3, "B-9"))
    item = Item("n", 3, far, quantity=3, article="nut", label="B-9", level=3, volume=6)
    one = Instance(
        AisleWarehouse(aisles=2, slots=4),
        (item, Item("z", 1, near)),
        (Order("o", ("n", "z")),),
        (Robot("R1", 9),),
        stock=stock,
    )
    result = qrobot.solve(one, max_work=200)
    (only,) = pick_lists(result).lists
    bins = {(s.place): (s.label, s.level) for s in stock}
    taken = [pick.item for pick in only.picks if pick.item.article == "nut"]
    assert [(item.label, item.level) for item in taken] == [bins[item.place] for item in taken]
    assert sum(item.volume for item in taken) == 6
    assert sum(item.quantity for item in taken) == 3


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"label": "A\u200b1"}, "items[0].label: holds the invisible character U+200B"),
        ({"category": "a\tb"}, "items[0].category: holds the invisible character U+0009"),
        ({"level": -1}, "items[0].level: level -1 is not 0 to 1000; count the shelves"),
        ({"volume": Fraction(-1, 2)}, "items[0].volume: volume -0.5 of item 'a' is negative"),
    ],
)
def test_what_no_bin_has_is_refused(change: dict[str, object], said: str) -> None:
    one = labelled()
    with pytest.raises(InputError) as caught:
        dataclasses.replace(
            one, items=(dataclasses.replace(one.items[0], **change), *one.items[1:])
        )
    assert str(caught.value).startswith(said)


def test_a_robot_may_stand_at_a_label() -> None:
    one = labelled()
    assert rank_orders(one, "A01-02-2") == rank_orders(one, Slot(0, 1)) == rank_orders(one, "b")
    with pytest.raises(InputError, match=r"at: 'A01-02-9' is not a place here; .*the label of its"):
        rank_orders(one, "A01-02-9")
    named = dataclasses.replace(one.items[2], label="a")  # as another item's id
    both = dataclasses.replace(one, items=(*one.items[:2], named))
    assert rank_orders(both, "a") == rank_orders(one, Slot(0, 1))
