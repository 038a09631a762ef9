"""Orders as CSV."""

from __future__ import annotations

import json
import re
import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance, Node, Order, Point, Slot

LAYOUT: dict[str, Any] = {
    "schema": "qrobot.instance/1",
    "comment": "for tests",
    "warehouse": {"kind": "aisles", "aisles": 3, "blocks": 2, "slots": 4},
    "robots": {"count": 2, "capacity": 10},
}
FLOOR = LAYOUT | {"warehouse": {"kind": "floor", "metric": "manhattan"}}
TABLE = LAYOUT | {"warehouse": {"kind": "matrix", "matrix": [[0, 1], [1, 0]]}}
GOOD = (
    "order,item,weight,aisle,block,slot,side\nA,x,0.5,0,1,2,right\nA,y,2,1,0,3,\nB,z,1,2,0,0,left\n"
)


def read(
    folder: Path,
    text: str | bytes,
    beside: object = LAYOUT,
    name: str = "layout.json",
    **options: Any,
) -> Instance:
    data = text.encode() if isinstance(text, str) else text
    (folder / "x.csv").write_bytes(data)
    if beside is not None:
        (folder / name).write_text(json.dumps(beside))
    return qrobot.read(folder / "x.csv", **options)


def sentence(folder: Path, text: str | bytes, beside: object = LAYOUT, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text, beside, **options)
    said = str(caught.value)
    assert said.startswith(str(folder))
    assert "; " in said
    assert "\n" not in said
    return said.removeprefix(f"{folder}/").removeprefix("x.csv: ")


def test_reads_orders(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    assert [(i.id, i.weight, i.place) for i in one.items] == [
        ("x", Fraction(1, 2), Slot(0, 2, 1, "right")),
        ("y", Fraction(2), Slot(1, 3, 0, "left")),
        ("z", Fraction(1), Slot(2, 0, 0, "left")),
    ]
    assert one.orders == (Order("A", ("x", "y")), Order("B", ("z",)))
    assert (one.name, one.comment, len(one.robots)) == ("x", "for tests", 2)


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        GOOD.replace("\n", "\r"),
        GOOD.replace(",", ";").replace("0.5", "0,5"),
        GOOD.replace(",", "\t"),
        GOOD.replace("A", '"A"').replace(",", ",  "),
        "\n" + GOOD.replace("\n", "\n\n,,,,,,\n"),
        "Slot,SIDE,Block,item,Weight,aisle,ORDER\n2,right,1,x,0.5,0,A\n3,,0,y,2,1,A\n0,left,0,z,1,2,B",
    ],
    ids=["bom", "crlf", "cr", "semicolon", "tab", "quotes", "blank lines", "column order"],
)
def test_spreadsheets_write_it_in_many_ways(tmp_path: Path, text: str) -> None:
    (tmp_path / "other").mkdir()
    assert read(tmp_path, text) == read(tmp_path / "other", GOOD)


def test_quantity_multiplies_the_weight(tmp_path: Path) -> None:
    one = read(tmp_path, "order,item,weight,quantity,aisle,slot\nA,x,0.1,3,0,0\n")
    assert one.items[0].weight == Fraction(3, 10)


def test_an_article_in_several_orders_gets_the_orders_name(tmp_path: Path) -> None:
    one = read(tmp_path, "order,item,weight,aisle,slot\nA,x,1,0,0\nB,x,1,0,0\nB,y,1,0,1\n")
    assert [i.id for i in one.items] == ["A/x", "B/x", "y"]
    assert one.orders == (Order("A", ("A/x",)), Order("B", ("B/x", "y")))


def test_orders_need_not_stand_together(tmp_path: Path) -> None:
    one = read(tmp_path, "order,item,weight,aisle,slot\nA,x,1,0,0\nB,y,1,0,0\nA,z,1,0,1\n")
    assert one.orders == (Order("A", ("x", "z")), Order("B", ("y",)))


