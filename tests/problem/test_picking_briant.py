"""Files of Briant and others, of our own making, and the shared ones where they are."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest

import qrobot
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, DistanceTable, Instance, Slot

AISLES = (2.5, 7.5, 12.5)
CROSS_AISLES = (1.5, 7.5, 12.5)
PICKS = {
    1: (2.5, 3.0), 2: (2.5, 4.5), 3: (7.5, 9.0), 4: (12.5, 6.0), 5: (12.5, 10.5), 6: (7.5, 3.0),
}  # fmt: skip
DEPOT = (2.5, -1.0)
ORDERS = "1 2 3 1 4 3 1 1 2\n2 1 2 4 1 5 3\n7 1 1 6 2\n"


def points() -> dict[int, tuple[float, float]]:
    grid = ((x, y) for x in AISLES for y in CROSS_AISLES)
    found = {0: DEPOT} | PICKS | {7 + k: at for k, at in enumerate(grid)}
    return found | {len(found): DEPOT}


def arcs() -> nx.Graph:
    """Neighbours along aisles and cross aisles; the depot's straight lines, as files round them."""
    at = points()
    end = len(at) - 1
    graph = nx.Graph()
    inside = {k: xy for k, xy in at.items() if xy != DEPOT}
    for x in AISLES:
        chain = sorted((y, k) for k, (x_, y) in inside.items() if x_ == x)
        for (y0, a), (y1, b) in itertools.pairwise(chain):
            graph.add_edge(a, b, weight=y1 - y0)
    for y in CROSS_AISLES:
        chain = sorted((x, k) for k, (x, y_) in inside.items() if y_ == y)
        for (x0, a), (x1, b) in itertools.pairwise(chain):
            graph.add_edge(a, b, weight=x1 - x0)
    for k, xy in inside.items():
        if xy[1] == CROSS_AISLES[0]:
            for depot in (0, end):
                graph.add_edge(depot, k, weight=round(math.dist(xy, DEPOT), 2))
    return graph


def ways() -> dict[tuple[int, int], float]:
    graph = arcs()
    return {
        (a, b): round(length, 6)
        for a in graph
        for b, length in nx.single_source_dijkstra_path_length(graph, a).items()
    }


def text_of(far: dict[tuple[int, int], float] | None = None, orders: str = ORDERS) -> str:
    far = ways() if far is None else far
    at = points()
    rows = "".join(f"{k} {k} 1\n" for k in PICKS)
    edges = "".join(f"{a} {b} {w}\n{b} {a} {w}\n" for a, b, w in arcs().edges(data="weight"))
    pairs = "".join(f"{a} {b} {w}\n" for (a, b), w in far.items())
    names = "".join(f'{k} {x} {y} "place {k}"\n' for k, (x, y) in at.items())
    return (
        f"//NbLocations\n{len(at) - 1}\n//NbProducts\n{len(PICKS)}\n//K: NbBoxesTrolley\n3\n"
        "//NbDimensionsCapacity\n1\n//B: CapaBox \n40\n"
        "//A box can accept mixed orders(0: no, 1: yes)\n1\n"
        f"//Products\n//Idx Location Volume\n{rows}//Orders\n//Nb Orders\n3\n"
        f"//Idx M NbProdInOrder ProdIdx1 Qty1 ProdIdx2 Qty2 ...\n{orders}"
        "//Graph (Products are vertices indexed from 1 to NbLocations)\n"
        f"//NbVerticesIntersections\n9\n//DepartingDepot\n0\n//ArrivalDepot\n{len(at) - 1}\n"
        f"//Arcs\n//Start End Distance\n{edges}//LocStart LocEnd ShortestPath\n{pairs}"
        f"//Vertices coordinates LocationName\n{names}"
    )


GOOD = text_of()


def read(folder: Path, text: str, name: str = "x.txt", **options: Any) -> Instance:
    (folder / name).write_bytes(text.replace("\n", "\r\n").encode("latin-1"))
    return qrobot.read(folder / name, **options)


def sentence(folder: Path, text: str, name: str = "x.txt") -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text, name)
    said = str(caught.value)
    assert said.startswith(f"{folder / name}: ")
    assert "; " in said
    assert "\n" not in said
    return said.removeprefix(f"{folder / name}: ")


