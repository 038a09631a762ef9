"""The cells of CSV orders: which columns there are, and what a cell of each says.

Numbers are as spreadsheets of all countries write them: understood, or refused as ambiguous.
``1.234`` is one and a bit where decimals have a point, and one thousand two hundred and
thirty-four where they have a comma. What separates the cells, and the other numbers of the
file, tell which; where they do not, nothing is guessed.
"""

from __future__ import annotations

import csv
import difflib
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from qrobot.errors import InputError
from qrobot.problem.checks import canonical, first_invisible
from qrobot.problem.units import exact, number_advice

__all__ = ["DecimalMarks", "Line", "read_lines"]

_REQUIRED = ("order", "item", "weight")
_PLACES: tuple[tuple[set[str], set[str]], ...] = (
    ({"aisle", "slot"}, {"block", "side"}),
    ({"x", "y"}, set()),
    ({"node"}, set()),
)
"""Columns that a place needs, and those that it may have."""
_COLUMNS = (
    *_REQUIRED,
    "quantity",
    "pick_seconds",
    "aisle",
    "block",
    "slot",
    "side",
    "x",
    "y",
    "node",
)
_TEXTS = {"order", "item", "side"}
"""Columns whose cells are not numbers."""
_LONGEST = 90

_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}(?:[.][0-9]{3})+|[-+]?[1-9][0-9]{0,2}(?:,[0-9]{3})+")
"""May be a number with groups of three digits."""
_DECIMAL = re.compile(r"[-+]?[0-9]*[.,][0-9]+")