def test_coordinates_and_rows(tmp_path: Path) -> None:
    floor = read(tmp_path, "order,item,weight,x,y\nA,p,1,-1.5,2\n", FLOOR)
    assert floor.items[0].place == Point(-1.5, 2.0)
    assert floor.distances[0, 1] == 3.5
    table = read(tmp_path, "order,item,weight,node\nA,p,1,1\n", TABLE)
    assert table.items[0].place == Node(1)


def test_a_header_alone_is_an_empty_instance(tmp_path: Path) -> None:
    assert read(tmp_path, "order,item,weight,x,y\n", FLOOR).size == 0


def test_the_layout_is_found(tmp_path: Path) -> None:
    assert "has no layout beside it; add x.layout.json or layout.json to its folder" in sentence(
        tmp_path, GOOD, None
    )
    read(tmp_path, GOOD, LAYOUT | {"comment": "general"})
    read(tmp_path, GOOD, LAYOUT | {"comment": "special"}, "x.layout.json")
    assert read(tmp_path, GOOD, None).comment == "special"
    elsewhere = tmp_path / "elsewhere.json"
    elsewhere.write_text(json.dumps(LAYOUT | {"comment": "named"}))
    assert read(tmp_path, GOOD, None, layout=elsewhere).comment == "named"
    with pytest.raises(InputError, match=r"no\.json: cannot read"):
        qrobot.read(tmp_path / "x.csv", layout=tmp_path / "no.json")


def test_faults_of_the_layout_carry_its_name(tmp_path: Path) -> None:
    aisles = {"kind": "aisles", "aisles": 3, "slots": 4, "depot": {"aisle": 3}}
    for change, said in (
        ({"robots": 3}, "robots, line 1, column .*: 3 is not a fleet"),
        ({"robots": {"count": 1, "capacity": 0}}, "robots.capacity, line 1, column .*: capacity 0"),
        ({"items": []}, "items, line 1, column .*: does not belong"),
        ({"warehouse": aisles}, "warehouse.depot.aisle, line 1, column .*: 3 is outside the lay"),
    ):
        assert re.match(f"layout.json: {said}", sentence(tmp_path, GOOD, LAYOUT | change))


HEAD = "order,item,weight,aisle,slot\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "is empty; give a file with content"),
        (b"\x00\x01", "is binary, not text; give"),
        (GOOD.encode("utf-16"), "is UTF-16 text; save it as UTF-8"),
        ("{}", "line 1: column '{}' is not known; remove it, or give --ignore-columns {}; k"),
        ("order,item,wieght,x,y\n", "line 1: column 'wieght' is not known; did you mean 'weight'?"),
        ("order,item,weight,x,y,customer\n", "line 1: column 'customer' is not known; "),
        ("order,item,item,weight,x,y\n", "line 1: column 'item' is there twice; keep one"),
        ("order,weight,x,y\n", "line 1: column 'item' is missing; add it to the header"),
        ("order,item,weight\n", "line 1: has no place; give aisle and slot"),
        ("order,item,weight,x\n", "line 1: the columns x are not a place; give aisle and slot"),
        (
            "order,item,weight,aisle,slot,x\n",
            "line 1: the columns aisle, slot, x are not a place; give",
        ),
        (HEAD + "A,x,1,0\n", "line 2: 4 cells where the header has 5; add or remove cells"),
        (HEAD + "A,x,1,5,0,0\n", "line 2: 6 cells where the header has 5"),
        (HEAD + "\nA,,1,0,0\n", "line 3, column item: is empty; fill it in"),
        (HEAD + "A,x,,0,0\n", "line 2, column weight: is empty"),
        (HEAD + "A,x,8 kg,0,0\n", "line 2, column weight: 8 kg is not a finite number; use a"),
        (HEAD + "A,x,nan,0,0\n", "line 2, column weight: nan is not a finite number"),
        (HEAD + "A,x,1e400,0,0\n", "line 2, column weight: 1E+400 is larger than 1e+12"),
        (HEAD + "A,x,-1,0,0\n", "line 2, column weight: weight -1 of item 'x' is negative; use"),
        (HEAD + "A,x,1,0.5,0\n", "line 2, column aisle: 0.5 is not a whole number from 0; correct"),
        (HEAD + "A,x,1,-1,0\n", "line 2, column aisle: -1 is not a whole number from 0"),
        (
            HEAD + "A,x,1,0,0\nA,y,1,7,0\n",
            "line 3, column aisle: aisle 7 is outside the layout (it",
        ),
        (
            HEAD + "A,x,1,0,0\nA,x,1,0,0\n",
            "line 3, column item: item 'x' of order 'A' is in line 2",
        ),
        (HEAD + "A,x,1,0,0\nB,x,1,0,0\nC,A/x,1,0,0\n", "line 4, column item: item 'A/x' of order"),
        (
            HEAD + '"A\nB",x,1,0,0\n',
            "line 3, column order: 'A\\nB' holds the invisible character U+000A",
        ),
        (HEAD + "A" * 91 + ",x,1,0,0\n", "line 2, column order: "),
        (HEAD + '"A,x,1,0,0\n', "line 2: broken CSV (unexpected end of data); correct it there"),
        (HEAD + "A,x,1,0,0\n" + "A" * 200_000, "line 3: broken CSV (field larger than field limit"),
        (
            "order,item,weight,aisle,slot,side\nA,x,1,0,0,up\n",
            "line 2, column side: 'up' is not a side; give left or right",
        ),
        (
            "order,item,weight,aisle,slot,quantity\nA,x,1,0,0,0\n",
            "line 2, column quantity: 0 is not a whole number from 1; correct it",
        ),
        (
            "order,item,weight,x,y\nA,p,1,0,0\n",
            "line 2, column x: coordinate (0, 0) is not a slot",
        ),
    ],
)
def test_every_fault_names_line_and_column(
    tmp_path: Path, text: str | bytes, expected: str
) -> None:
    assert sentence(tmp_path, text).startswith(expected)


