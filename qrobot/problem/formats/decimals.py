"""Numbers as spreadsheets of all countries write them: understood, or refused as ambiguous.

``1.234`` is one and a bit where decimals have a point, and one thousand two hundred and
thirty-four where they have a comma. What separates the cells, and the other numbers of the
file, tell which; where they do not, nothing is guessed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from qrobot.errors import InputError
from qrobot.problem.units import number_advice

__all__ = ["DecimalMarks"]

_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}(?:[.][0-9]{3})+|[-+]?[1-9][0-9]{0,2}(?:,[0-9]{3})+")
"""May be a number with groups of three digits."""
_DECIMAL = re.compile(r"[-+]?[0-9]*[.,][0-9]+")


@dataclass(frozen=True, slots=True)
class DecimalMarks:
    """What a comma and a point mean in the numbers of one file.

    Parameters
    ----------
    comma
        Whether a comma may be the decimal mark at all.
    clear
        The marks that are decimal marks even before three digits.
    mark
        The one that the advice should use.
    """

    comma: bool
    clear: str
    mark: str

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
        """Return a number with a point for its decimal mark.

        Raises
        ------
        InputError
            When it may mean two things.
        """
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
