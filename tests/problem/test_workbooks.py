"""Workbooks: what CSV of the same rows says, or a refusal with sheet, line and column."""

from __future__ import annotations

import datetime
import io
import json
import re
import zipfile
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError, MissingExtraError
from qrobot.problem import Instance
from qrobot.problem.formats import workbooks

openpyxl = pytest.importorskip("openpyxl")

LAYOUT = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "floor"},
    "robots": {"count": 2, "capacity": 100_000},
}
HEAD = ["order", "item", "weight", "x", "y"]
ROWS: list[list[Any]] = [HEAD, ["A", "p", 2.5, 1.5, 2], ["B", "q", 1, 3, 4]]


def save(folder: Path, *sheets: Sequence[Sequence[Any]], **titled: Sequence[Sequence[Any]]) -> Path:
    """Write a workbook of sheets, called Sheet1.. or as they are named."""
    book = openpyxl.Workbook()
    book.remove(book.active)
    every = [(f"Sheet{n}", rows) for n, rows in enumerate(sheets, 1)] + list(titled.items())
    for title, rows in every:
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(list(row))
    return stored(folder, book)


def stored(folder: Path, book: Any) -> Path:
    (folder / "layout.json").write_text(json.dumps(LAYOUT))
    book.save(folder / "x.xlsx")
    return folder / "x.xlsx"


def refusal(path: Path, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        qrobot.read(path, **options)
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    return said.removeprefix(f"{path}: ")


def as_csv(folder: Path, rows: Sequence[Sequence[Any]]) -> Instance:
    text = "\n".join(";".join("" if cell is None else str(cell) for cell in row) for row in rows)
    (folder / "x.csv").write_text(text)
    return qrobot.read(folder / "x.csv")


words = st.text("ABCxyz019-/_", min_size=1, max_size=8)
numbers = st.decimals(0, 9999, places=3).map(Decimal.normalize)
lines = st.lists(
    st.tuples(words, words, numbers, numbers, numbers, st.none() | st.integers(1, 9)),
    min_size=1, max_size=6, unique_by=lambda line: (line[0], line[1]),
)  # fmt: skip


def stand(text: str, kind: str) -> Any:
    """Return a number as a workbook may store it."""
    if kind == "text":
        return text
    return int(text) if "." not in text else float(text)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(lines, st.sampled_from(["number", "text", "both"]))
def test_a_workbook_and_csv_of_the_same_rows_are_the_same(
    tmp_path: Path, drawn: list[tuple[Any, ...]], kind: str
) -> None:
    head = [*HEAD, "note"]
    plain, cells = [head], [head]
    for n, (order, item, weight, x, y, _) in enumerate(drawn):
        texts = [f"{value:f}" for value in (weight, x, y)]
        own = ("text" if n % 2 else "number") if kind == "both" else kind
        # Text that may have a decimal mark or thousands is refused where nothing tells.
        texts = [t if not re.fullmatch(r"[1-9]\d{0,2}\.\d{3}", t) else f"{t}5" for t in texts]
        plain.append([f"o{order}", f"i{item}", *texts, ""])
        cells.append([f"o{order}", f"i{item}", *(stand(t, own) for t in texts), None])
    assert qrobot.read(save(tmp_path, cells)) == as_csv(tmp_path, plain)


def test_numbers_are_those_that_a_spreadsheet_shows(tmp_path: Path) -> None:
    """Sums of decimals have 17 digits in the file, and 15 on the screen."""
    rows = [HEAD, ["A", 4711, 0.1 + 0.2, 1e-5, 12345678.25], [1001.0, "q", "2,5", 3, 4]]
    one = qrobot.read(save(tmp_path, rows))
    assert [item.weight for item in one.items] == [Fraction(3, 10), Fraction(5, 2)]
    assert [item.id for item in one.items] == ["4711", "q"]
    assert [order.id for order in one.orders] == ["A", "1001"]
    book = openpyxl.load_workbook(tmp_path / "x.xlsx")
    book.active["A3"].number_format = "000000"
    assert qrobot.read(stored(tmp_path, book)).orders[1].id == "001001"


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (datetime.date(2026, 5, 2), "is a date or a time (2026-05-02 00:00:00); format the column"),
        (datetime.time(2, 5), "is a date or a time (02:05:00); format the column"),
        (datetime.timedelta(hours=26), "is a date or a time (1 day, 2:00:00)"),
        (True, "is true or false, no text or number; correct it"),
        ("#N/A", "is the error #N/A; mend the formula"),
        ("#DIV/0!", "is the error #DIV/0!; mend the formula"),
        ("=1+1", "is a formula whose value is not in the file; open the file in a spreadsheet"),
        ("1.234", "1.234 may have a decimal mark or thousands; let the cell hold a number, not"),
        ("1,234", "1,234 may have a decimal mark or thousands; let the cell hold a number, not"),
        ("2kg", "2kg is not a finite number"),
        (None, "is empty; fill it in"),
    ],
)
def test_a_cell_that_is_no_number(tmp_path: Path, value: object, said: str) -> None:
    rows = [*ROWS, ["C", "r", value, 1, 1]]
    assert refusal(save(tmp_path, rows)).startswith(f"line 4, column weight: {said}")
    noted = [[*row, None] for row in ROWS] + [["C", "r", 1, 1, 1, value]]
    noted[0][-1] = "note"
    one = qrobot.read(save(tmp_path, noted), ignore_columns=["note"] if value else [])
    assert one.size == 3
    several = refusal(save(tmp_path, Export=rows, Notes=[["a"]]), sheet="export")
    assert several.startswith("sheet 'Export', line 4, column weight: ")


