"""Native JSON: round trips, and one sentence for every fault."""

from __future__ import annotations

import copy
import json
import tempfile
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import instances

import qrobot
from qrobot.errors import InputError
from qrobot.problem import DistanceTable, Instance, Item, Node, OpenFloor, Order, Point, Robot
from qrobot.problem.formats.jsontext import dumps, loads
from qrobot.problem.formats.native_writer import SCHEMA as WRITTEN
from qrobot.problem.formats.native_writer import to_text
from qrobot.problem.formats.schema import SCHEMA, Document

GOOD: dict[str, Any] = {
    "schema": "qrobot.instance/1",
    "warehouse": {
        "kind": "aisles",
        "aisles": 3,
        "blocks": 2,
        "slots": 4,
        "aisle_pitch": 3,
        "slot_pitch": 1,
        "end_gap": 1.5,
        "depot": {"aisle": 0, "cross_aisle": 0, "distance": 0},
        "closed_aisles": [{"aisle": 2, "block": 1}],
        "closed_crossings": [{"cross_aisle": 0, "aisle": 1}],
    },
    "robots": {"count": 2, "capacity": 15.5, "speed": 1.2, "trips": 1},
    "items": [
        {"id": "a", "weight": 0.1, "at": {"aisle": 0, "block": 1, "slot": 2, "side": "right"}},
        {"id": "b", "weight": 3, "at": {"aisle": 1, "slot": 3}},
    ],
    "orders": [{"id": "o", "items": ["a", "b"]}],
}


def read(folder: Path, document: object, name: str = "x.json", **options: Any) -> Instance:
    text = document if isinstance(document, str) else json.dumps(document)
    (folder / name).write_text(text, encoding="utf-8")
    return qrobot.read(folder / name, **options)


def sentence(folder: Path, document: object, **options: Any) -> str:
    """Return the error, without the file's name that it must begin with."""
    with pytest.raises(InputError) as caught:
        read(folder, document, **options)
    text = str(caught.value)
    path = f"{folder / 'x.json'}: "
    assert text.startswith(path)
    assert "; " in text
    assert "\n" not in text
    assert len(text) < len(path) + 300
    return text.removeprefix(path)


def changed(path: str, value: object) -> dict[str, Any]:
    """Return the good document with one field set, or removed with ``...``."""
    document = copy.deepcopy(GOOD)
    *parents, last = [int(p) if p.isdigit() else p for p in path.split(".")]
    target: Any = document
    for part in parents:
        target = target[part]
    if value is ...:
        del target[last]
    else:
        target[last] = value
    return document


