"""CVRPLIB and QOBLIB files, of our own making."""

from __future__ import annotations

import itertools
import math
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
from qrobot.problem import DistanceTable, Instance, OpenFloor
from qrobot.problem.formats.vrp import read_solution

GOOD = """\
# a comment line
NAME : own-n4-k2
COMMENT : (Own, Min no of trucks: 3, Optimal value: 26)
TYPE : CVRP
DIMENSION : 4
EDGE_WEIGHT_TYPE : EUC_2D
CAPACITY : 10
NODE_COORD_SECTION
1 0 0
2 3 4
3 0 5
4 1 1
DEMAND_SECTION
1 0
2 4
3 5
4 2.5
DEPOT_SECTION
 1
 -1
EOF
"""


def read(folder: Path, text: str | bytes, name: str = "x.vrp", **options: Any) -> Instance:
    data = text.encode() if isinstance(text, str) else text
    (folder / name).write_bytes(data)
    return qrobot.read(folder / name, **options)


def sentence(folder: Path, text: str | bytes, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text, **options)
    said = str(caught.value)
    assert said.startswith(f"{folder / 'x.vrp'}: ")
    assert "; " in said
    assert "\n" not in said
    return said.removeprefix(f"{folder / 'x.vrp'}: ")


def without_place(said: str) -> str:
    """Leave out line and column: tests/problem/test_fault_places.py holds them."""
    return re.sub(r",? ?line \d+(, column \d+)?(?=: )", "", said).removeprefix(": ")


def test_reads_everything(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    assert one.name == "own-n4-k2"
    assert [i.id for i in one.items] == ["1", "2", "3"]
    assert [i.weight for i in one.items] == [4, 5, Fraction(5, 2)]
    assert [(r.id, r.capacity) for r in one.robots] == [("R1", 10), ("R2", 10), ("R3", 10)]
    assert one.reference == 26
    # Nearest integer, halves up: sqrt(10) = 3.16, sqrt(13) = 3.6, sqrt(17) = 4.12.
    assert one.distances.tolist() == [[0, 5, 5, 1], [5, 0, 3, 4], [5, 3, 0, 4], [1, 4, 4, 0]]
    assert one.warehouse == OpenFloor(0.0, 0.0, "euclidean", "nearest")


@pytest.mark.parametrize(
    ("name", "comment", "file", "count"),
    [
        ("a-k7", "(No of trucks: 5, x)", "x-k9.vrp", 5),
        ("a-k7", "number of vehicles = 6", "x-k9.vrp", 6),
        ("a-k7", "nothing", "x-k9.vrp", 7),
        ("a", "nothing", "x-k9.vrp", 9),
    ],
)
def test_the_number_of_vehicles(
    tmp_path: Path, name: str, comment: str, file: str, count: int
) -> None:
    text = GOOD.replace("own-n4-k2", name).replace(
        "(Own, Min no of trucks: 3, Optimal value: 26)", comment
    )
    assert len(read(tmp_path, text, file).robots) == count
    assert len(read(tmp_path, text, file, robots=2).robots) == 2
    assert len(read(tmp_path, text, file, robots="free").robots) == 3


def test_no_number_of_vehicles(tmp_path: Path) -> None:
    text = GOOD.replace("-k2", "").replace("Min no of trucks: 3,", "")
    assert "number of vehicles is neither in the comment nor, as -kN, in the name; give the " in (
        sentence(tmp_path, text)
    )
    assert "(--robots N, or --robots free)" in sentence(tmp_path, text)
    assert len(read(tmp_path, text, robots=2).robots) == 2
    with_field = text.replace("TYPE : CVRP", "TYPE : CVRP\nVEHICLES : 4")
    assert len(read(tmp_path, with_field).robots) == 4


def test_another_capacity(tmp_path: Path) -> None:
    assert read(tmp_path, GOOD, capacity=12).robots[0].capacity == 12
    text = GOOD.replace("CAPACITY : 10\n", "")
    assert "CAPACITY: is missing; add it, or give --capacity" in sentence(tmp_path, text)
    assert read(tmp_path, text, capacity=12).robots[0].capacity == 12


@pytest.mark.parametrize("ending", [".sol", ".opt.sol", ".bst.sol"])
def test_the_reference_may_lie_beside(tmp_path: Path, ending: str) -> None:
    text = GOOD.replace(", Optimal value: 26", "")
    assert read(tmp_path, text).reference is None
    (tmp_path / f"x{ending}").write_text("nonsense")
    assert read(tmp_path, text).reference is None
    (tmp_path / f"x{ending}").write_text("Route #1: 1 2\nRoute #2: 3\nCost 15\n")
    assert read(tmp_path, text).reference == 15


def test_a_fraction_as_reference_means_unrounded_distances(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD.replace("value: 26", "value: 26.4"))
    assert one.reference == 26.4
    assert one.distances[1, 2] == math.dist((3, 4), (0, 5))


def test_any_node_may_be_the_depot(tmp_path: Path) -> None:
    text = GOOD.replace(" 1\n -1", " 3\n -1").replace("1 0\n2 4\n3 5\n", "1 5\n2 4\n3 0\n")
    one = read(tmp_path, text)
    assert one.warehouse.depot == (0, 5)
    assert [(i.id, i.weight) for i in one.items] == [("1", 5), ("2", 4), ("3", Fraction(5, 2))]
    assert one.distances[0].tolist() == [0, 5, 3, 4]


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("CEIL_2D", [5, 5, 2]), ("FLOOR_2D", [5, 5, 1]), ("EXACT_2D", [5000, 5000, 1414])],
)
def test_other_roundings_become_a_table(tmp_path: Path, kind: str, expected: list[int]) -> None:
    one = read(tmp_path, GOOD.replace("EUC_2D", kind))
    assert isinstance(one.warehouse, DistanceTable)
    assert one.distances[0, 1:].tolist() == expected
    assert one.warehouse.position(one.items[0].place) == (3, 4)