def with_value(path: Path, cell: str, value: str, kind: str = "") -> Path:
    """Give a formula the value that a spreadsheet program would have saved."""
    data = io.BytesIO(path.read_bytes())
    with zipfile.ZipFile(data) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            part = old.read(name)
            if name == "xl/worksheets/sheet1.xml":
                before = rf'(<c r="{cell}")([^>]*)>(<f>[^<]*</f>)<v ?/>'.encode()
                part, done = re.subn(before, rf"\1\2{kind}>\3<v>{value}</v>".encode(), part)
                assert done == 1
            new.writestr(name, part)
    return path


def test_a_formula_counts_with_the_value_that_was_saved(tmp_path: Path) -> None:
    rows = [HEAD, ["A", "p", "=D2+1", 1.5, 2], ["B", "q", 1, 3, 4]]
    assert qrobot.read(with_value(save(tmp_path, rows), "C2", "2.5")) == as_csv(tmp_path, ROWS)
    path = with_value(save(tmp_path, rows), "C2", "#DIV/0!", ' t="e"')
    assert refusal(path).startswith("line 2, column weight: is the error #DIV/0!; mend")
    path = with_value(save(tmp_path, rows), "C2", "", ' t="str"')
    assert refusal(path).startswith("line 2, column weight: is empty; fill it in")


def test_the_sheet_that_is_read(tmp_path: Path) -> None:
    one = as_csv(save(tmp_path, ROWS).parent, ROWS)
    other = [HEAD, ["Z", "z", 1, 1, 1]]
    assert qrobot.read(save(tmp_path, ROWS, [])) == one  # an empty one does not count
    assert qrobot.read(save(tmp_path, Notes=other, Orders=ROWS)) == one
    assert qrobot.read(save(tmp_path, Notes=other, Export=ROWS), sheet="Export") == one
    path = save(tmp_path, Notes=other, Export=ROWS)
    assert refusal(path) == (
        "has several sheets (Notes, Export); call the one that is meant 'orders', or name it "
        "(--sheet)"
    )
    assert refusal(path, sheet="Exports") == (
        "--sheet: has no visible sheet 'Exports' with anything in it; use one of Notes, Export"
    )
    book = openpyxl.load_workbook(path)
    book["Notes"].sheet_state = "hidden"
    assert qrobot.read(stored(tmp_path, book)) == one
    book["Notes"].sheet_state = "visible"
    book.create_chartsheet("Chart").add_chart(openpyxl.chart.BarChart())
    del book["Notes"]
    assert qrobot.read(stored(tmp_path, book)) == one
    assert refusal(save(tmp_path, [])) == "is empty; give a file with content"
    csv = tmp_path / "x.csv"
    assert (
        refusal(csv, sheet="Export") == "--sheet: has no sheets; leave it out, or give a .xlsx file"
    )


def test_one_workbook_may_hold_everything(tmp_path: Path) -> None:
    orders = [["Order", "SKU", "Bin", "Pieces"], ["A", "p", "N1", 2], ["B", "q", "N2", 1]]
    locations = [["Bin", "x", "y", "level"], ["N1", 1.5, 2, 3], ["N2", 3, 4, None]]
    articles = [["SKU", "weight", "volume"], ["p", 1.25, 2], ["q", 1, 1]]
    columns = {"article": "SKU", "place": "Bin", "quantity": "Pieces"}
    tables = {"Lines": orders, "Locations": locations, "Articles": articles}
    one = qrobot.read(save(tmp_path, **tables), columns=columns)
    assert [(i.weight, i.label, i.level, i.volume) for i in one.items] == [
        (Fraction(5, 2), "N1", 3, 4), (1, "N2", 0, 1)
    ]  # fmt: skip
    locations[2][0] = "N1"
    path = save(tmp_path, **tables)
    assert refusal(path, columns=columns) == (
        "sheet 'Locations', line 3, column Bin: 'N1' is in line 2 too; keep one"
    )
    locations[2][0] = "N2"
    for title, rows in (("locations", locations), ("articles", articles)):
        save(tmp_path, rows).rename(tmp_path / f"x.{title}.xlsx")
    assert qrobot.read(save(tmp_path, orders), columns=columns) == one