def test_reads_every_field(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    assert one.warehouse.kind == "aisles"
    assert one.warehouse.closed_aisles == frozenset({(2, 1)})
    assert one.warehouse.closed_crossings == frozenset({(0, 1)})
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


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (
            "schema",
            "qrobot.instance/9",
            'schema: unknown schema "qrobot.instance/9"; this version ',
        ),
        ("schema", 1, "schema: unknown schema 1; this version reads 'qrobot.instance/1'"),
        ("schema", ..., "schema: is missing; this version reads 'qrobot.instance/1'"),
        ("schema", "qrobot.plan/1", "schema: this is a plan (qrobot.plan/1), not an instance"),
        ("warehouse", ..., "warehouse: is missing; add it"),
        (
            "warehouse",
            [],
            "warehouse: an empty list is not known; give 'aisles', 'floor' or 'matrix'",
        ),
        ("warehouse.kind", "hall", "warehouse.kind: \"hall\" is not known; give 'aisles'"),
        ("warehouse.kind", ..., "warehouse.kind: null is not known; give"),
        ("warehouse.aisles", ..., "warehouse.aisles: is missing; add it"),
        ("warehouse.aisles", 0, "warehouse.aisles: 0 is not right; needed: greater than or equal"),
        ("warehouse.aisles", 10**9, "warehouse.aisles: 1000000000 is not 1 to 4000"),
        ("warehouse.aisles", 2.5, "warehouse.aisles: 2.5 is not right; needed: a whole number"),
        ("warehouse.aisles", True, "warehouse.aisles: true is not right; needed: a whole number"),
        ("warehouse.aisles", "3", 'warehouse.aisles: "3" is not right; needed: a whole number'),
        ("warehouse.aisle_pitch", "3", 'warehouse.aisle_pitch: "3" is not a number; give'),
        ("warehouse.aisle_pitch", True, "warehouse.aisle_pitch: true is not a number"),
        ("warehouse.aisle_pitch", 0, "warehouse.aisle_pitch: 0.0 is not right; needed: greater"),
        ("warehouse.aisle_pich", 3, "warehouse.aisle_pich: is not a known field; did you mean 'ai"),
        ("warehouse.qqq", 3, "warehouse.qqq: is not a known field; known are kind, aisles"),
        ("warehouse.depot.aisle", 3, "warehouse.depot.aisle: 3 is outside the layout; use 0 to 2"),
        ("warehouse.depot.distance", -1, "warehouse.depot.distance: -1.0 is not right; needed: gr"),
        ("warehouse.closed_aisles.0.block", 2, "warehouse.closed_aisles[].block: 2 is outside"),
        ("robots", 3, "robots: 3 is not a fleet; give count and capacity, or a list of robots"),
        ("robots", [], "robots: an empty list is not right; needed: more entries"),
        ("robots.count", 0, "robots.count: 0 is not right; needed: greater than or equal to 1"),
        ("robots.count", 10**6, "robots.count: 1000000 robots are more than 20000; give fewer"),
        ("robots.capacity", 0, "robots.capacity: capacity 0 of robot 'R1' is not positive; use"),
        ("robots.capacity", ..., "robots.capacity: is missing; add it"),
        ("robots.capactiy", 3, "robots.capactiy: is not a known field; did you mean 'capacity'?"),
        ("robots.speed", 0, "robots.speed: 0.0 is not right; needed: greater than 0"),
        ("items", ..., "items: is missing (a document without items is a layout); add the items"),
        ("items", {}, "items: an object is not right; needed: a list"),
        ("items.0", 7, "items[0]: 7 is not right; needed: an object"),
        ("items.0.id", 7, "items[0].id: 7 is not right; needed: text"),
        ("items.0.id", "", 'items[0].id: "" is not right; needed: at least 1 letter'),
        ("items.0.id", "a\x1b[31m", "items[0].id: "),
        ("items.0.id", "x" * 201, "items[0].id: "),
        ("items.0.id", "\ud800", "items[0].id: "),
        ("items.1.id", "a", "items[1].id: the id 'a' is used twice; give each an id of its own"),
        ("items.0.weight", -1, "items[0].weight: weight -1 of item 'a' is negative; use zero"),
        ("items.0.weight", "8 kg", 'items[0].weight: "8 kg" is not a number; give a plain number'),
        ("items.0.weight", None, "items[0].weight: null is not a number; give a plain number"),
        ("items.0.weight", False, "items[0].weight: false is not a number; give a plain number"),
        ("items.0.weight", 10**13, "items[0].weight: 10000000000000 is larger than 1e+12 in size"),
        ("items.0.weight", 10**400, "items[0].weight: 1000"),
        ("items.0.wieght", 1, "items[0].wieght: is not a known field; did you mean 'weight'?"),
        ("items.0.at", ..., "items[0].at: is missing; add it"),
        ("items.0.at", {}, "items[0].at: an object is not a place; give aisle, block and slot; or"),
        ("items.0.at", [1, 2], "items[0].at: a list is not a place; give aisle"),
        ("items.0.at", {"x": 1, "y": 2}, "items[0].at: coordinate (1, 2) is not a slot (item 'a')"),
        ("items.0.at", {"x": 1}, "items[0].at.y: is missing; add it"),
        ("items.0.at", {"node": 1}, "items[0].at: node 1 is not a slot (item 'a'); an aisle"),
        (
            "items.0.at.aisle",
            3,
            "items[0].at.aisle: aisle 3 is outside the layout (item 'a'); use ",
        ),
        (
            "items.0.at.block",
            2,
            "items[0].at.block: block 2 is outside the layout (item 'a'); use ",
        ),
        ("items.0.at.slot", 4, "items[0].at.slot: slot 4 is outside the layout (item 'a'); use 0"),
        ("items.0.at.slot", -1, "items[0].at.slot: -1 is not right; needed: greater than or equal"),
        (
            "items.0.at.side",
            "up",
            "items[0].at.side: \"up\" is not right; needed: 'left' or 'right'",
        ),
        ("items.0.at.aisle", 2, "items[0].at: no way leads from the depot to items a and back; mo"),
        (
            "orders.0.items",
            [],
            "orders[0].items: an empty list is not right; needed: more entries",
        ),
        ("orders.0.items.1", "c", "orders[0].items[1]: order 'o' names the unknown item 'c'; add"),
        ("orders.0.items.1", "a", "orders[0].items[1]: item 'a' is in orders 'o' and 'o'; keep it"),
        ("orders.0.items", ["a"], "orders: items b are in no order; put every item into an order"),
        (
            "orders",
            [],
            "orders: items a, b are in no order; put every item into an order, or leave",
        ),
        ("reference", "7", 'reference: "7" is not a number; give a plain number'),
    ],
)
def test_every_fault_is_one_sentence(
    tmp_path: Path, path: str, value: object, expected: str
) -> None:
    assert sentence(tmp_path, changed(path, value)).startswith(expected)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "is empty; give a file with content"),
        ("{", "broken JSON in line 1, column 2 (expecting property name"),
        (
            '{\n "schema": "qrobot.instance/1",\n "items": [1 2]\n}',
            "broken JSON in line 3, column 14",
        ),
        ("[]", "is an empty list, not an object; see schema 'qrobot.instance/1'"),
        ("3", "is 3, not an object"),
        ("null", "is null, not an object"),
        ("[" * 100_000, "broken JSON (nested too deeply); flatten it"),
        ('{"a":' * 100_000, "broken JSON (nested too deeply); flatten it"),
        ('{"a": NaN}', "NaN is not a number in JSON; use a plain number"),
        ('{"a": -Infinity}', "-Infinity is not a number in JSON"),
        ('{"a": 1, "a": 2}', "the field 'a' is given twice; keep one of them"),
        ('{"a": 1e99999999999999999999}', "1e99999999999999999999 is not a finite number"),
    ],
)
def test_what_is_no_json(tmp_path: Path, text: str, expected: str) -> None:
    assert sentence(tmp_path, text).startswith(expected)