def test_an_unreachable_slot_is_named(tmp_path: Path) -> None:
    warehouse = LAYOUT["warehouse"] | {"closed_aisles": [{"aisle": 1, "block": 0}]}
    assert "no way leads from the depot to items y and back" in sentence(
        tmp_path, GOOD, LAYOUT | {"warehouse": warehouse}
    )


@settings(max_examples=200, deadline=None)
@given(st.integers(0, len(GOOD)), st.text(max_size=6), st.integers(0, 12))
def test_no_damage_gets_a_traceback(at: int, junk: str, cut: int) -> None:
    text = GOOD[:at] + junk + GOOD[at + cut :]
    said = "; "
    with tempfile.TemporaryDirectory() as folder:
        try:
            read(Path(folder), text.encode("utf-8", errors="surrogatepass"))
        except InputError as error:
            said = str(error)
    assert "; " in said
    assert "\n" not in said


TIMES = "order,item,weight,aisle,slot,due,priority,deadline,release\n"


def test_lines_say_when_their_order_is_wanted(tmp_path: Path) -> None:
    rows = (
        "A,x,1,0,0,90.5,,,5\nA,y,1,0,1,,2,,\nB,z,1,0,2,,,400,\nC,w,1,1,1,,,,\nA,v,1,0,3,90.50,,,\n"
    )
    one = read(tmp_path, TIMES + rows)
    assert one.orders == (
        Order("A", ("x", "y", "v"), release=5, due=90.5, priority=2),
        Order("B", ("z",), deadline=400),
        Order("C", ("w",)),
    )


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            "A,x,1,0,0,90,,,\nA,y,1,0,1,91,,,\n",
            "line 3, column due: 91 is not the 90 of line 2, wh",
        ),
        (
            "A,x,1,0,0,-1,,,\n",
            "line 2, column due: due -1 of order 'A' is not 0 to 1e+09; give sec",
        ),
        (
            "A,y,1,0,1,,,,\nA,x,1,0,0,9,,,10\n",
            "line 3, column due: due 9 of order 'A' is before its",
        ),
        ("A,x,1,0,0,soon,,,\n", "line 2, column due: soon is not a finite number"),
    ],
)
def test_times_that_nobody_can_keep(tmp_path: Path, rows: str, said: str) -> None:
    assert sentence(tmp_path, TIMES + rows).startswith(said)
