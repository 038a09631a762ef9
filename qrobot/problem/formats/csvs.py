"""Orders as CSV, with the layout and the robots as native JSON beside them.

Columns, in any sequence: ``order, item, weight`` and the place (``aisle, slot`` and, when
wanted, ``block`` and ``side``; or ``x, y``; or ``node``), ``pick_seconds`` (of one piece), and
``quantity`` when one line means several pieces. An unknown column is refused, not passed
over: a misspelt ``quantity`` would lose weight without a word.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem import Instance, Item, Node, Order, Place, Point, Slot
from qrobot.problem.formats.cells import Line, read_lines
from qrobot.problem.formats.native import Layout, read_layout
from qrobot.problem.formats.registry import ReadOptions, builtin, checked

__all__ = ["FORMAT", "read_csv"]


def read_csv(path: Path, options: ReadOptions) -> Instance:
    """Return the instance of CSV orders and their layout, a native document without items.

    Comma, semicolon or tab separate; with the latter two a decimal comma is understood. A byte
    order mark, a line ``sep=;``, any line ends and empty columns are fine.
    """
    lines = read_lines(read_text(path), options.ignore_columns)
    plan = _layout_of(path, options.layout)
    items: list[Item] = []
    orders: dict[str, list[str]] = {}
    for line, id_ in zip(lines, _ids(lines), strict=True):
        pieces = line.whole("quantity", least=1) if line.has("quantity") else 1
        seconds = line.number_of("pick_seconds") if line.has("pick_seconds") else Fraction(0)
        weight, seconds = _weight(line) * pieces, seconds * pieces
        article = line.text("item") if line.text("item") != id_ else ""
        items.append(Item(id_, weight, _place(line), float(seconds), pieces, article))
        orders.setdefault(line.text("order"), []).append(id_)

    def make() -> Instance:
        return Instance(
            warehouse=plan.warehouse,
            items=tuple(items),
            orders=tuple(Order(id_, tuple(names)) for id_, names in orders.items()),
            robots=plan.robots,
            times=plan.times,
            name=path.stem,
            comment=plan.comment,
            remarks=() if items else ("the file has a header but no orders",),
            pool=options.pool,
        )

    return checked(make, lambda field: _where(lines, field))


def _where(lines: Sequence[Line], field: str) -> str:
    """Return line and column of what the domain calls ``items[3].at.slot``."""
    found = re.match(r"items\[(\d+)\]\.(?:at\.)?(\w+)", field)
    if found is None:
        return field
    column = "item" if found[2] == "id" else found[2]
    if column == "at":  # the place as a whole: its first column
        column = next(c for c in ("aisle", "x", "node") if lines[int(found[1])].has(c))
    return lines[int(found[1])].where(column)


def _ids(lines: Sequence[Line]) -> list[str]:
    """Return an id for each line: the item's name, with what tells its pieces apart.

    One article may be in several orders: then the order's name stands before it. One order
    may take it from several places: then they are numbered.
    """
    spread = Counter(item for _, item in {(x.text("order"), x.text("item")) for x in lines})
    bins: defaultdict[tuple[str, str], dict[Place, int]] = defaultdict(dict)
    for line in lines:
        known = bins[line.text("order"), line.text("item")]
        place = _place(line)
        if place in known:
            raise line.error(
                "item",
                f"item {line.text('item')!r} of order {line.text('order')!r} is in line "
                f"{known[place]} too",
                "use the column quantity, or another name",
            )
        known[place] = line.number
    found: list[str] = []
    seen: dict[str, int] = {}
    for line in lines:
        order, name = line.text("order"), line.text("item")
        places = bins[order, name]
        id_ = f"{order}/{name}" if spread[name] > 1 else name
        if len(places) > 1:
            id_ += f"#{list(places).index(_place(line)) + 1}"
        if id_ in seen:
            raise line.error(
                "item",
                f"item {name!r} of order {order!r} has the same name as line {seen[id_]}, {id_!r}",
                "use another name",
            )
        seen[id_] = line.number
        found.append(id_)
    return found


def _weight(line: Line) -> Fraction:
    weight = line.number_of("weight")
    if weight < 0:
        raise line.error(
            "weight",
            f"weight {float(weight):g} of item {line.text('item')!r} is negative",
            "use zero or more",
        )
    return weight


def _place(line: Line) -> Place:
    if line.has("node"):
        return Node(line.whole("node"))
    if line.has("x"):
        return Point(float(line.number_of("x")), float(line.number_of("y")))
    side = line.cells.get("side", "").lower() or "left"
    if side not in ("left", "right"):
        raise line.error("side", f"{side!r:.40} is not a side", "give left or right")
    return Slot(
        aisle=line.whole("aisle"),
        slot=line.whole("slot"),
        block=line.whole("block") if line.has("block") else 0,
        side="right" if side == "right" else "left",
    )


def _layout_of(orders: Path, given: StrPath | None) -> Layout:
    """Read the layout that was named or lies beside; its errors carry its own name."""
    beside = [orders.with_name(f"{orders.stem}.layout.json"), orders.with_name("layout.json")]
    found = Path(given) if given is not None else next((p for p in beside if p.is_file()), None)
    if found is None:
        raise InputError(
            "has no layout beside it",
            advice=f"add {beside[0].name} or layout.json to its folder, or name one (--layout)",
        )
    try:
        return read_layout(found)
    except InputError as error:
        raise error.in_file(str(found)) from None


FORMAT = builtin(__name__, read_csv)
