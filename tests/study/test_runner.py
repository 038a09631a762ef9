"""What all studies share: results are kept one by one, and shown alike."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from qrobot.study.render import figure_text, markdown_table, percent, write_csv
from qrobot.study.runner import Part, run_parts


def started() -> dict[str, Any]:
    return {"interrupted": False, "rows": [], "figures": []}


def plain(number: int) -> dict[str, Any]:
    return {"number": number}


@pytest.mark.parametrize("by", ["ctrl-c", "question"])
def test_an_interrupted_run_keeps_what_it_has(by: str) -> None:
    report, saved, seen = started(), [], []

    def rows() -> Iterator[int]:
        yield from (1, 2)
        if by == "ctrl-c":
            raise KeyboardInterrupt
        yield 3

    def figures() -> Iterator[int]:
        raise AssertionError("the next part has begun")
        yield 0

    run_parts(
        report,
        [Part("rows", rows(), plain, seen.append), Part("figures", figures(), plain)],
        lambda: saved.append((len(report["rows"]), report["interrupted"])),
        (lambda: len(seen) == 2) if by == "question" else None,
    )
    assert report == {
        "interrupted": True, "rows": [{"number": 1}, {"number": 2}], "figures": []
    }  # fmt: skip
    assert saved == [(1, False), (2, False), (2, True)]
    assert seen == [1, 2]


def test_parts_follow_each_other_and_an_error_is_not_swallowed() -> None:
    report = started()
    parts = [Part("rows", iter([1]), plain), Part("figures", iter([2]), plain)]
    run_parts(report, parts, lambda: None)
    assert report == {"interrupted": False, "rows": [{"number": 1}], "figures": [{"number": 2}]}

    def fails() -> Iterator[int]:
        raise ValueError("a defect")
        yield 0

    with pytest.raises(ValueError, match="a defect"):
        run_parts(started(), [Part("rows", fails(), plain)], lambda: None)


def test_a_table_has_as_many_cells_everywhere_and_text_to_the_left() -> None:
    head, marks, row = markdown_table(["name", "n"], [["a", "1"]], left={0})
    assert (head, row) == ("| name | n |", "| a | 1 |")
    assert marks == "|---|--:|"


def test_figures_that_are_not_there_are_a_dash() -> None:
    assert [percent(v) for v in (None, float("nan"), float("inf"), 0.1234)] == [
        "-", "-", "-", "12.34 %"
    ]  # fmt: skip
    assert percent(-1e-9, 1) == "0.0 %"
    assert [figure_text(v, 2) for v in (None, float("inf"), 1.006, 12.0)] == [
        "-",
        "-",
        "1.01",
        "12",
    ]


def test_csv_holds_the_columns_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    write_csv([{"a": 'say "b", c', "b": None, "more": 1}], ("a", "b"), path)
    assert path.read_bytes().count(b"\r") == 0
    with path.open() as file:
        assert list(csv.DictReader(file)) == [{"a": 'say "b", c', "b": ""}]
