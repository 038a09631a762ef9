"""What a warehouse knows beside its orders: where the bins are, and what the articles weigh."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from qrobot._files import StrPath
from qrobot._formats import MASTER_SUFFIXES
from qrobot.errors import InputError
from qrobot.problem import Node, Place, Point, Pose, Slot, Warehouse
from qrobot.problem.formats.cells import Line
from qrobot.problem.formats.columns import PLACES, Kind, Wishes, lines_of
from qrobot.problem.formats.sheets import WORKBOOK, Sheet, read_sheet, sheet_called

__all__ = [
    "ARTICLES",
    "Bin",
    "Masters",
    "article_column",
    "articles_of",
    "bins_of",
    "has_place",
    "master_sheet",
    "name_of",
]

LOCATIONS = Kind(
    (("place",),), ("aisle", "block", "slot", "side", "level", "x", "y", "node", "pose"), PLACES
)
ARTICLES = Kind(
    (("article", "item"),), ("weight", "volume", "category", "pick_seconds", "place", "stock")
)
OF_BINS = ("place", "stock")
"""Columns in which the lines of one article differ, where it lies in several places."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Bin:
    """Where something lies: the place, its shelf, and what it is called."""

    place: Place
    level: int
    label: str


@dataclass(frozen=True, slots=True)
class Masters:
    """The bins by their labels, and the lines of the articles by their names.

    ``None``: there is no such file.
    """

    bins: Mapping[str, Bin] | None
    articles: Mapping[str, Sequence[Line]] | None
    locations: str = ""
    """Name of the location table, or what it should be called."""

    def stock(self, article: str) -> dict[Bin, int]:
        """Return the pieces of an article in each of its bins; no bin where that is not said."""
        found: dict[Bin, int] = {}
        for line in (self.articles or {}).get(article, ()):
            if line.fills("stock"):
                place = self.bin(line)
                if any(place.place == other.place for other in found):
                    raise line.error(
                        "place",
                        f"article {article!r} is in {place.place} twice",
                        "give one quantity, and one label",
                    )
                found[place] = line.whole("stock")
        return found

    def _article(self, line: Line) -> Line | None:
        """Return the first line of a line's article."""
        return next(iter((self.articles or {}).get(name_of(line), ())), None)

    def quantity(self, line: Line, column: str) -> Fraction | None:
        """Return a number from zero of a line or its article; ``None``: neither says it."""
        if self.articles is None and line.has(column):
            return _from_zero(line, column)  # an empty cell is told
        return self._either(line, column, lambda one: _from_zero(one, column))

    def text(self, line: Line, column: str) -> str:
        """Return a text of a line or its article; empty: neither says it."""
        return self._either(line, column, lambda one: one.text(column)) or ""

    def _either(self, line: Line, column: str, value: Callable[[Line], T]) -> T | None:
        """Return what a line or its article says, which must not contradict each other."""
        there = self._article(line)
        own = value(line) if line.fills(column) else None
        other = value(there) if there is not None and there.fills(column) else None
        if there is not None and own is not None and other not in (None, own):
            raise line.error(
                column,
                f"{line.cells[column]} is not the {there.cells[column]} of "
                f"{there.sheet.source}, {there.where(column)}",
                "correct one of them, or leave this column out (--ignore-columns)",
            )
        return other if own is None else own

    def bin(self, line: Line) -> Bin:
        """Return where a line is collected: the bin of the line itself, or else of its article."""
        there = self._article(line)
        if not has_place(line):
            if self.articles is None:
                line.text("place")  # which tells that it is empty
            if there is None or not there.fills("place"):
                master = (
                    "it is not in the article master" if there is None else "nor has its article"
                )
                raise line.error(
                    "place" if line.has("place") else article_column(line),
                    f"{name_of(line)!r:.60} has no place, {master}",
                    "fill it in",
                )
            line = there
        label = line.text("place") if line.fills("place") else ""
        if _has_numbers(line):
            return Bin(place_of(line), level_of(line), label)
        if self.bins is None:
            raise line.error(
                "place",
                f"{label!r:.60} is a label, and there is no location table",
                f"add {self.locations} to the folder, or name one (--locations)",
            )
        if label not in self.bins:
            close = difflib.get_close_matches(label, self.bins, n=1)
            raise line.error(
                "place",
                f"{label!r:.60} is not in {self.locations}",
                f"did you mean {close[0]!r}? If not, add it there" if close else "add it there",
            )
        return self.bins[label]


