"""What a cell of a table says.

Numbers are as spreadsheets of all countries write them: understood, or refused as ambiguous.
``1.234`` is one and a bit where decimals have a point, and one thousand two hundred and
thirty-four where they have a comma. What separates the cells, and the other numbers of the
file, tell which; where they do not, nothing is guessed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from qrobot.errors import InputError
from qrobot.problem.checks import first_invisible
from qrobot.problem.formats.sheets import Number, Odd, Sheet
from qrobot.problem.units import exact, number_advice

__all__ = ["DecimalMarks", "Line"]

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
    """The one that the advice should use; empty where a number should not be text at all."""

    @classmethod
    def of(cls, delimiter: str, cells: Iterable[str]) -> DecimalMarks:
        """Return the marks of a file by its delimiter and all its numbers.

        Without a delimiter, in a workbook, numbers are stored as such, and those that are text
        tell only about each other.
        """
        if delimiter == ",":
            return cls(False, ".", ".")
        sure = {
            found
            for cell in cells
            if not isinstance(cell, Number | Odd)
            and _DECIMAL.fullmatch(cell)
            and not _THOUSANDS.fullmatch(cell)
            for found in ".,"
            if found in cell
        }
        if len(sure) == 1:
            clear = "".join(sure)
        elif sure or not delimiter:
            clear = ""
        else:  # semicolons separate where the comma is taken
            clear = "," if delimiter == ";" else "."
        unclear = {";": ",", "": ""}.get(delimiter, ".")
        return cls(True, clear, clear or unclear)

    def plain(self, cell: str) -> str:
        """Return a number with a point for its decimal mark; refuse what may mean two things."""
        found = next((mark for mark in ".," if mark in cell), None)
        if isinstance(cell, Number):
            return cell
        if found is None or (found == "," and not self.comma):
            return cell
        if _THOUSANDS.fullmatch(cell) and found not in self.clear:
            raise InputError(
                f"{cell:.40} may have a decimal mark or thousands",
                advice=number_advice(cell, self.mark)
                if self.mark
                else "let the cell hold a number, not text",
            )
        if not _DECIMAL.fullmatch(cell) and self.comma and "," in cell:
            raise InputError(
                f"{cell:.40} is not a finite number", advice=number_advice(cell, self.mark or ".")
            )
        return cell.replace(",", ".")


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the file, its cells by column."""

    number: int
    cells: dict[str, str]
    marks: DecimalMarks
    sheet: Sheet
    names: Mapping[str, str]
    """What the file calls its columns, where that is another name."""

    def where(self, column: str) -> str:
        """Return the place of a cell, for errors; of the line where it has no such column."""
        line = self.sheet.where(self.number)
        return f"{line}, column {self.names.get(column, column)}" if self.has(column) else line

    def error(self, column: str, problem: str, advice: str) -> InputError:
        """Return an error that names line and column."""
        return self.sheet.error(self.where(column), problem, advice)

    def has(self, column: str) -> bool:
        """Return whether the file has a column."""
        return column in self.cells

    def fills(self, column: str) -> bool:
        """Return whether the file has a column, and this line something in it."""
        return bool(self.cells.get(column))

    def text(self, column: str) -> str:
        """Return a cell, refusing an empty one and what cannot be a name for people."""
        cell = self.cells[column]
        if not cell:
            raise self.error(column, "is empty", "fill it in")
        if isinstance(cell, Odd):
            raise self.error(column, cell.problem, cell.advice)
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
            raise self.error(column, error.problem, error.advice or "correct it") from None

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
