"""Order batching files in the HI format, of our own making, and the shared ones where they are."""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import networkx as nx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance, Slot

HEADER = {
    "NAME": "own.txt",
    "TYPE": "Order_batching",
    "COMMENT": "Kühn and Groß",
    "PICKER_CAPACITY": "10.5",
    "LAYOUT": "single-block",
    "NUM_AISLES": "3",
    "NUM_CELLS": "4",
    "DEPOT_AISLE": "1",
    "DEPOT_LOCATION": "top",
    "DISTANCE_AISLE_TO_AISLE": "2.4",
    "DISTANCE_CELL_TO_CELL": "1",
    "DISTANCE_TOP_TO_CELL": "0.5",
    "DISTANCE_BOTTOM_TO_CELL": "2",
    "DISTANCE_TOP_OR_BOTTOM_TO_DEPOT": "3",
}
BODY = """\
ARTICLE_SECTION
NUM_ARTICLES : 4
ID 0 WEIGHT 1
ID 1 WEIGHT 0.5
ID 2 WEIGHT 2
ID 7 WEIGHT 1
SKU_SECTION
NUM_SKUS : 4
ID 0 AISLE 0 CELL 0 QUANTITY 1 LEFT_RIGHT_HAND_SIDE left
ID 1 AISLE 0 CELL 3 QUANTITY 1 LEFT_RIGHT_HAND_SIDE right
ID 2 AISLE 2 CELL 1 QUANTITY 1 LEFT_RIGHT_HAND_SIDE left
ID 7 AISLE 1 CELL 2 QUANTITY 1 LEFT_RIGHT_HAND_SIDE left
ORDER_SECTION
NUM_ORDERS : 2
NUM_ARTICLES_IN_ORDER : 4
ID 1 QUANTITY 3
ID 0 QUANTITY 1
ID 1 QUANTITY 2
ID 2 QUANTITY 1
NUM_ARTICLES_IN_ORDER : 2
ID 7 QUANTITY 4
ID 0 QUANTITY 2
EOF
"""


def text_of(header: dict[str, str] = HEADER, body: str = BODY) -> str:
    return "".join(f"{name} : {value}\n" for name, value in header.items()) + body


GOOD = text_of()


def read(folder: Path, text: str, name: str = "x.txt", **options: Any) -> Instance:
    """Read a text as such files are written: Latin-1 with CRLF."""
    (folder / name).write_bytes(text.replace("\n", "\r\n").encode("latin-1"))
    return qrobot.read(folder / name, **options)


def sentence(folder: Path, text: str, name: str = "x.txt", **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text, name, **options)
    said = str(caught.value)
    assert said.startswith(f"{folder / name}: ")
    assert "; " in said
    assert "\n" not in said
    return said.removeprefix(f"{folder / name}: ")


