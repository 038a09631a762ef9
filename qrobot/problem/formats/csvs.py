"""Orders as a table, CSV or a workbook, with the layout and the robots as native JSON beside them.

Columns, in any sequence: ``order``, ``item`` or ``article``, ``weight`` and the place (``aisle,
slot`` and, when wanted, ``block`` and ``side``; or ``x, y``; or ``node``; or ``pose``; or
``place``, a label that a location table explains), ``pick_seconds`` (of one piece), and
``quantity`` when one line means several pieces. What an article weighs and where it lies may stand
in an article master instead. An unknown column is refused, not passed over: a misspelt
``quantity`` would lose weight without a word.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath
from qrobot._text import count
from qrobot.errors import InputError
from qrobot.problem import Instance, Item, Order, Place
from qrobot.problem.formats.cells import Line
from qrobot.problem.formats.columns import PLACES, Kind, Wishes, lines_of
from qrobot.problem.formats.masters import (
    ARTICLES,
    Bin,
    Masters,
    article_column,
    articles_of,
    bins_of,
    master_sheet,
    name_of,
)
from qrobot.problem.formats.native import Layout, read_layout
from qrobot.problem.formats.registry import ReadOptions, builtin, checked
from qrobot.problem.formats.sheets import Sheet, read_sheet
from qrobot.problem.formats.takes import Take, takes_of
from qrobot.problem.validity import some

__all__ = ["FORMAT", "read_orders"]

_LABELS = (
    *((needed, more | {"place"}) for needed, more in PLACES),
    (frozenset({"place"}), frozenset()),
)
"""Places of orders: numbers, which may have a label, or a label alone."""

_TIMES = ("release", "due", "deadline", "priority")
"""What lines may say of their order."""

_OTHERS = (
    "weight",
    "quantity",
    "pick_seconds",
    "aisle",
    "block",
    "slot",
    "side",
    "x",
    "y",
    "node",
    "pose",
    "place",
    "level",
    "volume",
    "category",
    *_TIMES,
)


def read_orders(path: Path, options: ReadOptions) -> Instance:
    """Return the instance of a table of orders and their layout, a native document without items.

    In CSV comma, semicolon or tab separate; with the latter two a decimal comma is understood. A
    byte order mark, a line ``sep=;``, any line ends and empty columns are fine.
    """
    known = tuple(dict.fromkeys(("order", "item", "article", *_OTHERS, *ARTICLES.known)))
    wishes = Wishes.of(options.columns, options.ignore_columns, known)
    sheet = read_sheet(path, "orders", options.sheet)
    locations, missing = master_sheet(path, options.locations, "locations")
    articles, _ = master_sheet(path, options.articles, "articles")
    sheets = [one for one in (sheet, locations, articles) if one is not None]
    wishes.check(sheets)
    goods = None if articles is None else articles_of(articles, wishes)
    lines, passed = lines_of(sheet, _kind(goods), wishes)
    plan = _layout_of(path, options.layout)
    bins = None if locations is None else bins_of(locations, wishes, plan.warehouse)
    masters = Masters(bins, goods, missing if locations is None else locations.source)
    takes, stock = takes_of(lines, masters)
    scattered = {one.article for one in stock}
    items: list[Item] = []
    orders: dict[str, list[tuple[str, Line]]] = {}
    for take, id_ in zip(takes, _ids(takes), strict=True):
        items.append(_item(take, id_, masters, scattered))
        orders.setdefault(take.line.text("order"), []).append((id_, take.line))
    remarks = [*_remarks(takes, items, scattered), *_hidden(sheets), *_passed(passed)]

    def make() -> Instance:
        return Instance(
            warehouse=plan.warehouse,
            items=tuple(items),
            orders=tuple(_order(id_, own) for id_, own in orders.items()),
            robots=plan.robots,
            times=plan.times,
            stock=stock,
            name=path.stem,
            comment=plan.comment,
            remarks=tuple(remarks),
            pool=options.pool,
        )

    return checked(make, lambda field: _where(takes, list(orders.values()), field))


def _kind(goods: Mapping[str, Sequence[Line]] | None) -> Kind:
    """Return which columns orders must have: not those that the article master has."""
    there = next((lines[0] for lines in (goods or {}).values()), None)
    weight = () if there is not None and there.has("weight") else (("weight",),)
    places = () if there is not None and there.has("place") else _LABELS
    return Kind((("order",), ("item", "article"), *weight), _OTHERS, places)


def _item(take: Take, id_: str, masters: Masters, scattered: Collection[str]) -> Item:
    line, pieces, article = take.line, take.pieces, name_of(take.line)
    weight = masters.quantity(line, "weight")
    if weight is None:
        raise line.error(
            article_column(line),
            f"nothing says what {article!r:.60} weighs",
            "add it to the article master",
        )
    return Item(
        id_,
        weight * pieces,
        take.bin.place,
        float((masters.quantity(line, "pick_seconds") or 0) * pieces),
        pieces,
        article if article != id_ or article in scattered else "",
        level=take.bin.level,
        label=take.bin.label,
        volume=(masters.quantity(line, "volume") or 0) * pieces,
        category=masters.text(line, "category"),
    )


def _order(id_: str, own: Sequence[tuple[str, Line]]) -> Order:
    """Return an order; what one of its lines says of its time holds for all."""
    wishes: dict[str, float] = {}
    for column in _TIMES:
        said = [line for _, line in own if line.fills(column)]
        for line in said:
            value = float(line.number_of(column))
            if wishes.setdefault(column, value) != value:
                raise line.error(
                    column,
                    f"{line.cells[column]} is not the {said[0].cells[column]} of line "
                    f"{said[0].number}, which is of order {id_!r} too",
                    f"give an order one {column}",
                )
    return Order(id_, tuple(name for name, _ in own), **wishes)


def _remarks(takes: Sequence[Take], items: Sequence[Item], scattered: Collection[str]) -> list[str]:
    """Return what whoever made the orders may not have meant."""
    if not takes:
        return ["the file has a header but no orders"]
    weights: defaultdict[str, set[Fraction]] = defaultdict(set)
    places: defaultdict[str, set[tuple[Place, str]]] = defaultdict(set)
    for take, item in zip(takes, items, strict=True):
        name = name_of(take.line)
        weights[name].add(item.weight / item.quantity)
        if name not in scattered:
            places[name].add((item.place, item.label))
    found = []
    for what, several, each in (
        ("weights", weights, "each line counts its own"),
        ("places", places, "each line is collected from its own, no other is tried"),
    ):
        if names := sorted(name for name, values in several.items() if len(values) > 1):
            verb = "article has" if len(names) == 1 else "articles have"
            found.append(f"{len(names)} {verb} several {what} ({some(names)}): {each}")
    return found


def _hidden(sheets: Iterable[Sheet]) -> list[str]:
    return [
        f"{count(sheet.hidden, 'hidden row')} of {sheet.source or 'the sheet'} "
        f"{'was' if sheet.hidden == 1 else 'were'} read like the others"
        for sheet in sheets
        if sheet.hidden
    ]


def _passed(names: Sequence[str]) -> list[str]:
    return [f"{count(len(names), 'column')} ignored: {some(names)}"] if names else []


def _where(takes: Sequence[Take], orders: Sequence[Sequence[tuple[str, Line]]], field: str) -> str:
    """Return line and column of what the domain calls ``items[3].at.slot`` or ``orders[2].due``."""
    if found := re.fullmatch(rf"orders\[(\d+)\]\.({'|'.join(_TIMES)})", field):
        lines = [line for _, line in orders[int(found[1])]]
        return next((one for one in lines if one.fills(found[2])), lines[0]).where(found[2])
    found = re.match(r"items\[(\d+)\]\.(?:at\.)?(\w+)", field)
    if found is None:
        return field
    line, column = takes[int(found[1])].line, found[2]
    if column == "id":
        column = article_column(line)
    elif not line.has(column):  # the place as a whole: its first column
        column = next((c for c in ("place", "aisle", "x", "node", "pose") if line.has(c)), column)
    return line.where(column)


def _ids(takes: Sequence[Take]) -> list[str]:
    """Return an id for each line: the article's name, with what tells its pieces apart.

    One article may be in several orders: then the order's name stands before it. One order
    may take it from several places: then they are numbered. So are the lines of an export that has
    a column ``article`` and none ``item``, even in one place; otherwise that is a mistake.
    """
    lines = [take.line for take in takes]
    named = lines[0].has("item") if lines else True
    names = [line.text("item" if named else "article") for line in lines]
    pairs = [(line.text("order"), name) for line, name in zip(lines, names, strict=True)]
    spread = Counter(name for _, name in dict.fromkeys(pairs))
    bins: defaultdict[tuple[str, str], dict[tuple[Bin, int], int]] = defaultdict(dict)
    numbers: list[int] = []
    for line, pair, take in zip(lines, pairs, takes, strict=True):
        known = bins[pair]
        key = take.bin, 0 if named else line.number
        if key in known:
            raise line.error(
                "item",
                f"item {pair[1]!r} of order {pair[0]!r} is in line {known[key]} too",
                "use the column quantity, or another name",
            )
        known[key] = line.number
        numbers.append(len(known))
    ids: dict[str, int] = {}
    for line, pair, number in zip(lines, pairs, numbers, strict=True):
        order, name = pair
        id_ = f"{order}/{name}" if spread[name] > 1 else name
        if len(bins[pair]) > 1:
            id_ += f"#{number}"
        if id_ in ids:
            raise line.error(
                article_column(line),
                f"item {name!r} of order {order!r} has the same name as line {ids[id_]}, {id_!r}",
                "use another name",
            )
        ids[id_] = line.number
    return list(ids)


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


FORMAT = builtin(__name__, read_orders)