@pytest.mark.parametrize("number", ["1e400", "-1e400", "1e999999999", "9" * 5000, "1e-999999999"])
@pytest.mark.parametrize("field", ["weight", "capacity", "aisle_pitch", "aisles", "slot"])
def test_huge_numbers_are_refused_at_once(tmp_path: Path, number: str, field: str) -> None:
    text = json.dumps(GOOD)
    start = text.index(f'"{field}": ') + len(f'"{field}": ')
    end = min(i for i in (text.find(",", start), text.find("}", start)) if i > 0)
    assert field in sentence(tmp_path, text[:start] + number + text[end:])


def matrix(rows: object, **more: object) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "warehouse": {"kind": "matrix", "matrix": rows, **more},
        "robots": {"count": 1, "capacity": 9},
        "items": [{"id": "a", "weight": 1, "at": {"node": 1}}],
    }


def test_a_matrix_may_have_gaps_where_nothing_is_collected(tmp_path: Path) -> None:
    one = read(tmp_path, matrix([[0, 2, None], [3, None, None], [None, None, 0]]))
    assert one.distances.tolist() == [[0, 2], [3, 0]]
    assert one.notes == ("the distances are asymmetric: depot to a is 2, back 3",)
    qrobot.write(one, tmp_path / "again.json")
    assert "null" in (tmp_path / "again.json").read_text()
    assert qrobot.read(tmp_path / "again.json") == one