@dataclass(frozen=True, slots=True)
class DecimalMarks:
    """What a comma and a point mean in the numbers of one file."""

    comma: bool
    """Whether a comma may be the decimal mark at all."""
    clear: str
    """The marks that are decimal marks even before three digits."""
    mark: str
    """The one that the advice should use."""

    @classmethod
    def of(cls, delimiter: str, cells: Iterable[str]) -> DecimalMarks:
        """Return the marks of a file by its delimiter and all its numbers."""
        if delimiter == ",":
            return cls(False, ".", ".")
        sure = {
            found
            for cell in cells
            if _DECIMAL.fullmatch(cell) and not _THOUSANDS.fullmatch(cell)
            for found in ".,"
            if found in cell
        }
        if len(sure) == 1:
            clear = "".join(sure)
        elif sure:
            clear = ""
        else:  # semicolons separate where the comma is taken
            clear = "," if delimiter == ";" else "."
        return cls(True, clear, clear or ("," if delimiter == ";" else "."))

    def plain(self, cell: str) -> str:
        """Return a number with a point for its decimal mark; refuse what may mean two things."""
        found = next((mark for mark in ".," if mark in cell), None)
        if found is None or (found == "," and not self.comma):
            return cell
        if _THOUSANDS.fullmatch(cell) and found not in self.clear:
            raise InputError(
                f"{cell:.40} may have a decimal mark or thousands",
                advice=number_advice(cell, self.mark),
            )
        if not _DECIMAL.fullmatch(cell) and self.comma and "," in cell:
            raise InputError(
                f"{cell:.40} is not a finite number", advice=number_advice(cell, self.mark)
            )
        return cell.replace(",", ".")


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the file, its cells by column."""

    number: int
    cells: dict[str, str]
    marks: DecimalMarks

    def where(self, column: str) -> str:
        """Return the place of a cell, for errors."""
        return f"line {self.number}, column {column}"

    def error(self, column: str, problem: str, advice: str) -> InputError:
        """Return an error that names line and column."""
        return InputError(problem, field=self.where(column), advice=advice)

    def has(self, column: str) -> bool:
        """Return whether the file has a column."""
        return column in self.cells

    def text(self, column: str) -> str:
        """Return a cell, refusing an empty one and what cannot be a name for people."""
        cell = self.cells[column]
        if not cell:
            raise self.error(column, "is empty", "fill it in")
        if (hidden := first_invisible(cell)) is not None:
            raise self.error(
                column, f"{cell!r:.60} holds the invisible character {hidden}", "remove it"
            )
        if len(cell) > _LONGEST:
            raise self.error(
                column,
                f"{cell!r:.60} has {len(cell)} letters",
                f"use up to {_LONGEST} printable letters",
            )
        return cell

    def number_of(self, column: str) -> Fraction:
        """Return the number in a cell, exactly as it is written."""
        cell = self.text(column)
        try:
            return exact(self.marks.plain(cell), field="")
        except InputError as error:
            raise error.at(self.where(column)) from None

    def whole(self, column: str, *, least: int = 0) -> int:
        """Return the whole number in a cell."""
        number = self.number_of(column)
        if number.denominator != 1 or number < least:
            raise self.error(
                column,
                f"{self.cells[column]} is not a whole number from {least}",
                "correct it",
            )
        return int(number)


def read_lines(text: str, ignore: Sequence[str] = ()) -> list[Line]:
    """Return the lines of CSV orders below their header; columns to ignore must be there."""
    delimiter, rows = _rows(text)
    if not rows:
        raise InputError("has no header", advice=f"begin with {', '.join(_REQUIRED)} and a place")
    (header_line, header), *body = rows
    columns = [canonical(cell).lower() for cell in header]
    while columns and not columns[-1]:  # a trailing delimiter
        columns.pop()
    where = f"line {header_line}"
    for number, cells in body:
        if len(cells) < len(columns) or any(cells[len(columns) :]):
            raise InputError(
                f"{len(cells)} cells where the header has {len(columns)}",
                field=f"line {number}",
                advice="add or remove cells (quote a cell that holds a separator)",
            )
    kept = _kept(columns, body, ignore, where)
    _check_columns([columns[at] for at in kept], where)
    numeric = [at for at in kept if columns[at] not in _TEXTS]
    marks = DecimalMarks.of(delimiter, (cells[at] for _, cells in body for at in numeric))
    return [Line(number, {columns[at]: cells[at] for at in kept}, marks) for number, cells in body]


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


def _kept(
    columns: list[str], body: list[tuple[int, list[str]]], ignore: Sequence[str], where: str
) -> list[int]:
    """Return which columns are read: not those that are ignored, or empty throughout."""
    unwanted = {canonical(name).strip().lower() for name in ignore}
    for name in sorted(unwanted):
        if name in _REQUIRED or name not in columns:
            raise InputError(
                f"column {name!r:.60} cannot be ignored: it is "
                + ("needed" if name in _REQUIRED else "not in the header"),
                field=where,
                advice="leave it out of --ignore-columns",
            )
    kept = []
    for at, name in enumerate(columns):
        used = [number for number, cells in body if at < len(cells) and cells[at]]
        if name in unwanted or (body and not used and name not in _REQUIRED):
            continue
        if not name:
            raise InputError(
                f"column {at + 1} has no name, but line {used[0]} fills it"
                if used
                else f"column {at + 1} has no name",
                field=where,
                advice="name it in the header, or remove it",
            )
        kept.append(at)
    return kept


def _check_columns(columns: list[str], where: str) -> None:
    for column in columns:
        if column not in _COLUMNS:
            close = difflib.get_close_matches(column, _COLUMNS, n=1)
            keep = f"--ignore-columns {column:.40}"
            raise InputError(
                f"column {column!r:.60} is not known",
                field=where,
                advice=f"did you mean {close[0]!r}? If not, give {keep}"
                if close
                else f"remove it, or give {keep}; known are {', '.join(_COLUMNS)}",
            )
        if columns.count(column) > 1:
            raise InputError(f"column {column!r} is there twice", field=where, advice="keep one")
    missing = [column for column in _REQUIRED if column not in columns]
    if missing:
        raise InputError(
            f"column {missing[0]!r} is missing", field=where, advice="add it to the header"
        )
    given = set(columns) & set().union(*(needed | more for needed, more in _PLACES))
    if not any(needed <= given <= needed | more for needed, more in _PLACES):
        raise InputError(
            f"the columns {', '.join(sorted(given))} are not a place" if given else "has no place",
            field=where,
            advice="give aisle and slot (and block, side), or x and y, or node",
        )
