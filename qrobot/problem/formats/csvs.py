"""Orders as CSV, with the layout and the robots as native JSON beside them.

Columns, in any sequence: ``order, item, weight`` and the place (``aisle, slot`` and, when
wanted, ``block`` and ``side``; or ``x, y``; or ``node``), and ``quantity`` when one line
means several pieces. An unknown column is refused, not passed over: a misspelt
``quantity`` would lose weight without a word.
"""

from __future__ import annotations

import csv
import difflib
import io
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem import Instance, Item, Node, Order, Place, Point, Slot
from qrobot.problem.formats.native import Layout, read_layout
from qrobot.problem.units import exact

__all__ = ["read_csv"]

_REQUIRED = ("order", "item", "weight")
_PLACES: tuple[tuple[set[str], set[str]], ...] = (
    ({"aisle", "slot"}, {"block", "side"}),
    ({"x", "y"}, set()),
    ({"node"}, set()),
)
"""Columns that a place needs, and those that it may have."""
_COLUMNS = (*_REQUIRED, "quantity", "aisle", "block", "slot", "side", "x", "y", "node")


@dataclass(frozen=True, slots=True)
class _Line:
    """One line of the file, its cells by column."""

    number: int
    cells: dict[str, str]
    decimal_comma: bool

    def error(self, column: str, problem: str, mend: str) -> InputError:
        return InputError(problem, field=f"line {self.number}, column {column}", mend=mend)

    def text(self, column: str) -> str:
        cell = self.cells[column].strip()
        if not cell:
            raise self.error(column, "is empty", "fill it in")
        if len(cell) > 90 or not cell.isprintable():
            raise self.error(column, f"{cell!r:.60} is no name", "use up to 90 printable letters")
        return cell

    def number_of(self, column: str) -> Fraction:
        cell = self.text(column)
        try:
            return exact(cell.replace(",", ".") if self.decimal_comma else cell, field="")
        except InputError as error:
            raise self.error(column, error.problem, error.mend or "correct it") from None

    def whole(self, column: str, *, least: int = 0) -> int:
        number = self.number_of(column)
        if number.denominator != 1 or number < least:
            raise self.error(
                column,
                f"{self.cells[column].strip()} is not a whole number from {least}",
                "correct it",
            )
        return int(number)


def read_csv(
    path: StrPath, layout: StrPath | None = None, ignore_columns: Sequence[str] = ()
) -> Instance:
    """Return the instance of CSV orders and their layout.

    Parameters
    ----------
    path
        The orders. Comma, semicolon or tab separate; with semicolons a decimal comma is
        understood. A byte order mark and any line ends are fine.
    layout
        The native document without items; by default ``<stem>.layout.json`` or
        ``layout.json`` in the same folder.

    Raises
    ------
    InputError
        With file, line and column.
    """
    lines = list(_lines(read_text(path)))
    plan = _layout_of(Path(path), layout)
    # One article may be in several orders: then the order's name tells the pieces apart.
    spread = Counter(item for _, item in {(x.text("order"), x.text("item")) for x in lines})
    items: list[Item] = []
    orders: dict[str, list[str]] = {}
    seen: dict[str, int] = {}
    for line in lines:
        order, name = line.text("order"), line.text("item")
        id_ = f"{order}/{name}" if spread[name] > 1 else name
        if id_ in seen:
            raise line.error(
                "item",
                f"item {name!r} of order {order!r} is in line {seen[id_]} too",
                "use the column quantity, or another name",
            )
        seen[id_] = line.number
        pieces = line.whole("quantity", least=1) if "quantity" in line.cells else 1
        items.append(Item(id_, line.number_of("weight") * pieces, _place(line)))
        orders.setdefault(order, []).append(id_)
    try:
        return Instance(
            warehouse=plan.warehouse,
            items=tuple(items),
            orders=tuple(Order(id_, tuple(names)) for id_, names in orders.items()),
            robots=plan.robots,
            name=Path(path).stem,
            comment=plan.comment,
        )
    except InputError as error:
        # The domain speaks of items[3].at.slot: here that is a line and a column.
        found = re.match(r"items\[(\d+)\]\.(?:at\.)?(\w+)", error.field or "")
        if found is None:
            raise
        column = {"at": "place"}.get(found[2], found[2])
        raise lines[int(found[1])].error(column, error.problem, error.mend or "") from None


def _lines(text: str) -> Iterator[_Line]:
    head = text.lstrip().splitlines()[0]
    delimiter = max(",;\t", key=head.count)
    rows = csv.reader(
        io.StringIO(text, newline=""), delimiter=delimiter, strict=True, skipinitialspace=True
    )
    columns: list[str] = []
    try:
        for row in rows:
            cells = [cell.strip() for cell in row]
            if not any(cells):
                continue
            if not columns:
                columns = [cell.lower() for cell in cells]
                _check_columns(columns, rows.line_num)
                continue
            if len(cells) != len(columns):
                raise InputError(
                    f"{len(cells)} cells where the header has {len(columns)}",
                    field=f"line {rows.line_num}",
                    mend="add or remove cells (quote a cell that holds a separator)",
                )
            yield _Line(rows.line_num, dict(zip(columns, cells, strict=True)), delimiter == ";")
    except csv.Error as error:
        raise InputError(
            f"broken CSV ({error})", field=f"line {rows.line_num}", mend="correct it there"
        ) from None


def _check_columns(columns: list[str], line: int) -> None:
    where = f"line {line}"
    for column in columns:
        if column not in _COLUMNS:
            close = difflib.get_close_matches(column, _COLUMNS, n=1)
            raise InputError(
                f"column {column!r:.60} is not known",
                field=where,
                mend=f"did you mean {close[0]!r}?"
                if close
                else f"remove it; known are {', '.join(_COLUMNS)}",
            )
        if columns.count(column) > 1:
            raise InputError(f"column {column!r} is there twice", field=where, mend="keep one")
    missing = [column for column in _REQUIRED if column not in columns]
    if missing:
        raise InputError(
            f"column {missing[0]!r} is missing", field=where, mend="add it to the header"
        )
    given = set(columns) & set().union(*(needed | more for needed, more in _PLACES))
    if not any(needed <= given <= needed | more for needed, more in _PLACES):
        raise InputError(
            f"the columns {', '.join(sorted(given))} are no place" if given else "has no place",
            field=where,
            mend="give aisle and slot (and block, side), or x and y, or node",
        )


def _place(line: _Line) -> Place:
    if "node" in line.cells:
        return Node(line.whole("node"))
    if "x" in line.cells:
        return Point(float(line.number_of("x")), float(line.number_of("y")))
    side = line.cells.get("side", "").lower() or "left"
    if side not in ("left", "right"):
        raise line.error("side", f"{side!r:.40} is not a side", "give left or right")
    return Slot(
        aisle=line.whole("aisle"),
        slot=line.whole("slot"),
        block=line.whole("block") if "block" in line.cells else 0,
        side="right" if side == "right" else "left",
    )


def _layout_of(orders: Path, given: StrPath | None) -> Layout:
    """Read the layout that was named or lies beside; its errors carry its own name."""
    beside = [orders.with_name(f"{orders.stem}.layout.json"), orders.with_name("layout.json")]
    found = Path(given) if given is not None else next((p for p in beside if p.is_file()), None)
    if found is None:
        raise InputError(
            "has no layout beside it",
            mend=f"add {beside[0].name} or layout.json to its folder, or name one (--layout)",
        )
    try:
        return read_layout(found)
    except InputError as error:
        raise error.in_file(str(found)) from None
