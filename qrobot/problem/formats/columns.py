"""The header of a table: what its columns mean, by our names or by those of a mapping."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from qrobot.errors import InputError
from qrobot.problem.checks import canonical
from qrobot.problem.formats.cells import DecimalMarks, Line
from qrobot.problem.formats.sheets import Sheet

__all__ = ["PLACES", "Kind", "Wishes", "lines_of"]

PLACES: tuple[tuple[frozenset[str], frozenset[str]], ...] = (
    (frozenset({"aisle", "slot"}), frozenset({"block", "side", "level"})),
    (frozenset({"x", "y"}), frozenset({"level"})),
    (frozenset({"node"}), frozenset({"level"})),
    (frozenset({"pose"}), frozenset({"level"})),
)
"""Columns that a place needs, and those that it may have."""

ALIASES = {"label": "place", "class": "category"}
"""Other names of our columns."""

TEXTS = frozenset({"order", "item", "article", "place", "pose", "side", "category"})
"""Columns whose cells are not numbers."""

Error = Callable[[str, str], InputError]
"""Returns an error of the header, with problem and advice."""

ALL = "*"
"""Ignores every column that is not known."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of table.

    Parameters
    ----------
    needed
        Groups of columns; of each group one must be there.
    others
        Columns that may be there.
    places
        What the columns of a place may be, as in `PLACES`; empty: there need not be one.
    """

    needed: tuple[tuple[str, ...], ...]
    others: tuple[str, ...] = ()
    places: tuple[tuple[frozenset[str], frozenset[str]], ...] = ()

    @property
    def known(self) -> tuple[str, ...]:
        """All columns."""
        needed = (name for group in self.needed for name in group)
        return tuple(dict.fromkeys((*needed, *self.others)))


@dataclass(frozen=True, slots=True)
class Wishes:
    """What was asked for about the columns of all files of a question.

    Parameters
    ----------
    ours
        Our name of a column by what the files call it.
    ignored
        Columns that are not read; ``*``: all that are not known.
    shown
        The names in `ours` as they were given.
    """

    ours: Mapping[str, str]
    ignored: frozenset[str]
    shown: Mapping[str, str]

    @classmethod
    def of(
        cls,
        columns: Mapping[str, str | Sequence[str]],
        ignored: Iterable[str],
        known: Sequence[str],
    ) -> Wishes:
        """Return the wishes of `qrobot.read`; a mapping to what is no column of ours is refused."""
        found: dict[str, str] = {}
        shown: dict[str, str] = {}
        for name, theirs in columns.items():
            if name not in (*known, *ALIASES):
                raise InputError(
                    f"{name!r:.60} is not a column that qRobot reads",
                    field="columns",
                    advice=_meant(name, known) or f"use one of {', '.join(known)}",
                )
            for their in [theirs] if isinstance(theirs, str) else theirs:
                ours = ALIASES.get(name, name)
                shown[_plain(their)] = their
                if found.setdefault(_plain(their), ours) != ours:
                    raise InputError(
                        f"{their!r:.60} is to be both {found[_plain(their)]!r} and {ours!r}",
                        field="columns",
                        advice="keep one of them",
                    )
        return cls(found, frozenset(map(_plain, ignored)), shown)

    def check(self, sheets: Sequence[Sheet]) -> None:
        """Refuse a wish about a column that no file has; the first is named in the error."""
        headers = [{_plain(n): n for n in sheet.rows[0][1]} for sheet in sheets if sheet.rows]
        if not headers or not sheets[0].rows:
            return  # which is told by whoever reads it
        known = {name for header in headers for name in header}
        where = sheets[0].where(sheets[0].rows[0][0])
        first = {name: shown for name, shown in headers[0].items() if name}
        for their, ours in self.ours.items():
            if their not in known:
                close = difflib.get_close_matches(their, first, n=1)
                raise sheets[0].error(
                    where,
                    f"no column is called {self.shown[their]!r:.60} (which --columns calls {ours})",
                    f"did you mean {first[close[0]]!r}?"
                    if close
                    else f"the header has {', '.join(first.values()):.200}",
                )
        for name in sorted(self.ignored - known - {ALL}):
            raise sheets[0].error(
                where,
                f"column {name!r:.60} cannot be ignored: it is not in the header",
                "leave it out of --ignore-columns",
            )


def lines_of(sheet: Sheet, kind: Kind, wishes: Wishes) -> tuple[list[Line], list[str]]:
    """Return the lines of a table below its header, and the columns that ``*`` ignored."""
    if not sheet.rows:
        begin = ", ".join(group[0] for group in kind.needed)
        place = " and a place" if kind.places else ""
        raise sheet.error("", "has no header", f"begin with {begin}{place}")
    (header_line, header), *body = sheet.rows
    theirs = [_plain(cell) for cell in header]
    while theirs and not theirs[-1]:  # a trailing delimiter
        theirs.pop()
    where = sheet.where(header_line)

    def error(problem: str, advice: str) -> InputError:
        return sheet.error(where, problem, advice)

    for number, cells in body:
        if len(cells) < len(theirs) or any(cells[len(theirs) :]):
            raise sheet.error(
                sheet.where(number),
                f"{len(cells)} cells where the header has {len(theirs)}",
                "add or remove cells (quote a cell that holds a separator)"
                if sheet.delimiter
                else "name every column in the header, or remove what is beside the table",
            )
    columns = [wishes.ours.get(name) or ALIASES.get(name, name) for name in theirs]
    kept, passed = _kept(theirs, columns, body, kind, wishes, error)
    _check_columns([columns[at] for at in kept], [theirs[at] for at in kept], kind, error)
    numeric = [at for at in kept if columns[at] not in TEXTS]
    marks = DecimalMarks.of(sheet.delimiter, (cells[at] for _, cells in body for at in numeric))
    names = {columns[at]: " ".join(header[at].split()) for at in kept if theirs[at] != columns[at]}
    return [
        Line(number, {columns[at]: cells[at] for at in kept}, marks, sheet, names)
        for number, cells in body
    ], passed


def _kept(
    theirs: list[str],
    columns: list[str],
    body: list[tuple[int, list[str]]],
    kind: Kind,
    wishes: Wishes,
    error: Error,
) -> tuple[list[int], list[str]]:
    """Return which columns are read, none that is empty throughout, and what ``*`` ignores."""
    mapped = {ours for name, ours in zip(theirs, columns, strict=True) if name in wishes.ours}
    needed = {name for group in kind.needed for name in group}
    kept, passed = [], []
    for at, (name, column) in enumerate(zip(theirs, columns, strict=True)):
        used = [number for number, cells in body if cells[at]]
        other = column in mapped and name not in wishes.ours
        if name in wishes.ignored:
            _check_ignored(name, column in needed and not other, error)
        elif body and not used and column not in needed:
            continue
        elif ALL in wishes.ignored and (other or column not in kind.known):
            passed.append(name or f"number {at + 1}")
        else:
            if not name:
                raise _nameless(at, used, error)
            _check_known(name, column, other, kind, error)
            kept.append(at)
    return kept, passed


def _nameless(at: int, used: list[int], error: Error) -> InputError:
    filled = f", but line {used[0]} fills it" if used else ""
    return error(
        f"column {at + 1} has no name{filled}",
        "name it in the header, or remove it",
    )


def _check_ignored(name: str, needed: bool, error: Error) -> None:
    if needed:
        raise error(
            f"column {name!r:.60} cannot be ignored: it is needed",
            "leave it out of --ignore-columns",
        )


def _plain(name: str) -> str:
    """Return the name of a column as headers are compared."""
    return " ".join(canonical(name).lower().split())


def _meant(name: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(_plain(name), known, n=1)
    return f"did you mean {close[0]!r}?" if close else ""


def _check_known(name: str, column: str, other: bool, kind: Kind, error: Error) -> None:
    keep = f"--ignore-columns {name:.40}"
    if other:
        raise error(
            f"column {name!r:.60} is not the one that the mapping calls {column!r}",
            f"give {keep}",
        )
    if column not in kind.known:
        meant = _meant(column, kind.known)
        raise error(
            f"column {name!r:.60} is not known",
            f"{meant} If not, give {keep}"
            if meant
            else f"remove it, or give {keep}; known are {', '.join(kind.known)}",
        )


def _check_columns(columns: list[str], theirs: list[str], kind: Kind, error: Error) -> None:
    for at, column in enumerate(columns):
        first = columns.index(column)
        if first < at:
            both = f"{theirs[first]!r:.60} and {theirs[at]!r:.60} are both {column!r}"
            raise error(
                f"column {column!r} is there twice" if theirs[first] == theirs[at] else both,
                "keep one",
            )
    missing = [group[0] for group in kind.needed if not set(group) & set(columns)]
    if missing:
        raise error(
            f"column {missing[0]!r} is missing",
            "add it to the header, or name the one that it is (--columns)",
        )
    if not kind.places:
        return
    given = set(columns) & set().union(*(needed | more for needed, more in kind.places))
    if not any(needed <= given <= needed | more for needed, more in kind.places):
        raise error(
            f"the columns {', '.join(sorted(given))} are not a place" if given else "has no place",
            "give aisle and slot (and block, side), or x and y, or node, or pose"
            + (", or place" if any("place" in needed for needed, _ in kind.places) else ""),
        )
