"""The time of a pick: read, written, checked."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

import qrobot

ONE = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "floor"},
    "robots": {"count": 1, "capacity": 5},
    "items": [
        {"id": "a", "weight": 1, "at": {"x": 3, "y": 4}, "pick_seconds": 7.5},
        {"id": "b", "weight": 1, "at": {"x": 0, "y": 4}},
    ],
}


def write(folder: Path, document: object, name: str = "one.json") -> Path:
    path = folder / name
    path.write_text(json.dumps(document))
    return path


def test_it_goes_round_and_is_zero_by_itself(tmp_path: Path) -> None:
    instance = qrobot.read(write(tmp_path, ONE))
    assert [item.pick_seconds for item in instance.items] == [7.5, 0.0]
    qrobot.write(instance, tmp_path / "again.json")
    assert qrobot.read(tmp_path / "again.json") == instance
    items = json.loads((tmp_path / "again.json").read_text())["items"]
    assert "pick_seconds" in items[0]
    assert "pick_seconds" not in items[1]


@pytest.mark.parametrize("wrong", [-1, 1e7, "7", None])
def test_a_file_with_another_value_is_refused(tmp_path: Path, wrong: object) -> None:
    items = [ONE["items"][0] | {"pick_seconds": wrong}]  # type: ignore[index]
    with pytest.raises(qrobot.InputError, match="pick_seconds"):
        qrobot.read(write(tmp_path, ONE | {"items": items}))


@pytest.mark.parametrize("wrong", [-1.0, math.nan, math.inf])
def test_an_instance_with_another_value_is_refused(tmp_path: Path, wrong: float) -> None:
    instance = qrobot.read(write(tmp_path, ONE))
    items = (replace(instance.items[0], pick_seconds=wrong), instance.items[1])
    with pytest.raises(qrobot.InputError, match=r"items\[0\]\.pick_seconds"):
        replace(instance, items=items)


def test_a_column_holds_the_seconds_of_one_piece(tmp_path: Path) -> None:
    layout = {k: ONE[k] for k in ("schema", "warehouse", "robots")}
    write(tmp_path, layout, "layout.json")
    orders = tmp_path / "orders.csv"
    orders.write_text("order,item,weight,quantity,pick_seconds,x,y\nA,a,1,3,2.5,1,2\n")
    assert qrobot.read(orders).items[0].pick_seconds == 7.5
    orders.write_text("order,item,weight,pick_seconds,x,y\nA,a,1,-2,1,2\n")
    with pytest.raises(qrobot.InputError, match="line 2, column pick_seconds"):
        qrobot.read(orders)
