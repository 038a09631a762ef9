"""A good native document, changed field by field, and its sentence when it is refused."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.problem import Instance
from qrobot.problem.formats.schema import SCHEMA

GOOD: dict[str, Any] = {
    "schema": "qrobot.instance/1",
    "warehouse": {
        "kind": "aisles",
        "aisles": 3,
        "blocks": 2,
        "slots": 4,
        "aisle_pitch": 3,
        "slot_pitch": 1,
        "end_gap": 1.5,
        "depot": {"aisle": 0, "cross_aisle": 0, "distance": 0},
        "closed_aisles": [{"aisle": 2, "block": 1}],
        "closed_crossings": [{"cross_aisle": 0, "aisle": 1}],
        "one_way_aisles": [{"aisle": 1, "block": 0, "towards": "back"}],
        "one_way_crossings": [{"cross_aisle": 1, "aisle": 0, "towards": "left"}],
    },
    "robots": {"count": 2, "capacity": 15.5, "speed": 1.2, "trips": 1},
    "items": [
        {"id": "a", "weight": 0.1, "at": {"aisle": 0, "block": 1, "slot": 2, "side": "right"}},
        {"id": "b", "weight": 3, "at": {"aisle": 1, "slot": 3}},
    ],
    "orders": [{"id": "o", "items": ["a", "b"]}],
}


def read(folder: Path, document: object, name: str = "x.json", **options: Any) -> Instance:
    text = document if isinstance(document, str) else json.dumps(document)
    (folder / name).write_text(text, encoding="utf-8")
    return qrobot.read(folder / name, **options)


def sentence(folder: Path, document: object, **options: Any) -> str:
    """Return the error, without the file's name that it must begin with, and without the place.

    tests/problem/test_fault_places.py holds line and column.
    """
    with pytest.raises(InputError) as caught:
        read(folder, document, **options)
    text = str(caught.value)
    path = f"{folder / 'x.json'}: "
    assert text.startswith(path)
    assert "; " in text
    assert "\n" not in text
    assert len(text) < len(path) + 300
    return without_place(text.removeprefix(path))


def without_place(said: str) -> str:
    """Leave line and column out of a sentence."""
    return re.sub(r", line \d+, column \d+(?=: )|^line \d+, column \d+: ", "", said, count=1)


def changed(path: str, value: object) -> dict[str, Any]:
    """Return the good document with one field set, or removed with ``...``."""
    document = copy.deepcopy(GOOD)
    *parents, last = [int(p) if p.isdigit() else p for p in path.split(".")]
    target: Any = document
    for part in parents:
        target = target[part]
    if value is ...:
        del target[last]
    else:
        target[last] = value
    return document


json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4)
    ),
    max_leaves=12,
)


def paths(value: object, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    found = [path] if path else []
    for key in (
        value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    ):
        found += paths(value[key], (*path, key))  # type: ignore[index]
    return found


def matrix(rows: object, **more: object) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "warehouse": {"kind": "matrix", "matrix": rows, **more},
        "robots": {"count": 1, "capacity": 9},
        "items": [{"id": "a", "weight": 1, "at": {"node": 1}}],
    }
