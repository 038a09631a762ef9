"""The text of a TSPLIB 95 file: its fields and sections, with the line of each.

A keyword counts only where a line begins with it: ``EOF`` in a comment is text. Fields and
sections may stand in any sequence. What a field or section means is not known here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem.units import NUMBER

__all__ = ["Field", "Section", "Tsplib", "parse"]


_KEYWORD = re.compile(r"[A-Za-z][A-Za-z0-9_ -]*")
_ONLY_NUMBERS = re.compile(r"[0-9eE+\-.\s]*")


@dataclass(frozen=True, slots=True)
class Field:
    """One line ``NAME : value``."""

    name: str
    value: str
    line: int

    @property
    def where(self) -> str:
        """The field and its line, as errors name them."""
        return f"{self.name:.40}, line {self.line}"

    def error(self, problem: str, advice: str) -> InputError:
        """Return an error that names the field and its line."""
        return InputError(problem, field=self.where, advice=advice)


@dataclass(slots=True)
class Section:
    """The lines of numbers below ``NAME_SECTION``."""

    name: str
    line: int
    rows: list[tuple[int, str]] = field(default_factory=list)
    """Number and text of each line."""

    def where(self, row: int, word: int) -> str:
        """Return line and column of a word: of which line of the section, and which there."""
        line, text = self.rows[row]
        starts = [found.start() for found in re.finditer(r"\S+", text)]
        column = starts[min(word, len(starts) - 1)] + 1
        return f"{self.name:.40}_SECTION, line {line}, column {column}"

    def error(self, problem: str, advice: str, row: int | None = None, word: int = 0) -> InputError:
        """Return an error that names a word, as of `where`, or the section's own line."""
        where = f"{self.name:.40}_SECTION, line {self.line}"
        return InputError(
            problem, field=where if row is None else self.where(row, word), advice=advice
        )

    def error_at(self, number: int, problem: str, advice: str) -> InputError:
        """Return an error that names the number-th word of the section."""
        for row, (_, text) in enumerate(self.rows):
            words = len(text.split())
            if number < words:
                return self.error(problem, advice, row, number)
            number -= words
        return self.error(problem, advice)

    def table(self, width: int) -> list[list[str]]:
        """Return the words of every line: `width` of them, all numbers."""
        found = []
        for row, (_, text) in enumerate(self.rows):
            words = text.split()
            for at, word in enumerate(words):
                if not NUMBER.fullmatch(word):
                    raise self.error(f"{word!r:.40} is not a number", "correct it", row, at)
            if len(words) != width:
                raise self.error(
                    f"{len(words)} numbers where {width} belong", "correct the line", row
                )
            found.append(words)
        return found

    def stream(self) -> Floats:
        """Return all numbers, however they are broken into lines."""
        words = " ".join(text for _, text in self.rows).split()
        try:
            # The test of the whole is quick; matrices have millions of words.
            if all(_ONLY_NUMBERS.fullmatch(text) for _, text in self.rows):
                return np.array(words, dtype=np.float64)
        except ValueError:
            pass
        bad = next(n for n, word in enumerate(words) if not NUMBER.fullmatch(word))
        raise self.error_at(bad, f"{words[bad]!r:.40} is not a number", "correct it")


@dataclass(slots=True)
class Tsplib:
    """Fields and sections by name, and notes on what was not read."""

    fields: dict[str, Field] = field(default_factory=dict)
    sections: dict[str, Section] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def text(self, name: str) -> str:
        """Return the value of a field, empty without one."""
        return self.fields[name].value if name in self.fields else ""

    def nodes(self, name: str, size: int, width: int) -> tuple[list[list[str]], list[int]]:
        """Return the words of each of `size` nodes of a section, and the row that each stands in.

        Each has `width` words, all numbers; the first is the number of the node.
        """
        section = self.sections.get(name)
        if section is None:
            raise InputError(
                "is missing", field=f"{name}_SECTION", advice="add it; the file may be cut off"
            )
        words = section.table(width)
        if len(words) != size:
            raise section.error(
                f"{len(words)} nodes where DIMENSION says {size}",
                "correct DIMENSION, or complete the section (the file may be cut off)",
            )
        rows = [-1] * size
        for row, (node, *_) in enumerate(words):
            if not re.fullmatch(r"[0-9]{1,9}", node) or not 1 <= int(node) <= size:
                raise section.error(f"{node:.40} is not a node", f"use 1 to {size}", row)
            if (before := rows[int(node) - 1]) >= 0:
                line = section.rows[before][0]
                raise section.error(
                    f"node {node} is in line {line} too", "number the nodes 1, 2, 3 ...", row
                )
            rows[int(node) - 1] = row
        return [words[row] for row in rows], rows


def parse(text: str) -> Tsplib:
    """Return the fields and sections of a text; nothing may be given twice."""
    found = Tsplib()
    section: Section | None = None
    lines = enumerate(re.split(r"\r\n|\r|\n", text), start=1)
    for number, line in lines:
        words = line.split(maxsplit=1)
        if not words or words[0].startswith("#"):
            continue
        if section is not None and words[0][0] in "0123456789+-.":
            section.rows.append((number, line))
            continue
        bare = line.strip(" \t:").upper()
        if bare == "EOF":
            _note_rest(found, lines)
            break
        if bare.endswith("_SECTION") and _KEYWORD.fullmatch(bare):
            section = Section(bare.removesuffix("_SECTION"), number)
            if (before := found.sections.get(section.name)) is not None:
                raise section.error(f"is given in line {before.line} too", "keep one of them")
            found.sections[section.name] = section
        elif (known := _field(line, number)) is not None:
            _keep(found, known)
        elif section is not None:
            section.rows.append((number, line))
        else:
            raise InputError(
                f"{line.strip()!r:.60} is neither a field nor a section",
                field=f"line {number}, column 1",
                advice="write it as NAME : value (see TSPLIB 95)",
            )
    return found


def _field(line: str, number: int) -> Field | None:
    name, colon, value = line.partition(":")
    if not colon or not _KEYWORD.fullmatch(name.strip()):
        return None
    return Field(name.strip().upper(), value.strip(), number)


def _keep(found: Tsplib, new: Field) -> None:
    """Take a field; comments add up, another value for the same field is refused."""
    before = found.fields.get(new.name)
    if new.name.endswith("_SECTION"):
        raise new.error(f"{new.value!r:.40} stands behind the keyword", "put it on the next line")
    if before is not None and new.name == "COMMENT":
        new = Field(new.name, f"{before.value} {new.value}", before.line)
    elif before is not None and before.value != new.value:
        raise new.error(
            f"{new.value!r:.40} is given where line {before.line} has {before.value!r:.40}",
            "keep one of them",
        )
    found.fields[new.name] = new


def _note_rest(found: Tsplib, lines: Iterator[tuple[int, str]]) -> None:
    rest = [number for number, line in lines if line.strip()]
    if rest:
        found.notes.append(f"line {rest[0]} and what follows stand behind EOF and are not read")
