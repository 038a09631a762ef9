"""Text files of words and numbers, line by line, so that every fault has a line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from qrobot.errors import InputError
from qrobot.problem.checks import MAX_LENGTH
from qrobot.problem.units import NUMBER, exact

__all__ = ["Line", "Lines"]


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a file, with its number from 1."""

    number: int
    text: str

    @property
    def words(self) -> list[str]:
        """The words between spaces."""
        return self.text.split()

    @property
    def where(self) -> str:
        """The place, as errors name it."""
        return f"line {self.number}"

    def error(self, problem: str, advice: str) -> InputError:
        """Return an error that names this line."""
        return InputError(problem, field=self.where, advice=advice)

    def whole(self, word: str, what: str, *, least: int = 0, most: int = 10**9) -> int:
        """Return a word as a whole number.

        Raises
        ------
        InputError
            When it is not one, or out of its bounds.
        """
        if not re.fullmatch(r"[0-9]{1,12}", word) or not least <= int(word) <= most:
            raise self.error(
                f"{what} {word:.40} is not a whole number from {least} to {most}", "correct it"
            )
        return int(word)

    def length(self, word: str, what: str) -> float:
        """Return a word as a length of 0 or more; errors as of `whole`."""
        if not NUMBER.fullmatch(word) or not 0 <= float(word) <= MAX_LENGTH:
            raise self.error(f"{what} {word:.40} is not a length from 0 to 1e9", "correct it")
        return float(word)

    def weight(self, word: str, what: str) -> Fraction:
        """Return a word as an exact weight of 0 or more; errors as of `whole`."""
        try:
            weight = exact(word, field="")
        except InputError as error:
            raise self.error(f"{what} {error.problem}", error.advice or "correct it") from None
        if weight < 0:
            raise self.error(f"{what} {word:.40} is negative", "use zero or more")
        return weight


class Lines(Iterator[Line]):
    """The lines of a text that are not blank, one after the other."""

    def __init__(self, text: str) -> None:
        rows = re.split(r"\r\n|\r|\n", text)
        self._rows = [Line(n, row.strip()) for n, row in enumerate(rows, 1) if row.strip()]
        self._at = 0

    def __next__(self) -> Line:
        """Return the next line and step over it."""
        if self._at == len(self._rows):
            raise StopIteration
        self._at += 1
        return self._rows[self._at - 1]

    def take(self, what: str) -> Line:
        """Return the next line and step over it.

        Raises
        ------
        InputError
            When the text ends where `what` belongs.
        """
        for line in self:
            return line
        last = self._rows[-1].where if self._rows else None
        raise InputError(
            f"the file ends where {what} belongs", field=last, advice="complete it (it may be cut)"
        )
