"""Every error of a file names the place: line and column (in CSV the column's name)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from native_documents import GOOD

import qrobot
from qrobot.errors import InputError

VRP = """\
NAME : own-n4-k2
TYPE : CVRP
DIMENSION : 4
EDGE_WEIGHT_TYPE : EUC_2D
CAPACITY : 10
NODE_COORD_SECTION
1 0 0
 2   3 4
3 0 5
4 1 1
DEMAND_SECTION
1 0
2 4
3 5
4  2.5
DEPOT_SECTION
 1
 -1
EOF
"""
MATRIX = """\
NAME : own-n3-k2
TYPE : CVRP
DIMENSION : 3
EDGE_WEIGHT_TYPE : EXPLICIT
EDGE_WEIGHT_FORMAT : LOWER_ROW
CAPACITY : 10
EDGE_WEIGHT_SECTION
  4
5 6
DEMAND_SECTION
1 0
2 4
3 5
DEPOT_SECTION
1
-1
"""
CSV = """\
order,item,weight,quantity,aisle,slot
A,x,0.5,1,0,2
A,y,2,1,1,3

B,z,1,3,2,0
"""
LAYOUT = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "aisles", "aisles": 3, "slots": 4},
    "robots": {"count": 2, "capacity": 10},
}


def refusal(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        qrobot.read(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert "; " in said
    return said.removeprefix(f"{path}: ")


def numbers_of(text: str) -> Iterator[tuple[int, int, int, int]]:
    """Yield begin, end, line and column of every number below the first section."""
    begin = text.index("_SECTION")
    for found in re.finditer(r"(?<![\w.])-?\d[\d.]*(?![\w.])", text):
        if found.start() > begin:
            line = text.count("\n", 0, found.start())
            column = found.start() - text.rfind("\n", 0, found.start())
            yield found.start(), found.end(), line + 1, column


@pytest.mark.parametrize("text", [VRP, MATRIX], ids=["coordinates", "matrix"])
@pytest.mark.parametrize("junk", ["1x", "nan", "-", "1_0", "1,5", "０"])
def test_every_number_of_a_vrp_file(tmp_path: Path, text: str, junk: str) -> None:
    checked = 0
    for begin, end, line, column in numbers_of(text):
        said = refusal(tmp_path / "x.vrp", text[:begin] + junk + text[end:])
        assert f"_SECTION, line {line}, column {column}: " in said, said
        assert junk in said
        checked += 1
    assert checked >= 10


@pytest.mark.parametrize("text", [VRP, MATRIX], ids=["coordinates", "matrix"])
def test_every_field_of_a_vrp_file(tmp_path: Path, text: str) -> None:
    for number, line in enumerate(text.split("\n"), 1):
        name, colon, value = line.partition(" : ")
        if colon and name != "NAME":
            said = refusal(tmp_path / "x.vrp", text.replace(line, f"{name} : {value}?"))
            assert said.startswith(f"{name}, line {number}: "), said


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("2 4", "2 -4", "DEMAND_SECTION, line 13, column 3"),
        ("2   3 4", "2   3e9 4", "NODE_COORD_SECTION, line 8, column 6"),
        ("2   3 4", "7   3 4", "NODE_COORD_SECTION, line 8, column 2"),
        ("2   3 4", "3   3 4", "NODE_COORD_SECTION, line 9, column 1"),
        ("2 4", "2 4 4", "DEMAND_SECTION, line 13, column 1"),
        ("1 0\n2 4", "1 3\n2 4", "DEMAND_SECTION, line 12, column 3"),
        ("2 4", "2 0.000000000000001", "DEMAND_SECTION, line 13, column 3"),
        ("\n 1\n", "\n 8\n", "DEPOT_SECTION, line 17, column 2"),
        ("DIMENSION : 4", "DIMENSION : 5", "DEMAND_SECTION, line 11"),
        ("TYPE : CVRP", "TYPE : CVRP\nHello", "line 3, column 1"),
    ],
)
def test_other_faults_of_a_vrp_file(tmp_path: Path, old: str, new: str, place: str) -> None:
    said = refusal(tmp_path / "x.vrp", VRP.replace(old, new, 1))
    assert said.startswith(f"{place}: "), said


def test_a_distance_of_a_matrix(tmp_path: Path) -> None:
    said = refusal(tmp_path / "x.vrp", MATRIX.replace("5 6", "5 -6"))
    assert said.startswith("EDGE_WEIGHT_SECTION, line 9, column 3: -6 is not 0 or more (from")


@pytest.mark.parametrize("junk", ["", "\u200b", "-7", "1_000", "nan", "0.5.5", "99999999999999"])
def test_every_cell_of_a_csv_file(tmp_path: Path, junk: str) -> None:
    (tmp_path / "layout.json").write_text(json.dumps(LAYOUT))
    lines = CSV.split("\n")
    header = lines[0].split(",")
    checked = 0
    for number, line in enumerate(lines[1:], 2):
        for at, name in enumerate(header if line else ()):
            if name in ("order", "item") and junk not in ("", "\u200b"):
                continue
            cells = line.split(",")
            cells[at] = junk
            changed = [*lines[: number - 1], ",".join(cells), *lines[number:]]
            said = refusal(tmp_path / "x.csv", "\n".join(changed))
            assert said.startswith(f"line {number}, column {name}: "), said
            checked += 1
    assert checked >= 12


def places(value: Any, path: str, keys: list[Any]) -> Iterator[tuple[str, list[Any]]]:
    """Yield every path of a document as errors write it, and the keys that lead there."""
    if path:
        yield path, keys
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places(inner, f"{path}.{key}".lstrip("."), [*keys, key])
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from places(inner, f"{path}[{i}]", [*keys, i])


@pytest.mark.parametrize("indent", [None, 1, 4])
def test_every_field_of_a_json_document(tmp_path: Path, indent: int | None) -> None:
    checked = 0
    for path, keys in places(GOOD, "", []):
        document = json.loads(json.dumps(GOOD))
        target = document
        for key in keys[:-1]:
            target = target[key]
        target[keys[-1]] = ["junk here"]
        text = json.dumps(document, indent=indent)
        said = refusal(tmp_path / "x.json", text)
        found = re.match(r"(\S+), line (\d+), column (\d+): ", said)
        assert found is not None, said
        # An error is told of the field, of what is in it, or of what it is in.
        assert found[1].startswith(path) or path.startswith(found[1]), said
        before = text.split("\n")[: int(found[2]) - 1]
        at = sum(len(line) + 1 for line in before) + int(found[3]) - 1
        assert text[at] in '{["' or text[at].isdigit(), said
        if found[1].startswith(path):
            assert at <= text.index('"junk here"') < at + 40, said
        checked += 1
    assert checked > 25


@pytest.mark.parametrize(
    ("new", "column"),
    [
        ('"aisles": NaN', 11),
        ('"aisles": -Infinity', 11),
        ('"aisles": 1e99999999999999999999', 11),
        ('"aisles": 3, "kind": "aisles"', 14),
    ],
)
def test_faults_that_only_the_text_shows(tmp_path: Path, new: str, column: int) -> None:
    text = json.dumps(GOOD, indent=0)
    line = text.split("\n").index('"aisles": 3,') + 1
    said = refusal(tmp_path / "x.json", text.replace('"aisles": 3', new, 1))
    assert re.match(rf"(\S+, )?line {line}, column {column}: ", said), said


def test_a_note_that_holds_the_word_is_not_the_place(tmp_path: Path) -> None:
    text = json.dumps({"comment": 'NaN "kind": {[', **GOOD}, indent=0)
    line = text.split("\n").index('"slots": 4,') + 1
    said = refusal(tmp_path / "x.json", text.replace('"slots": 4', '"slots": NaN'))
    assert said.startswith(f"line {line}, column 10: ")
