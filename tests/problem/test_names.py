"""Names that look the same are the same, in every format; what cannot be seen is refused."""

from __future__ import annotations

import json
import unicodedata
from pathlib import Path
from typing import Any

import pytest

import qrobot
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

LAYOUT: dict[str, Any] = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "floor"},
    "robots": [{"id": "Rö", "capacity": 10}],
}
COMPOSED = ["Büro", "Å1", "한글", "\u00e9t\u00e9", "A B"]
OTHER = [unicodedata.normalize("NFD", name) for name in COMPOSED[:4]] + ["A\u00a0B"]
SAME = list(zip(COMPOSED, OTHER, strict=True))


def document(orders: list[tuple[str, list[str]]], ids: list[str]) -> dict[str, Any]:
    items = [{"id": id_, "weight": 1, "at": {"x": k, "y": 1}} for k, id_ in enumerate(ids)]
    return LAYOUT | {"items": items, "orders": [{"id": o, "items": i} for o, i in orders]}


def read_json(folder: Path, data: object) -> Instance:
    (folder / "x.json").write_text(json.dumps(data))
    return qrobot.read(folder / "x.json")


def read_csv(folder: Path, rows: list[str]) -> Instance:
    (folder / "layout.json").write_text(json.dumps(LAYOUT))
    (folder / "x.csv").write_text("\n".join(["order,item,weight,x,y", *rows]), encoding="utf-8")
    return qrobot.read(folder / "x.csv")


@pytest.mark.parametrize(("name", "other"), SAME)
def test_two_spellings_are_one_name(tmp_path: Path, name: str, other: str) -> None:
    assert name != other
    one = read_csv(tmp_path, [f"{name},p,1,0,1", f"{other},q,1,1,1"])
    assert [order.items for order in one.orders] == [("p", "q")]
    one = read_json(tmp_path, document([("o", [other])], [name]))
    assert one.orders[0].items == (one.items[0].id,)
    with pytest.raises(InputError, match=r"items\[1\]\.id, .*is used twice"):
        read_json(tmp_path, document([("o", [name, other])], [name, other]))
    with pytest.raises(InputError, match=r"orders\[1\]\.id, .*is used twice"):
        read_json(tmp_path, document([(name, ["a"]), (other, ["b"])], ["a", "b"]))
    made = Instance(
        OpenFloor(), (Item(other, 1, Point(0, 1)),), (Order("o", (name,)),), (Robot(other, 2),)
    )
    assert made.items[0].id == made.orders[0].items[0] == made.robots[0].id


@pytest.mark.parametrize(("name", "other"), SAME)
def test_plan_files_may_spell_names_either_way(tmp_path: Path, name: str, other: str) -> None:
    one = read_json(tmp_path, document([(name, [name])], [name]))
    plan = qrobot.solve(one, max_work=10).plan.to_dict()
    plan["trips"][0] |= {"stops": [other], "orders": [other]}
    plan["trips"][0]["robot"] = unicodedata.normalize("NFD", "Rö")
    assert qrobot.check(Plan.from_dict(plan), one).ok


HIDDEN = ["\u202e", "\u200b", "\u200e", "\u2066", "\ufeff", "\u00ad", "\u0007", "\u2028", "\ud800"]


@pytest.mark.parametrize("sign", HIDDEN, ids=[f"U+{ord(c):04X}" for c in HIDDEN])
def test_what_cannot_be_seen_is_refused_everywhere(tmp_path: Path, sign: str) -> None:
    name = f"a{sign}b"
    ways: list[Any] = [
        lambda: read_json(tmp_path, document([("o", [name])], [name])),
        lambda: read_json(tmp_path, document([(name, ["a"])], ["a"])),
        lambda: read_json(tmp_path, LAYOUT | {"robots": [{"id": name, "capacity": 1}]}),
        lambda: read_json(tmp_path, document([], []) | {"name": name}),
        lambda: Instance(
            OpenFloor(), (Item(name, 1, Point(0, 1)),), (Order("o", (name,)),), (Robot("R", 2),)
        ),
    ]
    if sign not in ("\u2028", "\ud800"):
        ways.append(lambda: read_csv(tmp_path, [f"o,{name},1,0,1"]))
        ways.append(lambda: read_csv(tmp_path, [f"{name},i,1,0,1"]))
        ways.append(lambda: read_vrp(tmp_path, name))
    for way in ways:
        with pytest.raises(InputError) as caught:
            way()
        assert sign not in str(caught.value)


def read_vrp(folder: Path, name: str) -> Instance:
    text = f"NAME : {name}\nTYPE : CVRP\nVEHICLES : 1\nDIMENSION : 2\nCAPACITY : 3\n"
    text += "EDGE_WEIGHT_TYPE : EUC_2D\nNODE_COORD_SECTION\n1 0 0\n2 9 9\n"
    text += "DEMAND_SECTION\n1 0\n2 1\nDEPOT_SECTION\n1\n-1\nEOF\n"
    (folder / "x.vrp").write_text(text, encoding="utf-8")
    return qrobot.read(folder / "x.vrp")


def test_a_vrp_name_that_is_visible_is_kept(tmp_path: Path) -> None:
    assert read_vrp(tmp_path, "Köln\t 7").name == "Köln 7"