@pytest.mark.parametrize(
    ("document", "expected"),
    [
        (matrix([[0, 1], [1]]), "warehouse.matrix[1]: has 1 entries where the matrix has 2 rows"),
        (matrix([[0, 1]]), "warehouse.matrix[0]: has 2 entries where the matrix has 1 rows"),
        (matrix([]), "warehouse.matrix: is empty; give at least the depot's row"),
        (matrix(3), "warehouse.matrix: 3 is not a list of rows; give one list per row"),
        (matrix([3]), "warehouse.matrix[0]: 3 is not a row; give one list per row"),
        (matrix([[0, "1"], [1, 0]]), 'warehouse.matrix[0][1]: "1" is not a distance; give a num'),
        (matrix([[0, True], [1, 0]]), "warehouse.matrix[0][1]: true is not a distance; give"),
        (matrix([[0, -1], [1, 0]]), "warehouse.matrix[0][1]: -1 is not 0 to 1e+09; correct"),
        (matrix([[0, 1e300], [1, 0]]), "warehouse.matrix[0][1]: 1e+300 is not 0 to 1e+09"),
        (matrix([[0, None], [1, 0]]), "items[0].at: no way leads from the depot to items a and"),
        (matrix([[0]]), "items[0].at.node: node 1 is outside the matrix (item 'a'); use 0 to 0"),
        (matrix([[0, 1], [1, 0]], depot_node=2), "warehouse.depot_node: 2 is outside the layout"),
        (matrix([[0, 1], [1, 0]], positions=[[0, 0]]), "warehouse.positions: 1 positions for 2"),
        (matrix([[0, 1], [1, 0]], positions=[[0], [1]]), "warehouse.positions[0]: a list is not"),
    ],
)
def test_matrices_that_are_none(tmp_path: Path, document: object, expected: str) -> None:
    assert sentence(tmp_path, document).startswith(expected)


def test_digits_are_kept(tmp_path: Path) -> None:
    text = json.dumps(GOOD).replace("0.1,", "0.1234567890123456789012,", 1)
    weight = Fraction("0.1234567890123456789012")
    from qrobot.problem.formats.native import read_native

    (tmp_path / "x.json").write_text(text)
    one = read_native(tmp_path / "x.json")
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
    assert WRITTEN == SCHEMA == Document.model_fields["schema_"].annotation.__args__[0]


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


json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4)
    ),
    max_leaves=12,
)


@given(json_values)
def test_the_writer_writes_json(value: object) -> None:
    assert json.loads(dumps(value)) == value


@given(st.decimals(-1000, 1000, places=20))
def test_the_writer_keeps_decimals(value: Decimal) -> None:
    assert loads(dumps([value]))[0] == value


def paths(value: object, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    found = [path] if path else []
    for key in (
        value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    ):
        found += paths(value[key], (*path, key))  # type: ignore[index]
    return found


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(paths(GOOD)), json_values, st.booleans())
def test_no_document_gets_a_traceback(
    path: tuple[str | int, ...], value: object, remove: bool
) -> None:
    document = copy.deepcopy(GOOD)
    target: Any = document
    for part in path[:-1]:
        target = target[part]
    if remove:
        del target[path[-1]]
    else:
        target[path[-1]] = value
    with tempfile.TemporaryDirectory() as folder:
        expect_input_error_at_most(Path(folder) / "x.json", json.dumps(document).encode())


@settings(max_examples=200, deadline=None)
@given(st.integers(0, len(json.dumps(GOOD))), st.binary(max_size=6), st.integers(0, 30))
def test_no_damage_gets_a_traceback(at: int, junk: bytes, cut: int) -> None:
    data = json.dumps(GOOD).encode()
    with tempfile.TemporaryDirectory() as folder:
        expect_input_error_at_most(Path(folder) / "x.json", data[:at] + junk + data[at + cut :])


def expect_input_error_at_most(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    said = f"{path}: ; "
    try:
        qrobot.read(path)
    except InputError as error:
        said = str(error)
    assert said.startswith(("cannot read", str(path)))
    assert "; " in said
    assert "\n" not in said


def test_ten_thousand_items_are_read_or_refused(tmp_path: Path) -> None:
    document = copy.deepcopy(GOOD)
    document["items"] = [
        {"id": f"i{n}", "weight": 0.25, "at": {"aisle": n % 2, "slot": n % 4}}
        for n in range(10_000)
    ]
    document["orders"] = [
        {"id": f"o{n}", "items": [f"i{10 * n + k}" for k in range(10)]} for n in range(500)
    ] + [{"id": "rest", "items": [f"i{n}" for n in range(5_000, 10_000)]}]
    one = read(tmp_path, document)
    assert one.size == 10_000
    assert "distances" not in vars(one)  # 800 MB that nobody asked for yet
    del document["orders"]
    assert sentence(tmp_path, document).startswith("orders: 10000 stops (places of each order) are")