def test_hidden_rows_are_read_and_told(tmp_path: Path) -> None:
    book = openpyxl.load_workbook(save(tmp_path, ROWS))
    book.active.row_dimensions[3].hidden = True
    one = qrobot.read(stored(tmp_path, book))
    assert one == as_csv(tmp_path, ROWS)
    assert one.notes == ("1 hidden row of the sheet was read like the others",)


def test_merged_cells_are_not_guessed(tmp_path: Path) -> None:
    rows = [["order", "item", "weight", "place", None], *ROWS[1:]]
    book = openpyxl.load_workbook(save(tmp_path, rows))
    book.active.merge_cells("D1:E1")
    assert refusal(stored(tmp_path, book)) == (
        "line 2: 5 cells where the header has 4; name every column in the header, or remove what "
        "is beside the table"
    )
    rows = [["order", "item", "weight", "x", None, "y"], ["A", "p", 1, 2, 3, 4]]
    book = openpyxl.load_workbook(save(tmp_path, rows))
    book.active.merge_cells("D1:E1")
    assert refusal(stored(tmp_path, book)).startswith("line 1: column 5 has no name, but line 2")
    book = openpyxl.load_workbook(save(tmp_path, [*ROWS, ["B", "r", 1, 0, 0]]))
    book.active.merge_cells("A3:A4")
    assert refusal(stored(tmp_path, book)) == "line 4, column order: is empty; fill it in"


def test_empty_rows_and_columns_do_not_matter(tmp_path: Path) -> None:
    rows = [[], *(row for one in ROWS for row in (one, [None, " "])), []]
    assert qrobot.read(save(tmp_path, rows)) == as_csv(tmp_path, ROWS)
    book = openpyxl.load_workbook(save(tmp_path, ROWS))
    for row in book.active.iter_rows(max_row=9, max_col=12):
        for cell in row:
            cell.font = openpyxl.styles.Font(bold=True)
    assert qrobot.read(stored(tmp_path, book)) == as_csv(tmp_path, ROWS)
    wide = [[*row, None, None] for row in ROWS]
    wide[1][-1] = "remark"
    assert refusal(save(tmp_path, wide)).startswith("line 2: 7 cells where the header has 5")


@pytest.mark.parametrize(
    "data",
    [
        b"order,item,weight,x,y\nA,p,1,1,1\n",
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600),  # with a password, or .xls
        b"PK\x05\x06" + bytes(18),
        b"",
    ],
)
def test_what_is_no_workbook(tmp_path: Path, data: bytes) -> None:
    path = save(tmp_path, ROWS)
    path.write_bytes(data)
    assert refusal(path).startswith("is not a workbook that can be read (")


def test_a_part_of_a_workbook(tmp_path: Path) -> None:
    whole = save(tmp_path, ROWS).read_bytes()
    for length in range(1, len(whole), 97):
        (tmp_path / "x.xlsx").write_bytes(whole[:length])
        assert "is not a workbook that can be read" in refusal(tmp_path / "x.xlsx")
    for name in ("[Content_Types].xml", "xl/workbook.xml", "xl/worksheets/sheet1.xml"):
        with (
            zipfile.ZipFile(io.BytesIO(whole)) as old,
            zipfile.ZipFile(tmp_path / "x.xlsx", "w") as new,
        ):
            for part in old.namelist():
                if part != name:
                    new.writestr(part, old.read(part))
        said = refusal(tmp_path / "x.xlsx")
        assert "is not a workbook that can be read" in said or said.startswith("is empty; "), said


def test_a_workbook_that_unpacks_to_gigabytes(tmp_path: Path) -> None:
    path = save(tmp_path, ROWS)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/media/zeros", bytes(workbooks.MAX_UNPACKED))
    assert path.stat().st_size < 1_000_000
    assert "MB when unpacked are more than the 100 MB that are read; " in refusal(path)


def test_a_sheet_of_too_many_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    book = openpyxl.load_workbook(save(tmp_path, ROWS))
    book.active["XFD1048576"] = 1
    far = stored(tmp_path, book)
    monkeypatch.setattr(workbooks, "MAX_CELLS", 100_000)
    assert refusal(far).startswith("sheet 'Sheet1' has more than 100,000 cells; delete the empty")


def test_without_openpyxl_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save(tmp_path, ROWS)
    monkeypatch.setitem(__import__("sys").modules, "openpyxl.reader.excel", None)
    with pytest.raises(MissingExtraError, match=r"qrobot\[(excel|full)\]"):
        qrobot.read(path)