def test_manhattan(tmp_path: Path) -> None:
    assert read(tmp_path, GOOD.replace("EUC_2D", "MAN_2D")).distances[0].tolist() == [0, 7, 5, 2]


MATRIX = [[0, 1, 2, 3], [1, 0, 4, 5], [2, 4, 0, 6], [3, 5, 6, 0]]
LOWER = [(i, j) for i in range(4) for j in range(i + 1)]
UPPER = [(i, j) for i in range(4) for j in range(i, 4)]
FORMATS = {
    "FULL_MATRIX": list(itertools.product(range(4), repeat=2)),
    "LOWER_ROW": [(i, j) for i, j in LOWER if i != j],
    "UPPER_ROW": [(i, j) for i, j in UPPER if i != j],
    "LOWER_DIAG_ROW": LOWER,
    "UPPER_DIAG_ROW": UPPER,
    "LOWER_COL": [(i, j) for j in range(4) for i in range(j + 1, 4)],
    "UPPER_COL": [(i, j) for j in range(4) for i in range(j)],
    "LOWER_DIAG_COL": [(i, j) for j in range(4) for i in range(j, 4)],
    "UPPER_DIAG_COL": [(i, j) for j in range(4) for i in range(j + 1)],
}


def explicit(layout: str, numbers: list[int], width: int) -> str:
    lines = [" ".join(map(str, numbers[i : i + width])) for i in range(0, len(numbers), width)]
    start, end = GOOD.index("NODE_COORD"), GOOD.index("DEMAND")
    head = GOOD[:start].replace("EUC_2D", f"EXPLICIT\nEDGE_WEIGHT_FORMAT: {layout} ")
    return head + "EDGE_WEIGHT_SECTION\n" + "\n".join(lines) + "\n" + GOOD[end:]


@pytest.mark.parametrize("layout", FORMATS)
@pytest.mark.parametrize("width", [1, 3, 4, 99])
def test_explicit_weights_however_wrapped(tmp_path: Path, layout: str, width: int) -> None:
    numbers = [MATRIX[i][j] for i, j in FORMATS[layout]]
    one = read(tmp_path, explicit(layout, numbers, width))
    assert one.distances.tolist() == MATRIX
    short = without_place(sentence(tmp_path, explicit(layout, numbers[:-1], width)))
    assert short.startswith(f"EDGE_WEIGHT_SECTION: {len(numbers) - 1} weights where {layout} of 4")


def test_an_asymmetric_matrix_is_told(tmp_path: Path) -> None:
    rows = [0, 1, 2, 3, 9, 0, 4, 5, 2, 4, 0, 6, 3, 5, 6, 0]
    one = read(tmp_path, explicit("FULL_MATRIX", rows, 4))
    assert one.notes[0] == "the distances are asymmetric: depot to 1 is 1, back 9"


