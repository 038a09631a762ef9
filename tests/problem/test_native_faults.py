"""Native JSON: one sentence for every fault, and no traceback for any damage."""

from __future__ import annotations

import copy
import json
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from native_documents import GOOD, changed, json_values, matrix, paths, read, sentence

import qrobot
from qrobot.errors import InputError


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
            "warehouse: an empty list is not known; give 'aisles', 'floor', 'matrix', 'map' or",
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
        (
            "warehouse.one_way_aisles.0.towards",
            "up",
            "warehouse.one_way_aisles[0].towards: \"up\" is not right; needed: 'front' or 'back'",
        ),
        (
            "warehouse.one_way_crossings.0.towards",
            ...,
            "warehouse.one_way_crossings[0].towards: is missing; add it",
        ),
        (
            "warehouse.one_way_aisles.0",
            {"aisle": 2, "block": 1, "towards": "back"},
            "warehouse.one_way_aisles[]: block 1 of aisle 2 is closed and has a direction; open it",
        ),
        (
            "warehouse.one_way_crossings.0",
            {"cross_aisle": 0, "aisle": 1, "towards": "left"},
            "warehouse.one_way_crossings[]: cross aisle 0 to the right of aisle 1 is closed",
        ),
        (
            "warehouse.one_way_aisles",
            [{"aisle": 1, "towards": "back"}, {"aisle": 1, "towards": "front"}],
            "warehouse.one_way_aisles[]: block 0 of aisle 1 is one-way in both directions; keep",
        ),
        (
            "warehouse.one_way_aisles.0.block",
            2,
            "warehouse.one_way_aisles[].block: 2 is outside the layout; use 0 to 1",
        ),
        (
            "warehouse.one_way_crossings",
            [{"cross_aisle": c, "aisle": 0, "towards": "right"} for c in range(3)],
            "items[1].at: no way leads from the depot to items b and back; move the items, or open "
            "an aisle or drop a direction",
        ),
        ("robots", 3, "robots: 3 is not a fleet; give count and capacity, or a list of robots"),
        ("robots", [], "robots: an empty list is not right; needed: more entries"),
        ("robots.count", 0, "robots.count: 0 is not right; needed: greater than or equal to 1"),
        ("robots.count", 10**6, "robots.count: 1000000 robots are more than 20000; give fewer"),
        ("robots.capacity", 0, "robots.capacity: capacity 0 of robot 'R1' is not positive; use"),
        ("robots.capacity", ..., "robots.capacity: is missing; add it"),
        ("robots.capactiy", 3, "robots.capactiy: is not a known field; did you mean 'capacity'?"),
        ("robots.speed", 0, "robots.speed: 0.0 is not right; needed: greater than 0"),
        ("robots.speed", 1e-308, "robots.speed: speed 1e-308 of robot 'R1' is not 1e-06 to 1e+06"),
        ("robots.speed", 1e307, "robots.speed: speed 1e+307 of robot 'R1' is not 1e-06 to 1e+06"),
        ("reference", -5, "reference: -5.0 is not right; needed: greater than or equal to 0"),
        ("reference", 1e-300, "reference: 1e-300 is not 1e-09 to 1e+15; correct it"),
        ("reference", 1e300, "reference: 1e+300 is not 1e-09 to 1e+15; correct it"),
        (
            "items.0.weight",
            "1,234",
            'items[0].weight: "1,234" is not a number; write 1234, or 1.234, w',
        ),
        (
            "items.0.weight",
            "2.5",
            'items[0].weight: "2.5" is not a number; write 2.5, without quotes',
        ),
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
        (matrix([[0, -1], [1, 0]]), "warehouse.matrix[0][1]: -1 is not 0 or more; correct"),
        (matrix([[0, 1e300], [1, 0]]), "items[0].at: no way leads from the depot to items a and"),
        (matrix([[0, None], [1, 0]]), "items[0].at: no way leads from the depot to items a and"),
        (matrix([[0]]), "items[0].at.node: node 1 is outside the matrix (item 'a'); use 0 to 0"),
        (matrix([[0, 1], [1, 0]], depot_node=2), "warehouse.depot_node: 2 is outside the layout"),
        (matrix([[0, 1], [1, 0]], positions=[[0, 0]]), "warehouse.positions: 1 positions for 2"),
        (matrix([[0, 1], [1, 0]], positions=[[0], [1]]), "warehouse.positions[0]: a list is not"),
    ],
)
def test_matrices_that_are_none(tmp_path: Path, document: object, expected: str) -> None:
    assert sentence(tmp_path, document).startswith(expected)


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
