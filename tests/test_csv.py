"""CSV for spreadsheets: every text comes back, and none of them is computed."""

from __future__ import annotations

import csv
import io
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot._csv import csv_text

ODD = st.text(st.sampled_from("=+-@＝'\" ,;|\t\n\rab1<&\u202e\u05d0"), max_size=12)


def read_back(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text, newline="")))


@given(st.lists(st.tuples(ODD, ODD), max_size=5))
def test_no_cell_begins_a_formula_and_nothing_else_is_changed(rows: list[tuple[str, str]]) -> None:
    text = csv_text([{"a": a, "b": b, "more": 1} for a, b in rows], ("a", "b"))
    heads, *cells = read_back(text)
    assert heads == ["a", "b"]
    assert len(cells) == len(rows)
    for row, kept in zip(rows, cells, strict=True):
        for before, after in zip(row, kept, strict=True):
            same = before.replace("\r\n", "\n").replace("\r", "\n")
            assert after.replace("'", "") == same.replace("'", "")
            # However a program cuts the cell: by any separator, with quotes and blanks left out.
            for part in re.split(r"[,;|\t\r\n]", after):
                assert part.lstrip(' "').lstrip()[:1] not in tuple("=+-@＝")


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", " =1", "a;=1", "＝1"])
def test_a_formula_becomes_text(text: str) -> None:
    assert f"'{text.lstrip(' a;')}" in read_back(csv_text([{"a": text}], ["a"]))[1][0]


def test_numbers_stay_numbers_and_plain_names_as_they_are() -> None:
    rows = [{"a": -1.5, "b": "SKU-109/A=1", "c": None}]
    assert csv_text(rows, ("a", "b", "c")) == "a,b,c\n-1.5,SKU-109/A=1,\n"