def master_sheet(orders: Path, given: StrPath | None, kind: str) -> tuple[Sheet | None, str]:
    """Return the table of that kind, and the name that it may have beside the orders.

    It is the file that was named, or lies beside the orders, or else the sheet of that name in
    their workbook.
    """
    beside = [
        orders.with_name(f"{stem}{kind}{suffix}")
        for stem in (f"{orders.stem}.", "")
        for suffix in MASTER_SUFFIXES
    ]
    found = Path(given) if given is not None else next((p for p in beside if p.is_file()), None)
    if found is None or (given is None and found == orders):
        sheet = None
        if orders.suffix.lower() == WORKBOOK:
            sheet = sheet_called(orders, kind)
        return sheet and dataclasses.replace(sheet, source=str(orders)), beside[0].name
    try:
        return dataclasses.replace(read_sheet(found, kind), source=str(found)), beside[0].name
    except InputError as error:
        raise error.in_file(str(found)) from None


def bins_of(sheet: Sheet, wishes: Wishes, warehouse: Warehouse) -> dict[str, Bin]:
    """Return the bins of a location table by their labels; each must be in the warehouse."""
    found: dict[str, Bin] = {}
    first: dict[str, int] = {}
    for line in lines_of(sheet, LOCATIONS, wishes)[0]:
        label = line.text("place")
        if label in first:
            raise line.error("place", f"{label!r} is in line {first[label]} too", "keep one")
        place = place_of(line)
        try:
            warehouse.check(place)
        except InputError as error:
            column = error.field if error.field and line.has(error.field) else "place"
            raise line.error(column, error.problem, error.advice or "correct it") from None
        first[label] = line.number
        found[label] = Bin(place, level_of(line), label)
    return found


def articles_of(sheet: Sheet, wishes: Wishes) -> dict[str, list[Line]]:
    """Return the lines of an article master by the names of the articles.

    An article has several where it lies in several places, with its stock in each.
    """
    found: dict[str, list[Line]] = {}
    for line in lines_of(sheet, ARTICLES, wishes)[0]:
        name = name_of(line)
        lines = found.setdefault(name, [])
        if lines:
            _check_again(line, lines[0])
        lines.append(line)
    return found


def _check_again(line: Line, first: Line) -> None:
    """Refuse another line of an article that says something else, or nothing of another place."""
    several = line.fills("stock") and first.fills("stock")
    own = OF_BINS if several else ()
    unlike = [c for c in line.cells if c not in own and line.cells[c] != first.cells[c]]
    if unlike or not several:
        raise line.error(
            unlike[0] if unlike else article_column(line),
            f"article {name_of(line)!r} is in line {first.number} too"
            + (f", with {first.cells[unlike[0]] or 'nothing'!r} there" if unlike else ""),
            "keep one of the lines, or say in a column stock how many pieces each place has",
        )


def article_column(line: Line) -> str:
    """Return the column that names the article of a line."""
    return "article" if line.has("article") else "item"


def name_of(line: Line) -> str:
    """Return the article of a line; a column ``item`` names it where there is no other."""
    return line.text(article_column(line))


def _from_zero(line: Line, column: str) -> Fraction:
    number = line.number_of(column)
    if number < 0:
        raise line.error(
            column,
            f"{column} {float(number):g} of item {name_of(line)!r} is negative",
            "use zero or more",
        )
    return number


def level_of(line: Line) -> int:
    """Return the shelf of a line's bin."""
    return line.whole("level") if line.fills("level") else 0


def has_place(line: Line) -> bool:
    """Return whether a line says itself where it is collected."""
    return _has_numbers(line) or line.fills("place")


def _has_numbers(line: Line) -> bool:
    return any(line.has(column) for column in ("aisle", "x", "node", "pose"))


def place_of(line: Line) -> Place:
    """Return the place that the numbers of a line say."""
    if line.has("node"):
        return Node(line.whole("node"))
    if line.has("pose"):
        return Pose(line.text("pose"))
    if line.has("x"):
        return Point(float(line.number_of("x")), float(line.number_of("y")))
    side = line.text("side").lower() if line.fills("side") else "left"
    if side not in ("left", "right"):
        raise line.error("side", f"{side!r:.40} is not a side", "give left or right")
    return Slot(
        aisle=line.whole("aisle"),
        slot=line.whole("slot"),
        block=line.whole("block") if line.has("block") else 0,
        side="right" if side == "right" else "left",
    )