def test_orders_stay_whole_and_repeated_lines_add_up(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    assert one.name == "own"
    assert one.comment == "Kühn and Groß"
    assert [(o.id, o.items) for o in one.orders] == [
        ("1", ("1/1", "1/0", "1/2")),
        ("2", ("2/7", "2/0")),
    ]
    assert [(i.weight, i.quantity, i.article) for i in one.items] == [
        (Fraction(5, 2), 5, "1"), (1, 1, "0"), (2, 1, "2"), (4, 4, "7"), (2, 2, "0"),
    ]  # fmt: skip
    # Cell 0 is next to the top cross aisle, slot 0 next to the front one.
    assert one.items[0].place == Slot(0, 0, side="right")
    assert one.items[1].place == Slot(0, 3)
    # As many trips as there are orders, at most.
    assert [(r.capacity, r.trips) for r in one.robots] == [(Fraction(21, 2), 1)] * 2
    assert read(tmp_path, GOOD, robots=1, capacity=12).robots[0].capacity == 12
    assert one.notes == ()


def pick_graph(header: dict[str, str]) -> nx.Graph:
    """Every cell, crossing and the depot as a node, from the numbers of the header."""
    cells = int(header["NUM_CELLS"])
    graph = nx.Graph()
    for a in range(int(header["NUM_AISLES"])):
        chain = [("top", a), *((a, c) for c in range(cells)), ("bottom", a)]
        steps = ["TOP_TO_CELL", *["CELL_TO_CELL"] * (cells - 1), "BOTTOM_TO_CELL"]
        for (one, other), step in zip(itertools.pairwise(chain), steps, strict=True):
            graph.add_edge(one, other, weight=float(header[f"DISTANCE_{step}"]))
        if a:
            for side in ("top", "bottom"):
                pitch = float(header["DISTANCE_AISLE_TO_AISLE"])
                graph.add_edge((side, a - 1), (side, a), weight=pitch)
    door = header["DEPOT_LOCATION"], int(header["DEPOT_AISLE"])
    graph.add_edge("depot", door, weight=float(header["DISTANCE_TOP_OR_BOTTOM_TO_DEPOT"]))
    return graph


def check_distances(one: Instance, header: dict[str, str], cells: list[tuple[int, int]]) -> None:
    graph = pick_graph(header)
    nodes = ["depot", *cells]
    for i, node in enumerate(nodes):
        far = nx.single_source_dijkstra_path_length(graph, node)
        assert one.distances[i].tolist() == pytest.approx([far[other] for other in nodes])


lengths = st.sampled_from(["0", "0.5", "1", "1.5", "2.4", "7"])


@st.composite
def headers(draw: st.DrawFn) -> dict[str, str]:
    aisles = draw(st.integers(1, 4))
    drawn = {name: draw(lengths) for name in HEADER if name.startswith("DISTANCE")}
    return (
        HEADER
        | drawn
        | {
            "NUM_AISLES": f"{aisles}",
            "NUM_CELLS": f"{draw(st.integers(2, 5))}",
            "DEPOT_AISLE": f"{draw(st.integers(0, aisles - 1))}",
            "DEPOT_LOCATION": draw(st.sampled_from(["top", "bottom"])),
            "DISTANCE_AISLE_TO_AISLE": draw(st.sampled_from(["1", "2.4", "5"])),
            "DISTANCE_CELL_TO_CELL": draw(st.sampled_from(["0.5", "1", "3"])),
        }
    )


def body_of(header: dict[str, str]) -> tuple[str, list[tuple[int, int]]]:
    """Return the sections of a file that collects from every cell, and the cells."""
    cells = [
        (a, c) for a in range(int(header["NUM_AISLES"])) for c in range(int(header["NUM_CELLS"]))
    ]
    n = len(cells)
    rows: Iterator[str] = itertools.chain(
        ["ARTICLE_SECTION", f"NUM_ARTICLES : {n}"],
        (f"ID {i} WEIGHT 1" for i in range(n)),
        ["SKU_SECTION", f"NUM_SKUS : {n}"],
        (
            f"ID {i} AISLE {a} CELL {c} QUANTITY 1 LEFT_RIGHT_HAND_SIDE left"
            for i, (a, c) in enumerate(cells)
        ),
        ["ORDER_SECTION", "NUM_ORDERS : 1", f"NUM_ARTICLES_IN_ORDER : {n}"],
        (f"ID {i} QUANTITY 1" for i in range(n)),
        ["EOF"],
    )
    return "\n".join(rows), cells


@settings(max_examples=40, deadline=None)
@given(headers())
def test_distances_are_those_of_the_graph_of_cells(
    tmp_path_factory: pytest.TempPathFactory, header: dict[str, str]
) -> None:
    body, cells = body_of(header)
    folder = tmp_path_factory.mktemp("hi")
    one = read(folder, text_of(header, body))
    check_distances(one, header, cells)
    qrobot.write(one, folder / "x.json")
    again = qrobot.read(folder / "x.json")
    assert (again.warehouse, again.items, again.orders) == (one.warehouse, one.items, one.orders)
    assert again.robots == one.robots


def test_a_single_picker_takes_everything_on_one_tour(tmp_path: Path) -> None:
    header = {name: value for name, value in HEADER.items() if name != "PICKER_CAPACITY"}
    body = BODY[: BODY.index("ORDER")] + "ORDER_SECTION\nNUM_ARTICLES : 1\nID 2 QUANTITY 1\nEOF\n"
    body = re.sub(r" WEIGHT \S+", "", body)
    one = read(tmp_path, text_of(header | {"TYPE": "Single_picker_routing"}, body))
    assert [o.items for o in one.orders] == [("1/2",)]
    assert [r.capacity for r in one.robots] == [1]
    # 3 + 2.4 + 0.5 + 1, and back.
    assert qrobot.solve(one).cost == pytest.approx(13.8)


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1, old
    return GOOD.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("AISLES : 3", "AISLES : x", "line 6: NUM_AISLES x is not a whole number from 1 to"),
        ("AISLES : 3", "AISLES : 3000", "NUM_AISLES, line 6: 6000 crossings are more than"),
        ("NUM_CELLS : 4\n", "", "NUM_CELLS: is missing; add it to the header"),
        ("AISLE : 1", "AISLE : 3", "line 8: DEPOT_AISLE 3 is not a whole number from 0 to 2;"),
        (": top", ": left", "line 9: 'left' is not a side of the aisles; write bottom or top"),
        (": 2.4", ": 2,4", "line 10: DISTANCE_AISLE_TO_AISLE 2,4 is not a length"),
        (": 2.4", ": 0", "DISTANCE_AISLE_TO_AISLE, line 10: 0 is not 0.001 to 1e+06; correct"),
        ("CAPACITY : 10.5", "CAPACITY : 0", "PICKER_CAPACITY, line 4: capacity 0 of robot 'R1'"),
        ("CAPACITY : 10.5", "CAPACITY : ten", "line 4: PICKER_CAPACITY ten is not a finite number"),
        ("PICKER_CAPACITY : 10.5\n", "", "PICKER_CAPACITY: is missing; add it to the header"),
        ("LAYOUT : single", "LAYOUT : two", "line 5: the layout two-block is not read; give a"),
        ("Order_batching", "Zone", "line 2: the type ZONE is not planned; give Order_batching"),
        ("LAYOUT", "SHIFT", "line 5: SHIFT is not a field that qRobot knows; remove it if"),
        ("LAYOUT : single", "NAME : x\nLAYOUT : single", "line 5: NAME is given in line 1 too;"),
        ("LAYOUT : ", "LAYOUT ", "line 5: 'LAYOUT single-block' is not a field; write it as"),
        ("ID 7 WEIGHT 1", "ID 2 WEIGHT 1", "line 20: article 2 is given twice; keep one"),
        ("WEIGHT 0.5", "WEIGHT -1", "line 18: weight -1 is negative; use zero or more"),
        ("ID 7 WEIGHT 1\n", "", "line 20: 'SKU_SECTION' is not an entry of this section; write"),
        ("CELL 3", "CELL 4", "line 24: cell 4 is not a whole number from 0 to 3; correct it"),
        ("AISLE 2 ", "AISLE -1 ", "line 25: aisle -1 is not a whole number from 0 to 2;"),
        ("ID 7 AISLE", "ID 6 AISLE", "line 26: article 6 is not in ARTICLE_SECTION; add it there"),
        ("ID 7 AISLE 1 CELL 2", "ID 2 AISLE 2 CELL 1", "line 26: article 2 is in this cell twice;"),
        ("ID 7 AISLE", "ID 2 AISLE", "line 35: article 7 lies nowhere; add its place to SKU_SEC"),
        ("QUANTITY 4", "QUANTITY 0", "line 35: quantity 0 is not a whole number from 1 to"),
        ("ID 7 QUANTITY", "ID 9 QUANTITY", "line 35: article 9 is not in ARTICLE_SECTION;"),
        ("NUM_ORDERS : 2", "NUM_ORDERS : 3", "line 37: 'EOF' stands where NUM_ARTICLES_IN_ORDER"),
        ("NUM_ORDERS : 2", "NUM_ORDERS : 1", "line 34: 'NUM_ARTICLES_IN_ORDER : 2' stands where E"),
        ("QUANTITY 2\nEOF", "QUANTITY 2", "line 36: the file ends where EOF belongs; complete it"),
        ("ORDER : 2", "ORDER : 0", "line 35: 'ID 7 QUANTITY 4' stands where EOF belongs;"),
        ("PICKER_CAPACITY : 10.5", "X", "line 4: 'X' is not a field; write it as NAME : value"),
    ],
)  # fmt: skip
def test_a_fault_is_one_sentence_with_its_line(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert sentence(tmp_path, changed(old, new)).startswith(said)


def test_an_order_without_articles_and_an_article_without_place_are_refused(tmp_path: Path) -> None:
    text = GOOD.replace("ORDER : 2", "ORDER : 0").replace("ID 7 QUANTITY 4\nID 0 QUANTITY 2\n", "")
    assert sentence(tmp_path, text).startswith("line 34: order '2' is empty; name at least one")
    text = GOOD.replace("SKUS : 4", "SKUS : 3")
    text = re.sub("ID 7 AISLE.*\n", "", text)
    assert sentence(tmp_path, text).startswith("line 34: article 7 lies nowhere; add its place")


def test_what_stands_behind_the_end_is_noted(tmp_path: Path) -> None:
    (note,) = read(tmp_path, f"{GOOD}\nrest\n").notes
    assert note == "line 39 and what follows stand behind EOF and are not read"


@pytest.mark.parametrize("name", ["x.vrp", "x.json", "x.csv", "x.lst", "x"])
def test_a_file_with_the_suffix_of_another_format_is_told(tmp_path: Path, name: str) -> None:
    said = sentence(tmp_path, GOOD, name)
    suffix = Path(name).suffix or "no suffix"
    assert said == f"holds the format HI, which {suffix} does not say; name it x.txt"


def test_any_other_text_is_not_taken_for_one(tmp_path: Path) -> None:
    said = sentence(tmp_path, "NAME : A-n32-k5\nDIMENSION : 32\nCAPACITY : 1\n")
    assert said.startswith("is not a HI or Briant file; check the path")


# -- the files that lie beside the project -----------------------------------------

DATA = Path(__file__).parents[3] / "shared" / "data" / "picking"
INDEX = json.loads((DATA / "index.json").read_text()) if DATA.exists() else []
BATCHES = [entry for entry in INDEX if entry["format"] == "HI" and "capacity" in entry]

shared = pytest.mark.skipif(not DATA.exists(), reason="no files of pickers in ../shared/data")


@pytest.mark.slow
@shared
def test_the_shared_files_are_read_as_their_index_says() -> None:
    assert len(BATCHES) > 100
    for entry in BATCHES:
        one = qrobot.read(DATA / entry["file"])
        assert len(one.orders) == entry["orders"]
        assert {r.capacity for r in one.robots} == {entry["capacity"]}
        assert one.notes == ()


@shared
def test_the_tour_of_the_shared_single_picker_is_as_long_as_published() -> None:
    (entry,) = [entry for entry in INDEX if entry["problem"] == "SPRP"]
    one = qrobot.read(DATA / entry["file"])
    shortest = min(one.length([tour]) for tour in itertools.permutations(range(1, one.size + 1)))
    assert math.isclose(shortest, entry["value"])
