"""How many pieces of which article an item is: read, written, checked."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import qrobot

ROOT = Path(__file__).resolve().parents[2]
ITEM: dict[str, Any] = {"id": "a", "weight": 6, "at": {"x": 3, "y": 4}}


def write(path: Path, **more: object) -> Path:
    document = {
        "schema": "qrobot.instance/1",
        "warehouse": {"kind": "floor"},
        "robots": {"count": 1, "capacity": 9},
        "items": [ITEM | more],
    }
    path.write_text(json.dumps(document))
    return path


def test_they_go_round(tmp_path: Path) -> None:
    one = qrobot.read(write(tmp_path / "one.json", quantity=3, article="drill"))
    assert (one.items[0].quantity, one.items[0].article, one.items[0].weight) == (3, "drill", 6)
    qrobot.write(one, tmp_path / "again.json")
    assert qrobot.read(tmp_path / "again.json") == one


def test_they_are_one_piece_of_its_own_name_by_themselves(tmp_path: Path) -> None:
    one = qrobot.read(write(tmp_path / "one.json"))
    assert (one.items[0].quantity, one.items[0].article) == (1, "")
    qrobot.write(one, tmp_path / "again.json")
    assert {"quantity", "article"}.isdisjoint(
        json.loads((tmp_path / "again.json").read_text())["items"][0]
    )


@pytest.mark.parametrize(
    "wrong",
    [{"quantity": 0}, {"quantity": 1.5}, {"quantity": "2"}, {"article": ""}, {"article": "a\nb"},
     {"article": 1}, {"article": None}],
)  # fmt: skip
def test_a_file_with_another_value_is_refused(tmp_path: Path, wrong: dict[str, object]) -> None:
    with pytest.raises(qrobot.InputError, match=rf"items\[0\]\.{next(iter(wrong))}"):
        qrobot.read(write(tmp_path / "one.json", **wrong))


@pytest.mark.parametrize("wrong", [{"quantity": 0}, {"article": "a\u200bb"}])
def test_an_instance_with_another_value_is_refused(tmp_path: Path, wrong: dict[str, Any]) -> None:
    one = qrobot.read(write(tmp_path / "one.json"))
    with pytest.raises(qrobot.InputError, match=rf"items\[0\]\.{next(iter(wrong))}"):
        replace(one, items=(replace(one.items[0], **wrong),))


def test_orders_as_csv_keep_article_and_quantity() -> None:
    lines = (ROOT / "examples/orders.csv").read_text().splitlines()[1:]
    want = [(line.split(",")[1], int(line.split(",")[2])) for line in lines]
    items = qrobot.read(ROOT / "examples/orders.csv").items
    assert [(item.article or item.id, item.quantity) for item in items] == want
    assert len({item.id for item in items}) == len(items) > len({name for name, _ in want})
