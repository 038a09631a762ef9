"""The sheets of an XLSX workbook, by openpyxl: as careful as CSV is read.

A number counts with the 15 digits that a spreadsheet shows; a formula with the value that it had
when the file was saved. What is neither text nor a number is refused, but only where it is read.
"""

from __future__ import annotations

import datetime
import io
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from qrobot._extras import load
from qrobot._files import read_bytes
from qrobot._formats import MASTERS
from qrobot.errors import InputError
from qrobot.problem.checks import canonical
from qrobot.problem.formats.sheets import Number, Odd, Sheet

__all__ = ["workbook_sheet"]

MAX_UNPACKED = 100_000_000
"""Bytes of a workbook when it is unpacked: some kilobytes can become gigabytes."""

MAX_CELLS = 2_000_000
"""Cells of a sheet, empty ones too: a hundred columns of as many lines as one plan may have."""

_BROKEN = (
    ArithmeticError, AttributeError, LookupError, NotImplementedError, OSError, RuntimeError,
    SyntaxError, TypeError, ValueError, zipfile.BadZipFile,
)  # fmt: skip
"""What openpyxl raises on files that are no workbooks, or not whole ones."""

_HIDDEN = re.compile(rb"<(?:\w+:)?row\b[^>]*\shidden=[\"'](?:1|true)[\"']")


def workbook_sheet(
    path: Path, kind: str, name: str | None, *, optional: bool = False
) -> Sheet | None:
    """Return a sheet of a workbook.

    Parameters
    ----------
    path
        The file.
    kind
        Name of the sheet where the workbook has several.
    name
        Name of the sheet that was asked for.
    optional
        Return ``None`` where no sheet is called as its kind.
    """
    data = read_bytes(path)
    excel = load("openpyxl.reader.excel", f"a workbook ({path.suffix})")
    _check_size(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what openpyxl leaves out: styles, validations
        try:
            book, archive, parts = _opened(excel, data, values=False)
            visible = [s for s in book.worksheets if s.sheet_state == "visible" and _filled(s)]
            sheet = _chosen(visible, kind, name, optional)
            if sheet is None:
                return None
            rows = _rows(sheet, lambda: _opened(excel, data, values=True)[0][sheet.title])
            hidden = len(_HIDDEN.findall(archive.read(parts[sheet.title])))
        except _BROKEN as error:
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"is not a workbook that can be read ({' '.join(str(error).split()):.80})",
                advice="open it in a spreadsheet program and save it as .xlsx without a password",
            ) from None
    return Sheet(rows, "", sheet.title if len(visible) > 1 else "", hidden)


def _check_size(data: bytes) -> None:
    """Refuse what would fill the memory; nothing unpacks to more than it declares."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(part.file_size for part in archive.infolist())
    except zipfile.BadZipFile:
        return  # which is told as other faults are
    if size > MAX_UNPACKED:
        raise InputError(
            f"{size / 1e6:.0f} MB when unpacked are more than the {MAX_UNPACKED / 1e6:.0f} MB that "
            "are read",
            advice="save the sheet as CSV, or delete what does not belong to the table",
        )


def _opened(excel: Any, data: bytes, *, values: bool) -> tuple[Any, Any, dict[str, str]]:
    """Return the workbook with formulas or their values, its archive, and the parts of sheets."""
    reader = excel.ExcelReader(io.BytesIO(data), read_only=True, data_only=values, keep_links=False)
    reader.read()
    parts = {sheet.name: link.target for sheet, link in reader.parser.find_sheets()}
    return reader.wb, reader.archive, parts


def _walk(sheet: Any) -> Iterator[tuple[int, tuple[Any, ...]]]:
    """Yield the rows of a sheet with their numbers, whatever it says of its size; not too many."""
    sheet.reset_dimensions()
    total = 0
    for number, row in enumerate(sheet.iter_rows(), 1):
        total += 1 + len(row)
        if total > MAX_CELLS:
            raise InputError(
                f"sheet {sheet.title!r:.60} has more than {MAX_CELLS:,} cells",
                advice="delete the empty rows and columns around the table, or save it as CSV",
            )
        yield number, row


def _filled(sheet: Any) -> bool:
    """Return whether a sheet has anything in it."""
    return any(cell.value is not None for _, row in _walk(sheet) for cell in row)


def _chosen(visible: Sequence[Any], kind: str, name: str | None, optional: bool) -> Any:
    """Return the sheet that was asked for, the only one, or the one that is called as its kind."""
    names = ", ".join(sheet.title for sheet in visible)
    wanted = kind if name is None else name
    called = [s for s in visible if s.title.strip().lower() == wanted.strip().lower()]
    if called or optional:
        return called[0] if called else None
    if name is not None:
        raise InputError(
            f"has no visible sheet {name!r:.60} with anything in it",
            field="--sheet",
            advice=f"use one of {names:.200}" if names else "give another file",
        )
    others = [s for s in visible if s.title.strip().lower() not in MASTERS or s.title == kind]
    if len(others) == 1 or len(visible) == 1:
        return (others or visible)[0]
    if not visible:
        raise InputError("is empty", advice="give a file with content")
    raise InputError(
        f"has several sheets ({names:.200})",
        advice=f"call the one that is meant {kind!r}"
        + (", or name it (--sheet)" if kind == "orders" else ", or give a file of its own"),
    )


def _rows(sheet: Any, values: Callable[[], Any]) -> list[tuple[int, list[str]]]:
    """Return the rows that are not empty; `values` gives the sheet with the values of formulas."""
    found: list[tuple[int, list[str]]] = []
    formulas: list[tuple[int, int]] = []
    for number, row in _walk(sheet):
        cells = [_text(cell) for cell in row]
        if any(cells):
            formulas += [(len(found), at) for at, cell in enumerate(row) if cell.data_type == "f"]
            found.append((number, cells))
    if formulas:
        _fill_in(found, formulas, values())
    width = len(found[0][1]) if found else 0
    return [(number, cells + [""] * (width - len(cells))) for number, cells in found]


def _fill_in(
    found: list[tuple[int, list[str]]], formulas: Sequence[tuple[int, int]], sheet: Any
) -> None:
    """Put the values of formulas in their places."""
    numbers = {number for number, _ in (found[at] for at, _ in formulas)}
    rows = {number: row for number, row in _walk(sheet) if number in numbers}
    for at, column in formulas:
        number, cells = found[at]
        cell = rows[number][column]
        if cell.value is not None or cell.data_type == "str":  # of a formula that gives ""
            cells[column] = _text(cell)
        else:
            cells[column] = Odd(
                cells[column],
                "is a formula whose value is not in the file",
                "open the file in a spreadsheet program and save it there",
            )


def _text(cell: Any) -> str:
    """Return what a cell shows."""
    value = cell.value
    match value:
        case None:
            return ""
        case bool():
            return Odd(str(value).upper(), "is true or false, no text or number", "correct it")
        case int() | float():
            short = str(int(value)) if value == int(value) else f"{value:.15g}"
            return Number(_zeros(short, cell.number_format))
        case datetime.date() | datetime.time() | datetime.timedelta():
            return Odd(
                str(value),
                f"is a date or a time ({value})",
                "format the column as text or as numbers, and correct what became a date",
            )
    text = canonical(str(value)).strip()
    if cell.data_type == "e":
        return Odd(text or "error", f"is the error {text}", "mend the formula")
    return text


def _zeros(digits: str, form: str | None) -> str:
    """Return a whole number with the leading zeros that its format shows, such as ``00042``."""
    return digits.zfill(len(form)) if form and set(form) == {"0"} and digits.isdigit() else digits
