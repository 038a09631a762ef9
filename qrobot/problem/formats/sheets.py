"""The cells of a table, row by row, whatever kind of file it is in."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

from qrobot._files import read_text
from qrobot.errors import InputError
from qrobot.problem.checks import canonical

__all__ = ["WORKBOOK", "Number", "Odd", "Sheet", "read_sheet", "sheet_called"]

WORKBOOK = ".xlsx"


class Number(str):
    """A cell that is stored as a number, not as text: a point in it is a decimal mark."""

    __slots__ = ()


class Odd(str):
    """A cell that has no text or number of its own, such as an error: refused when it is read.

    Parameters
    ----------
    shown
        What stands in it, never empty.
    problem, advice
        As of `InputError`.
    """

    __slots__ = ("advice", "problem")

    advice: str
    problem: str

    def __new__(cls, shown: str, problem: str, advice: str) -> Odd:
        """Make a text that knows what is wrong with it."""
        self = super().__new__(cls, shown)
        self.problem, self.advice = problem, advice
        return self


@dataclass(frozen=True, slots=True)
class Sheet:
    """A table.

    Parameters
    ----------
    rows
        The rows that are not empty, each with its number from 1.
    delimiter
        What separates the cells of CSV; empty for those of a workbook.
    name
        Of the sheet, for errors, where its file has several.
    hidden
        How many rows are hidden.
    source
        Name of the file; empty: the one that is being read.
    """

    rows: list[tuple[int, list[str]]]
    delimiter: str
    name: str = ""
    hidden: int = 0
    source: str = ""

    def where(self, line: int) -> str:
        """Return the place of a row, for errors."""
        return f"sheet {self.name!r}, line {line}" if self.name else f"line {line}"

    def error(self, field: str, problem: str, advice: str) -> InputError:
        """Return an error that names file and place."""
        return InputError(problem, source=self.source or None, field=field, advice=advice)


def read_sheet(path: Path, kind: str, name: str | None = None) -> Sheet:
    """Return the table of a file.

    Parameters
    ----------
    path
        A workbook (``.xlsx``), or else CSV.
    kind
        Name of its sheet, where a workbook has several.
    name
        Name of the sheet that was asked for.
    """
    if path.suffix.lower() == WORKBOOK:
        from qrobot.problem.formats.workbooks import workbook_sheet

        found = workbook_sheet(path, kind, name)
        assert found is not None
        return found
    if name is not None:
        raise InputError(
            "has no sheets", field="--sheet", advice=f"leave it out, or give a {WORKBOOK} file"
        )
    delimiter, rows = _rows(read_text(path))
    return Sheet(rows, delimiter)


def sheet_called(path: Path, name: str) -> Sheet | None:
    """Return the sheet of a workbook that has a name, ``None`` where there is none."""
    from qrobot.problem.formats.workbooks import workbook_sheet

    return workbook_sheet(path, name, None, optional=True)


def _rows(text: str) -> tuple[str, list[tuple[int, list[str]]]]:
    """Return the delimiter, and the cells of every line that is not empty with its number."""
    skipped = 0
    # Written for Excel: which separator follows.
    declared = re.match(r"\s*\"?sep=(.)\"?[ \t]*(?:\r\n|\r|\n|\Z)", text, re.IGNORECASE)
    if declared is not None:
        skipped = len(re.findall(r"\r\n|\r|\n", declared[0]))
        text = text[declared.end() :]
        delimiter = declared[1]
    else:
        head = (text.lstrip("\r\n ").splitlines() or [""])[0]
        delimiter = max(",;\t", key=head.count)
    if delimiter not in ",;\t":
        raise InputError(
            f"the separator {delimiter!r} is not known", field="line 1", advice="use , ; or a tab"
        )
    # A tab that separates is no space to skip.
    rows = csv.reader(
        io.StringIO(text, newline=""), delimiter=delimiter, strict=True, skipinitialspace=True
    )
    found: list[tuple[int, list[str]]] = []
    try:
        for row in rows:
            cells = [canonical(cell).strip() for cell in row]
            if any(cells):
                found.append((rows.line_num + skipped, cells))
    except csv.Error as error:
        raise InputError(
            f"broken CSV ({error})",
            field=f"line {rows.line_num + skipped}",
            advice="correct it there",
        ) from None
    return delimiter, found
