"""What docs/formats.md shows can be read."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import qrobot
from qrobot.problem import MAX_ITEMS, MAX_STOPS
from qrobot.problem.warehouse import MAX_CROSSINGS

PAGE = (Path(__file__).parents[2] / "docs" / "formats.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("text", blocks("json"))
def test_the_documents_are_read(tmp_path: Path, text: str) -> None:
    (tmp_path / "x.json").write_text(text)
    assert qrobot.read(tmp_path / "x.json").size


def test_the_orders_are_read_with_the_first_layout(tmp_path: Path) -> None:
    document = json.loads(blocks("json")[0])
    layout = {key: value for key, value in document.items() if key not in ("items", "orders")}
    (tmp_path / "layout.json").write_text(json.dumps(layout))
    (tmp_path / "orders.csv").write_text(blocks("csv")[0])
    one = qrobot.read(tmp_path / "orders.csv")
    assert [i.id for i in one.items] == ["drill", "A1/screws", "A2/screws"]
    assert one.items[1].weight == 1


def test_the_limits_are_those_of_the_code() -> None:
    assert f"{MAX_ITEMS:,} items at {MAX_STOPS:,} stops" in PAGE
    assert f"{MAX_CROSSINGS:,} crossings" in PAGE