def without(section: str) -> str:
    start = GOOD.index(section)
    end = GOOD.find("_SECTION", start + len(section) + 9)
    end = GOOD.rfind("\n", 0, end) + 1 if end > 0 else GOOD.index("EOF")
    return GOOD[:start] + GOOD[end:]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "is empty; give a file with content"),
        (b"\x89PNG\r\n\x1a\n\x00", "is binary, not text; give"),
        ("{}", "'{}' is neither a field nor a section; write it as NAME : value"),
        ("hello : world", "HELLO: world asks for something that qRobot does not plan for; give a"),
        (GOOD.replace("CVRP\n", "VRPTW\n"), "TYPE: VRPTW is not planned; give a CVRP or an ACVRP"),
        (
            GOOD.replace("DIMENSION : 4", "DIMENSION : 5"),
            "DEMAND_SECTION: 4 nodes where DIMENSION ",
        ),
        (
            GOOD.replace("DIMENSION : 4", "DIMENSION : 3"),
            "DEMAND_SECTION: 4 nodes where DIMENSION ",
        ),
        (
            GOOD.replace("DIMENSION : 4", "DIMENSION : four"),
            "DIMENSION: four is not a whole number",
        ),
        (GOOD.replace("DIMENSION : 4", "DIMENSION : 0"), "DIMENSION: 0 is not a whole number from"),
        (GOOD.replace("DIMENSION : 4", "DIMENSION : -4"), "DIMENSION: -4 is not a whole number"),
        (GOOD.replace("DIMENSION : 4", f"DIMENSION : {10**9}"), "DIMENSION: 1000000000 is not a "),
        (GOOD.replace("DIMENSION : 4\n", ""), "DIMENSION: is missing; add it; the file may be cut"),
        (
            GOOD.replace("EUC_2D", "XRAY1"),
            "EDGE_WEIGHT_TYPE: XRAY1 is not known; use EXPLICIT, GEO",
        ),
        (GOOD.replace("EDGE_WEIGHT_TYPE : EUC_2D\n", ""), "EDGE_WEIGHT_TYPE: is missing; use"),
        (GOOD.replace("EUC_2D", "EXPLICIT"), "EDGE_WEIGHT_SECTION: is missing; add it"),
        (explicit("SPIRAL", [1], 1), "EDGE_WEIGHT_FORMAT: SPIRAL is not known; use one of FULL_M"),
        (
            explicit("LOWER_ROW", [-1, 1, 1, 1, 1, 1], 6),
            "EDGE_WEIGHT_SECTION: -1 is not 0 or more",
        ),
        (GOOD.replace("CAPACITY : 10", "CAPACITY : ten"), "CAPACITY: ten is not a finite number"),
        (GOOD.replace("CAPACITY : 10", "CAPACITY : 0"), "CAPACITY: 0 is not positive; correct it"),
        (
            GOOD.replace("CAPACITY : 10", "CAPACITY : 1e400"),
            "CAPACITY: 1E+400 is larger than 1e+12 in",
        ),
        (without("NODE_COORD"), "NODE_COORD_SECTION: is missing; add it; the file may be cut off"),
        (without("DEMAND"), "DEMAND_SECTION: is missing; add it; the file may be cut off"),
        (without("DEPOT"), "DEPOT_SECTION: is missing; give one node, then -1"),
        (GOOD.replace(" 1\n -1", " -1"), "DEPOT_SECTION: names no depot; give one node, then -1"),
        (GOOD.replace(" 1\n -1", " 1\n 2\n -1"), "DEPOT_SECTION: 2 depots where one belongs; give"),
        (GOOD.replace(" 1\n -1", " 9\n -1"), "DEPOT_SECTION: 9 is not a node; use 1 to 4"),
        (GOOD.replace(" 1\n -1", " 0.5\n -1"), "DEPOT_SECTION: 0.5 is not a node; use 1 to 4"),
        (
            GOOD.replace(" 1\n -1", " x\n -1"),
            "DEPOT_SECTION: 'x' is not a number; correct",
        ),
        (
            GOOD.replace("1 0\n2 4", "1 3\n2 4"),
            "DEMAND_SECTION: the depot has demand 3; make it 0",
        ),
        (GOOD.replace("2 3 4", "2 3 four"), "NODE_COORD_SECTION: 'four' is not a number"),
        (GOOD.replace("2 3 4", "2 3"), "NODE_COORD_SECTION: 2 numbers where 3 belong"),
        (
            GOOD.replace("2 3 4", "2 3 nan"),
            "NODE_COORD_SECTION: 'nan' is not a number",
        ),
        (GOOD.replace("2 3 4", "2 3 1e400"), "NODE_COORD_SECTION: 1e400 is not a number up to"),
        (GOOD.replace("2 3 4", "2 3 " + "9" * 5000), "NODE_COORD_SECTION: 999999"),
        (GOOD.replace("2 3 4", "3 3 4"), "NODE_COORD_SECTION: node 3 is in line 10 too; numb"),
        (GOOD.replace("2 4\n", "2 -4\n"), "DEMAND_SECTION: the demand -4 is negative; use zero"),
        (
            GOOD.replace("DEPOT_S", "TIME_WINDOW_SECTION\n1 2\nDEPOT_S"),
            "TIME_WINDOW_SECTION: is mor",
        ),
        (
            GOOD.replace("TYPE : CVRP", "TYPE : CVRP\nDISTANCE : 9"),
            "DISTANCE: 9 asks for something that qRobot does",
        ),
        (
            GOOD.replace("DEPOT_S", "NAME : b\nDEPOT_S"),
            "NAME: 'b' is given where line 2 has 'own-n4",
        ),
    ],
)
def test_every_fault_names_its_section(tmp_path: Path, text: str | bytes, expected: str) -> None:
    assert without_place(sentence(tmp_path, text)).startswith(expected)


