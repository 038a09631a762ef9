"""Native JSON: what is read and written, and round trips."""

from __future__ import annotations

import json
import tempfile
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from native_documents import GOOD, changed, json_values, matrix, read, sentence
from strategies import instances

import qrobot
from qrobot.errors import InputError
from qrobot.problem import DistanceTable, Instance, Item, Node, OpenFloor, Order, Point, Robot
from qrobot.problem.formats.jsontext import dumps, loads
from qrobot.problem.formats.native import to_text
from qrobot.problem.formats.schema import SCHEMA, Document


def test_reads_every_field(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    assert one.warehouse.kind == "aisles"
    assert one.warehouse.closed_aisles == frozenset({(2, 1)})
    assert one.warehouse.closed_crossings == frozenset({(0, 1)})
    assert one.warehouse.one_way_aisles == frozenset({(1, 0, "back")})
    assert one.warehouse.one_way_crossings == frozenset({(1, 0, "left")})
    assert one.warehouse.end_gap == 1.5
    assert [i.weight for i in one.items] == [Fraction(1, 10), Fraction(3)]
    assert [(r.id, r.capacity, r.speed) for r in one.robots] == [
        ("R1", Fraction(31, 2), 1.2),
        ("R2", Fraction(31, 2), 1.2),
    ]
    assert one.orders == (Order("o", ("a", "b")),)
    assert one.name == "instance"


def test_without_orders_every_item_is_its_own(tmp_path: Path) -> None:
    one = read(tmp_path, changed("orders", ...))
    assert one.orders == (Order("a", ("a",)), Order("b", ("b",)))


def test_no_items_are_an_empty_instance(tmp_path: Path) -> None:
    one = read(tmp_path, changed("items", []) | {"orders": []})
    assert one.size == 0
    assert one.distances.tolist() == [[0]]


def test_overrides(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD, robots=3, capacity="7.25", split_orders=True)
    assert [(r.id, r.capacity) for r in one.robots] == [
        (f"R{k}", Fraction(29, 4)) for k in (1, 2, 3)
    ]
    assert len(one.orders) == 2
    assert one.split
    assert len(read(tmp_path, GOOD, robots="free").robots) == 1
    for wrong in (0, -1, "many", True, 2.5):
        assert "robots" in sentence(tmp_path, GOOD, robots=wrong)
    for wrong in (0, "-1", "much", float("nan")):
        assert sentence(tmp_path, GOOD, capacity=wrong).startswith("capacity: ")
    assert "a layout belongs to CSV" in sentence(tmp_path, GOOD, layout="layout.json")


@pytest.mark.parametrize(
    "robots",
    [
        [{"id": "big", "capacity": 9, "trips": 2}, {"id": "small", "capacity": 1.5, "speed": 0.5}],
        {"count": 1, "capacity": 2},
    ],
)
def test_fleets_in_both_notations(tmp_path: Path, robots: object) -> None:
    one = read(tmp_path, changed("robots", robots))
    qrobot.write(one, tmp_path / "again.json")
    assert qrobot.read(tmp_path / "again.json").robots == one.robots


def test_a_matrix_may_have_gaps_where_nothing_is_collected(tmp_path: Path) -> None:
    one = read(tmp_path, matrix([[0, 2, None], [3, None, None], [None, None, 0]]))
    assert one.distances.tolist() == [[0, 2], [3, 0]]
    assert one.notes == ("the distances are asymmetric: depot to a is 2, back 3",)
    qrobot.write(one, tmp_path / "again.json")
    assert "null" in (tmp_path / "again.json").read_text()
    assert qrobot.read(tmp_path / "again.json") == one


def test_digits_are_kept(tmp_path: Path) -> None:
    text = json.dumps(GOOD).replace("0.1,", "0.1234567890123456789012,", 1)
    weight = Fraction("0.1234567890123456789012")
    from qrobot.problem.formats.native import parse_native

    # Beside a weight of nothing, any number of digits is one unit.
    (tmp_path / "x.json").write_text(text.replace('"weight": 3', '"weight": 0'))
    one = parse_native((tmp_path / "x.json").read_text())
    assert one.items[0].weight == weight
    assert '"weight": 0.1234567890123456789012' in to_text(one)
    assert "round the weights up" in sentence(tmp_path, text)


def test_a_third_cannot_be_written(tmp_path: Path) -> None:
    item = Item("a", Fraction(1, 3), Point(0, 0))
    one = Instance(OpenFloor(), (item,), (Order("a", ("a",)),), (Robot("R1", Fraction(1)),))
    with pytest.raises(InputError, match=r"items\[0\]\.weight: 1/3 has no finite decimal; round"):
        qrobot.write(one, tmp_path / "x.json")
    assert not list(tmp_path.iterdir())


def test_both_sides_mean_the_same_schema() -> None:
    assert Document.model_fields["schema_"].annotation.__args__[0] == SCHEMA


def test_coordinates_of_a_table_survive(tmp_path: Path) -> None:
    table = DistanceTable(((0, 1), (1, 0)), 1, ((0.5, 1), (2, 3)))
    item = Item("a", Fraction(1), Node(0))
    one = Instance(table, (item,), (Order("a", ("a",)),), (Robot("R1", Fraction(1)),))
    qrobot.write(one, tmp_path / "x.json")
    assert qrobot.read(tmp_path / "x.json") == one


@settings(max_examples=150, deadline=None)
@given(instances(multi_trip=True))
def test_what_is_written_is_read_again(one: Instance) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.json"
        qrobot.write(one, path)
        again = qrobot.read(path)
        assert again == one
        assert to_text(again) == path.read_text()
        json.loads(path.read_text())


@given(json_values)
def test_the_writer_writes_json(value: object) -> None:
    assert json.loads(dumps(value)) == value


@given(st.decimals(-1000, 1000, places=20))
def test_the_writer_keeps_decimals(value: Decimal) -> None:
    assert loads(dumps([value]))[0] == value
