"""An export of a warehouse management system, written into a folder and read.

>>> from exports import COLUMNS, read
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance

__all__ = [
    "ARTICLES", "COLUMNS", "LAYOUT", "LOCATIONS", "MAPPING", "ORDERS", "read", "refusal", "write",
]  # fmt: skip

LAYOUT = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "aisles", "aisles": 3, "blocks": 2, "slots": 4},
    "robots": {"count": 2, "capacity": 1000},
}
ORDERS = "OrderNo;SKU;BIN;Qty\nA1;10-1;A01-03-2;2\nA1;10-2;B02-01-1;1\nA2;10-1;A01-03-2;3\n"
LOCATIONS = (
    "label,aisle,block,slot,side,level\nA01-03-1,0,1,2,left,1\nA01-03-2,0,1,2,left,2\n"
    "B02-01-1,1,0,0,right,1\n"
)
ARTICLES = "article;weight;volume;class\n10-1;2,5;0,75;tools\n10-2;1,25;3;\n"
COLUMNS = {"order": "OrderNo", "article": "SKU", "place": "BIN", "quantity": "Qty"}
MAPPING = ",".join(f"{ours}={theirs}" for ours, theirs in COLUMNS.items())


def write(folder: Path, **files: str | None) -> Path:
    """Write an export and what lies beside it; ``None`` leaves a file out."""
    wave = {"orders": ORDERS, "locations": LOCATIONS, "articles": ARTICLES} | files
    for kind, text in wave.items():
        name = "wave.csv" if kind == "orders" else f"wave.{kind}.csv"
        (folder / name).unlink(missing_ok=True)
        if text is not None:
            (folder / name).write_text(text)
    (folder / "layout.json").write_text(json.dumps(LAYOUT))
    return folder / "wave.csv"


def read(folder: Path, columns: Any = COLUMNS, more: Any = None, **files: str | None) -> Instance:
    return qrobot.read(write(folder, **files), columns=columns, **(more or {}))


def refusal(folder: Path, columns: Any = COLUMNS, more: Any = None, **files: str | None) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, columns, more, **files)
    said = str(caught.value)
    assert "\n" not in said
    assert "; " in said
    return said.removeprefix(f"{folder}/")