def test_orders_fill_whole_boxes_and_repeated_products_add_up(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    assert [(o.id, o.items) for o in one.orders] == [
        ("1", ("1/1", "1/3")), ("2", ("2/4", "2/5")), ("7", ("7/6",)),
    ]  # fmt: skip
    assert [i.quantity for i in one.items] == [6, 1, 1, 3, 2]
    assert [int(w) for w in one.order_weights] == [2, 1, 1]
    assert [r.capacity for r in one.robots] == [3, 3, 3]
    assert read(tmp_path, GOOD, capacity=4).robots[0].capacity == 4


def test_the_layout_of_two_unlike_blocks_gives_the_distances_of_the_file(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD)
    house = one.warehouse
    assert isinstance(house, AisleWarehouse)
    assert (house.aisles, house.blocks, house.block_lengths) == (3, 2, (6, 5))
    assert len(house.depot_ways) == 2
    assert one.items[1].place == Slot(1, 0, 1)
    check_distances(one, ways())
    qrobot.write(one, tmp_path / "x.json")
    again = qrobot.read(tmp_path / "x.json")
    assert (again.warehouse, again.items, again.orders) == (house, one.items, one.orders)


def check_distances(one: Instance, far: dict[tuple[int, int], float]) -> None:
    rows = [0, *(int(item.article) for item in one.items)]  # product k lies in location k
    ends = [max(a for a, _ in far), *rows[1:]]
    expected = [[0 if a == b else far[a, b] for b in ends] for a in rows]
    expected[0][0] = 0
    assert np.allclose(one.distances, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("pair", [(4, 3), (0, 5), (5, 16)])
def test_other_distances_than_those_of_aisles_are_a_table(
    tmp_path: Path, pair: tuple[int, int]
) -> None:
    far = ways()
    far[pair] += 1
    one = read(tmp_path, text_of(far))
    assert isinstance(one.warehouse, DistanceTable)
    assert one.notes[0].startswith("the locations do not make up an aisle warehouse: the distances")
    check_distances(one, far)


def test_places_off_the_aisles_are_a_table(tmp_path: Path) -> None:
    one = read(tmp_path, GOOD.replace("\n4 12.5 6.0", "\n4 12.25 6.0"))
    assert isinstance(one.warehouse, DistanceTable)
    check_distances(one, ways())


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("Products\n6\n", "Products\n5\n", "line 14: 6 products where NbProducts is 5; complete"),
        ("Orders\n3\n", "Orders\n4\n", "line 24: 3 orders where Nb Orders is 4; complete"),
        ("\n6 6 1\n", "\n5 6 1\n", "line 20: product 5 is given twice; keep one of the lines"),
        ("\n6 6 1\n", "\n6 8 1\n", "line 20: location 8 of product 6 is not a place in an aisle;"),
        ("\n6 6 1\n", "\n6\n", "line 20: 1 numbers where 2 belong; complete the section"),
        ("\n7 1 1 6 2\n", "\n2 1 1 6 2\n", "line 27: order 2 is in line 26 too; number each once"),
        ("1 1 6 2", "1 2 6 2", "line 27: 2 numbers where 2 products and quantities belong; comp"),
        ("1 1 6 2", "1 1 9 2", "line 27: order 7 names the unknown product 9; add the product"),
        ("1 1 6 2", "1 1 6 0", "line 27: 0 pieces of product 6; use a number from 1"),
        ("1 1 6 2", "1 1 6 x", "line 27: the number x is not a whole number from 0 to"),
        ("1 1 6 2", "1 0", "line 27: order '7' is empty; name at least one item or remove the"),
        ("Trolley\n3\n", "Trolley\n0\n", "line 6: the number 0 is not a whole number from 1 to"),
        ("Trolley\n3\n", "Trolley\n", "line 5: 0 lines where one number belongs; complete"),
        ("//K: Nb", "//C: Nb", "//K: is missing; add it (the file may be cut)"),
        ('6 7.5 3.0 "', '6 7,5 3.0 "', "line 382: the coordinate 7,5 is not a finite number;"),
    ],
)
def test_a_fault_is_one_sentence_with_its_line(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert GOOD.count(old) == 1, old
    assert sentence(tmp_path, GOOD.replace(old, new)).startswith(said)


def test_a_location_that_nothing_leads_to_is_told(tmp_path: Path) -> None:
    far = {pair: length for pair, length in ways().items() if 6 not in pair}
    said = sentence(tmp_path, text_of(far))
    assert said.startswith("line 27: no way leads from the depot to items 7/6 ")


def test_a_file_that_was_cut_off_is_told(tmp_path: Path) -> None:
    cut = GOOD[: GOOD.index("//Vertices")]
    assert sentence(tmp_path, cut) == "//Vertices: is missing; add it (the file may be cut)"


def test_the_suffix_of_another_format_is_told(tmp_path: Path) -> None:
    said = sentence(tmp_path, GOOD, "x.vrp")
    assert said == "holds the format Briant, which .vrp does not say; name it x.txt"
    said = sentence(tmp_path, "NbLocations\n" + GOOD)
    assert said.startswith("is not a HI or Briant file; check the path, or correct its header")


# -- the files that lie beside the project -----------------------------------------

DATA = Path(__file__).parents[3] / "shared" / "data" / "picking"
INDEX = json.loads((DATA / "index.json").read_text()) if DATA.exists() else []


@pytest.mark.skipif(not INDEX, reason="no files of pickers in ../shared/data")
def test_the_shared_files_are_two_blocks_with_all_their_distances() -> None:
    entries = [entry for entry in INDEX if entry["format"] == "BRIANT"]
    assert entries
    for entry in entries:
        one = qrobot.read(DATA / entry["file"])
        assert len(one.orders) == entry["orders"]
        assert f"{one.robots[0].capacity} boxes of 40" == entry["capacity"]
        assert one.warehouse.kind == "aisles"
        lines = (DATA / entry["file"]).read_text().splitlines()
        title = {line: n for n, line in enumerate(lines) if line.startswith("//")}
        pairs = lines[title["//LocStart LocEnd ShortestPath"] + 1 :]
        far = {
            (int(a), int(b)): float(length)
            for a, b, length in map(str.split, itertools.takewhile(lambda x: x[0] != "/", pairs))
        }
        products = lines[title["//Idx Location Volume"] + 1 : title["//Orders"]]
        location = dict(line.split()[:2] for line in products)
        rows = [0, *(location[item.article] for item in one.items)]
        expected = [[far[int(a), int(b)] for b in rows] for a in rows]
        assert np.allclose(one.distances, expected, rtol=0, atol=1e-9)
