"""Files of Lorenci, of our own making, and the shared ones where they are."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import networkx as nx
import pytest

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance, Slot

LAYOUT = "3\n4\n0.5\n1.5\n2\n9\n5\n2\n"
ORDERS = "0 3\n0 1 3\n1 4 0\n2 5 0\n4 1\n0 2 2\n0 0\n"


def read(
    folder: Path, orders: str = ORDERS, layout: str | None = LAYOUT, **options: Any
) -> Instance:
    (folder / "own-9s-2-5.ord").write_text(orders)
    if layout is not None:
        (folder / "own-9.lyt").write_text(layout)
    return qrobot.read(folder / "own-9s-2-5.ord", **options)


def sentence(folder: Path, orders: str = ORDERS, layout: str | None = LAYOUT, **opts: Any) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, orders, layout, **opts)
    said = str(caught.value)
    assert said.startswith(f"{folder}/own-9")
    assert "; " in said
    assert "\n" not in said
    return said.removeprefix(f"{folder}/own-9")


def test_lines_of_an_order_are_its_items(tmp_path: Path) -> None:
    one = read(tmp_path)
    assert [(o.id, o.items) for o in one.orders] == [
        ("0", ("0/0", "0/1", "0/2")), ("4", ("4/0",)),
    ]  # fmt: skip
    assert one.order_weights.tolist() == [3, 1]
    assert [r.capacity for r in one.robots] == [5, 5]
    assert [i.place for i in one.items] == [
        Slot(0, 3, side="right"), Slot(2, 0), Slot(2, 0, side="right"), Slot(1, 2),
    ]  # fmt: skip
    assert one.notes == ()
    (note,) = read(tmp_path, ORDERS + "9 1\n0 0 0\n").notes
    assert note == "2 of 3 orders are read, as own-9.lyt says"


def test_distances_are_those_of_the_graph_of_positions(tmp_path: Path) -> None:
    cells = [(a, p) for a in range(3) for p in range(4)]
    lines = "".join(f"{i} {2 * a} {p}\n" for i, (a, p) in enumerate(cells))
    one = read(tmp_path, f"0 {len(cells)}\n{lines}", LAYOUT.replace("\n2\n", "\n1\n"), capacity=12)
    graph = nx.Graph()
    for a in range(3):
        for p in range(-1, 3):  # the front is one length before the first position
            graph.add_edge((a, p), (a, p + 1), weight=0.5)
        for p in (-1, 3):
            graph.add_edge((a, p), (a + 1, p), weight=3)
    graph.remove_nodes_from([(3, -1), (3, 3)])
    nodes = [(0, -1), *cells]
    far = dict(nx.all_pairs_dijkstra_path_length(graph))
    assert one.distances.tolist() == [pytest.approx([far[a][b] for b in nodes]) for a in nodes]
    qrobot.write(one, tmp_path / "x.json")
    assert qrobot.read(tmp_path / "x.json").warehouse == one.warehouse


def test_the_layout_is_the_one_that_the_orders_are_named_after(tmp_path: Path) -> None:
    assert sentence(tmp_path, layout=None).startswith("s-2-5.ord: has no layout (.lyt) beside it")
    for name, capacity in (("own", "6"), ("own-9", "7"), ("own-99", "8"), ("other", "9")):
        (tmp_path / f"{name}.lyt").write_text(LAYOUT.replace("\n5\n", f"\n{capacity}\n"))
    assert read(tmp_path, layout=None).robots[0].capacity == 7
    (tmp_path / "own-9.lyt").unlink()
    assert read(tmp_path, layout=None).robots[0].capacity == 6
    (tmp_path / "own.lyt").unlink()
    assert "has no layout" in sentence(tmp_path, layout=None)
    (tmp_path / "own-99.lyt").unlink()
    assert read(tmp_path, layout=None).robots[0].capacity == 9
    other = tmp_path / "other.lyt"
    assert read(tmp_path, layout=LAYOUT).robots[0].capacity == 5
    (tmp_path / "own-9s-2-5.ord").write_text(ORDERS)
    assert qrobot.read(tmp_path / "own-9s-2-5.ord", layout=other).robots[0].capacity == 9


@pytest.mark.parametrize(
    ("orders", "layout", "said"),
    [
        ("0 1\n0 6 0\n", LAYOUT, "s-2-5.ord: line 2: aisle 6 is outside the layout; use 0 to 5"),
        ("0 1\n0 5 4\n", LAYOUT, "s-2-5.ord: line 2: position 4 is outside the layout; use 0 to 3"),
        ("0 1\n0 5\n", LAYOUT, "s-2-5.ord: line 2: '0 5' is not an item, its aisle and its"),
        ("0 2\n0 5 3\n", LAYOUT, "s-2-5.ord: line 2: the file ends where an item of order 0"),
        ("0 1\n0 5 3\n1 5 3\n", LAYOUT, "s-2-5.ord: line 3: '1 5 3' is not an order and its"),
        ("0 1\n0 5 3\n", LAYOUT, "s-2-5.ord: 1 orders where own-9.lyt says 2; complete the file"),
        ("0 1\n0 0 0\n0 1\n0 0 0\n", LAYOUT, "s-2-5.ord: line 3: order 0 is in line 1 too; num"),
        (
            "0 2\n0 0 0\n0 0 1\n1 1\n0 0 0\n",
            LAYOUT,
            "s-2-5.ord: line 3: the id '0/0' is used tw",
        ),
        ("0 0\n1 1\n0 0 0\n", LAYOUT, "s-2-5.ord: line 1: order '0' is empty; name at least one"),
        ("0 1\n0 x 0\n", LAYOUT, "s-2-5.ord: line 2: the number x is not a whole number from 0"),
        (ORDERS, LAYOUT.replace("1.5", "wide"), ".lyt: line 4: width of a position wide is not"),
        (ORDERS, LAYOUT.replace("1.5", "0"), ".lyt: line 4: 0 is not 0.001 to 1e+06; correct"),
        (ORDERS, LAYOUT + "1\n", ".lyt: line 9: is one line too many; give 8 lines"),
        (ORDERS, LAYOUT[:-2], ".lyt: line 7: the file ends where the number of orders belongs;"),
        (
            ORDERS,
            LAYOUT.replace("\n5\n", "\n0\n"),
            ".lyt: line 7: capacity 0 is not positive; use",
        ),
    ],
)
def test_a_fault_is_one_sentence_with_file_and_line(
    tmp_path: Path, orders: str, layout: str, said: str
) -> None:
    assert sentence(tmp_path, orders, layout).startswith(said)


# -- the files that lie beside the project -----------------------------------------

DATA = Path(__file__).parents[3] / "shared" / "data" / "picking"
INDEX = json.loads((DATA / "index.json").read_text()) if DATA.exists() else []


@pytest.mark.skipif(not INDEX, reason="no files of pickers in ../shared/data")
def test_the_shared_file_has_its_published_optimum() -> None:
    """Every set of orders that fits is a trip; the best partition costs the published value."""
    from qrobot.warehouse import Router

    (entry,) = [entry for entry in INDEX if entry["format"] == "LORENCI"]
    one = qrobot.read(DATA / entry["file"])
    assert len(one.orders) == entry["orders"]
    assert {r.capacity for r in one.robots} == {entry["capacity"]}
    router, places = Router(one.warehouse), {item.id: item.place for item in one.items}
    everyone = range(len(one.orders))
    trips = {}
    for size in everyone:
        for chosen in itertools.combinations(everyone, size):
            if one.order_weights[list(chosen)].sum() <= entry["capacity"]:
                stops = [places[i] for o in chosen for i in one.orders[o].items]
                trips[sum(1 << o for o in chosen)] = router.length(stops)
    best = {0: 0.0}
    for done in range(1, 1 << len(one.orders)):
        first = done & -done
        best[done] = min(
            best[done ^ trip] + length
            for trip, length in trips.items()
            if trip & first and trip & done == trip
        )
    assert max(best) == (1 << len(one.orders)) - 1
    assert best[max(best)] == entry["value"]
