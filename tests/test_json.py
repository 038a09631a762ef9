"""JSON that we write is JSON: one writer, no NaN, no Infinity."""

from __future__ import annotations

import ast
import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot._json import json_text
from qrobot.problem.formats.jsontext import dumps

PACKAGE = Path(__file__).resolve().parents[1] / "qrobot"
OWN_WRITERS = {
    "_json.py",
    "card/quoting.py",  # quotes texts
    "problem/formats/fields.py",  # quotes texts
    "problem/formats/jsontext.py",  # keeps every digit
}


def test_all_json_goes_through_one_writer() -> None:
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if (
                isinstance(node, ast.Attribute)
                and node.attr in ("dump", "dumps", "JSONEncoder")
                and isinstance(node.value, ast.Name)
                and node.value.id == "json"
            ):
                assert path.relative_to(PACKAGE).as_posix() in OWN_WRITERS, f"{path}: use json_text"


numbers = st.floats() | st.integers() | st.text(max_size=3) | st.none()
data = st.recursive(
    numbers,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(max_size=3), inner, max_size=3)
        | st.tuples(inner, inner)
    ),
)


def refuse(text: str) -> float:
    raise AssertionError(f"{text} is not JSON")


@given(data, st.booleans())
def test_whatever_is_written_is_read_by_strict_readers(value: object, ascii_only: bool) -> None:
    text = json_text(value, indent=1, ensure_ascii=ascii_only)
    json.loads(text, parse_constant=refuse)


def test_finite_numbers_stay_and_others_become_null() -> None:
    assert json.loads(json_text([0.1, math.nan, {"a": -math.inf}])) == [0.1, None, {"a": None}]


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_an_instance_is_never_written_with_a_number_that_is_none(value: float) -> None:
    with pytest.raises(ValueError, match="not a number of JSON"):
        dumps({"a": [value]})