def test_old_encodings_are_read(tmp_path: Path) -> None:
    assert "Köln" in read(tmp_path, GOOD.replace("Own", "Köln").encode("latin-1")).comment


@pytest.mark.parametrize("cut", range(0, len(GOOD), 7))
def test_a_file_that_was_cut_off_is_never_half_an_instance(tmp_path: Path, cut: int) -> None:
    text = GOOD[:cut]
    if GOOD.index("DEPOT_SECTION\n 1") + 15 <= cut:
        assert read(tmp_path, text).size == 3
    else:
        assert sentence(tmp_path, text or " ")


WORDS = [
    "0",
    "-1",
    "1e9",
    "nan",
    "x",
    "EUC_2D",
    "_SECTION",
    "DEMAND_SECTION",
    ":",
    "EOF",
    "9" * 400,
]


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 60), st.sampled_from([*WORDS, "9" * 400, ""]) | st.text(max_size=4)
        ),
        min_size=1,
        max_size=4,
    ),
    st.sampled_from([GOOD, explicit("LOWER_ROW", [1, 2, 3, 4, 5, 6], 4)]),
)
def test_no_damage_gets_a_traceback(changes: list[tuple[int, str]], text: str) -> None:
    words = text.replace("\n", " \n ").split(" ")
    for at, word in changes:
        words[at % len(words)] = word
    said = "; "
    with tempfile.TemporaryDirectory() as folder:
        try:
            read(Path(folder), " ".join(words).encode("utf-8", errors="surrogatepass"))
        except InputError as error:
            said = str(error)
    assert "; " in said
    assert "\n" not in said


def test_reads_solutions(tmp_path: Path) -> None:
    (tmp_path / "x.sol").write_text("Route #1: 31 46 35 \nRoute #2: 15\ncost 27.5\nTime 3\n")
    assert read_solution(tmp_path / "x.sol") == ([[31, 46, 35], [15]], 27.5)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "is empty; give"),
        ("Route #1: 1 two\nCost 3", "line 1: is not a solution; give lines such as"),
        ("Route 1 2\nCost 3", "line 1: is not a solution; give lines such as"),
        ("Cost 3", "Route: is missing; give routes and cost"),
        ("Route #1: 1 2", "Cost: is missing; give routes and cost"),
        ("Route #1: 1 2\nCost three", "Cost, line 2: 'three' is not a number above zero; correct"),
        ("\0", "is binary, not text"),
    ],
)
def test_what_is_no_solution(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "x.sol").write_text(text)
    with pytest.raises(InputError) as caught:
        read_solution(tmp_path / "x.sol")
    assert str(caught.value).removeprefix(f"{tmp_path / 'x.sol'}: ").startswith(expected)
