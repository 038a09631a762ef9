"""The HI format of order batching and picker routing: one block of aisles, orders of articles.

Hessler and Irnich brought the sets of Henn, Muter and Bahceci into this form. Cell 0 is next to
the top cross aisle: the values that were published for the sets are met this way only.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from qrobot._files import read_text
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Place, Robot, Slot, Stock
from qrobot.problem.fleets import fleet_of_size
from qrobot.problem.formats.lines import Line, Lines
from qrobot.problem.formats.registry import ReadOptions, builtin, checked

__all__ = ["FORMAT", "read_hi"]

_BATCHING = "ORDER_BATCHING"
_SCATTERED = "SINGLE_PICKER_ROUTING_WITH_SCATTERED_STORAGE"
_SINGLE_PICKER = {"SINGLE_PICKER_ROUTING", _SCATTERED}
_LAYOUT = {
    # what the domain calls it: the field of the header
    "aisles": "NUM_AISLES",
    "slots": "NUM_CELLS",
    "aisle_pitch": "DISTANCE_AISLE_TO_AISLE",
    "slot_pitch": "DISTANCE_CELL_TO_CELL",
    "end_gap": "DISTANCE_BOTTOM_TO_CELL",
    "block_gaps[0].front": "DISTANCE_BOTTOM_TO_CELL",
    "block_gaps[0].back": "DISTANCE_TOP_TO_CELL",
    "depot.aisle": "DEPOT_AISLE",
    "depot.cross_aisle": "DEPOT_LOCATION",
    "depot.distance": "DISTANCE_TOP_OR_BOTTOM_TO_DEPOT",
    "robots[0].capacity": "PICKER_CAPACITY",
}
_HEADER = {"NAME", "TYPE", "COMMENT", "LAYOUT", *_LAYOUT.values()}
_CHUNK = 256
"""Places whose distances are found at once."""
_CUT = "complete the section (the file may be cut off), or correct the number"


@dataclass(slots=True)
class _File:
    """What stands in a file, with the line of each thing."""

    header: dict[str, tuple[Line, str]] = field(default_factory=dict)
    weights: dict[int, Fraction] = field(default_factory=dict)
    places: dict[int, list[Stock]] = field(default_factory=dict)
    orders: list[dict[int, int]] = field(default_factory=list)
    """Pieces of each article, an order each."""
    order_lines: list[Line] = field(default_factory=list)
    article_lines: list[dict[int, Line]] = field(default_factory=list)
    """Where an order first lists each article."""
    item_lines: list[Line] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def text(self, name: str) -> str:
        """Return the value of a field of the header, empty without one."""
        return self.header[name][1] if name in self.header else ""

    def field(self, name: str) -> tuple[Line, str]:
        """Return line and value of a field of the header that must be there."""
        if name not in self.header:
            raise InputError("is missing", field=name, advice="add it to the header")
        return self.header[name]

    def whole(self, name: str, *, least: int, most: int) -> int:
        """Return a field as a whole number."""
        line, value = self.field(name)
        return line.whole(value, name, least=least, most=most)

    def length(self, name: str) -> float:
        """Return a field as a length."""
        line, value = self.field(name)
        return line.length(value, name)

    def where(self, path: str) -> str:
        """Return the place in the file of what the domain calls ``items[3].weight``."""
        found = re.match(r"(items|orders)\[(\d+)\]", path)
        if found is not None:
            lines = self.item_lines if found[1] == "items" else self.order_lines
            return lines[int(found[2])].where
        name = _LAYOUT.get(path, "")
        return f"{name}, {self.header[name][0].where}" if name in self.header else path


def read_hi(path: Path, capacity: Fraction | None = None) -> Instance:
    """Return the instance of a file in the HI format.

    Orders are named ``1`` to ``n`` in their sequence, an item by its order and its article:
    ``3/17``. Pieces of an article that an order lists several times add up.

    Parameters
    ----------
    path
        A file of order batching, or of the tour of a single picker.
    capacity
        Takes the place of PICKER_CAPACITY.

    Raises
    ------
    InputError
        When the file is broken, or asks for what is not planned.
    """
    file = _File()
    lines = Lines(read_text(path, fallback="latin-1"))
    _read_header(file, lines)
    kind = file.text("TYPE").upper() or _BATCHING
    if kind not in {_BATCHING, *_SINGLE_PICKER}:
        raise file.field("TYPE")[0].error(
            f"the type {kind:.40} is not planned", "give Order_batching or Single_picker_routing"
        )
    _read_articles(file, lines)
    warehouse = _warehouse(file)
    _read_places(file, lines, warehouse)
    _read_orders(file, lines, alone=kind != _BATCHING)
    stock = _stock(file, kind)
    items, orders = _collected(file, warehouse, stock)
    if capacity is None:
        capacity = _capacity(file, kind, sum((item.weight for item in items), Fraction(0)))

    def make() -> Instance:
        return Instance(
            warehouse=warehouse,
            items=items,
            orders=orders,
            robots=fleet_of_size((Robot("R1", capacity),), None, len(orders)),
            name=_printable(file.text("NAME")).removesuffix(".txt") or path.stem,
            comment=_printable(file.text("COMMENT")),
            remarks=tuple(file.notes),
            stock=tuple(stock),
        )

    return checked(make, file.where)


def _read_header(file: _File, lines: Lines) -> None:
    while (line := lines.take("ARTICLE_SECTION")).text != "ARTICLE_SECTION":
        name, colon, value = (part.strip() for part in line.text.partition(":"))
        if not colon:
            raise line.error(f"{line.text!r:.60} is not a field", "write it as NAME : value")
        if name not in _HEADER:
            raise line.error(
                f"{name:.40} is not a field that qRobot knows",
                "remove it if plans may ignore it",
            )
        if name in file.header:
            before = file.header[name][0].number
            raise line.error(f"{name} is given in line {before} too", "keep one of them")
        file.header[name] = line, value
    if (layout := file.text("LAYOUT")) not in ("", "single-block"):
        raise file.field("LAYOUT")[0].error(
            f"the layout {layout:.40} is not read", "give a file with LAYOUT : single-block"
        )


def _warehouse(file: _File) -> AisleWarehouse:
    line, side = file.field("DEPOT_LOCATION")
    if side not in ("bottom", "top"):
        raise line.error(f"{side!r:.40} is not a side of the aisles", "write bottom or top")
    bottom, top = (file.length(f"DISTANCE_{end}_TO_CELL") for end in ("BOTTOM", "TOP"))
    aisles = file.whole("NUM_AISLES", least=1, most=10**6)
    try:
        return AisleWarehouse(
            aisles=aisles,
            slots=file.whole("NUM_CELLS", least=1, most=10**6),
            aisle_pitch=file.length("DISTANCE_AISLE_TO_AISLE"),
            slot_pitch=file.length("DISTANCE_CELL_TO_CELL"),
            end_gap=bottom,
            block_gaps=() if top == bottom else ((bottom, top),),
            depot_aisle=file.whole("DEPOT_AISLE", least=0, most=aisles - 1),
            depot_cross_aisle=int(side == "top"),
            depot_distance=file.length("DISTANCE_TOP_OR_BOTTOM_TO_DEPOT"),
        )
    except InputError as error:
        raise InputError(
            error.problem, field=error.field and file.where(error.field), advice=error.advice
        ) from None


def _count(line: Line, name: str) -> int:
    """Return the number of a line ``NAME : n``."""
    found, _, value = (part.strip() for part in line.text.partition(":"))
    if found != name:
        raise line.error(f"{line.text!r:.60} stands where {name} belongs", _CUT)
    return line.whole(value, name)


def _values(line: Line, *names: str) -> list[str]:
    """Return the values of a line ``NAME value NAME value ...``, in the sequence of the names."""
    pairs = dict(zip(line.words[::2], line.words[1::2], strict=False))
    if len(line.words) % 2 or set(pairs) != set(names) or len(line.words) != 2 * len(names):
        form = " ".join(f"{name} .." for name in names)
        raise line.error(
            f"{line.text!r:.60} is not an entry of this section", f"write it as {form}"
        )
    return [pairs[name] for name in names]


def _start(lines: Lines, section: str, count: str) -> int:
    """Step over the title of a section and return how many entries it has."""
    line = lines.take(section)
    if line.text != section:
        raise line.error(f"{line.text!r:.60} stands where {section} belongs", _CUT)
    return _count(lines.take(count), count)


def _read_articles(file: _File, lines: Lines) -> None:
    for _ in range(_count(lines.take("NUM_ARTICLES"), "NUM_ARTICLES")):
        line = lines.take("an article")
        if len(line.words) == 2:  # the tour of a single picker has no load
            (article,), weight = _values(line, "ID"), "1"
        else:
            article, weight = _values(line, "ID", "WEIGHT")
        number = line.whole(article, "article")
        if number in file.weights:
            raise line.error(f"article {number} is given twice", "keep one of the lines")
        file.weights[number] = line.weight(weight, "weight")


def _article(file: _File, line: Line, word: str) -> int:
    article = line.whole(word, "article")
    if article not in file.weights:
        raise line.error(
            f"article {article} is not in ARTICLE_SECTION", "add it there or correct the number"
        )
    return article


def _read_places(file: _File, lines: Lines, warehouse: AisleWarehouse) -> None:
    for _ in range(_start(lines, "SKU_SECTION", "NUM_SKUS")):
        line = lines.take("a place of an article")
        names = ("ID", "AISLE", "CELL", "QUANTITY", "LEFT_RIGHT_HAND_SIDE")
        article, aisle, cell, quantity, side = _values(line, *names)
        number = _article(file, line, article)
        pieces = line.whole(quantity, "quantity")
        slot = Slot(
            line.whole(aisle, "aisle", most=warehouse.aisles - 1),
            warehouse.slots - 1 - line.whole(cell, "cell", most=warehouse.slots - 1),
            side="right" if side == "right" else "left",
        )
        if any(other.place == slot for other in file.places.get(number, ())):
            raise line.error(f"article {number} is in this cell twice", "give one quantity")
        file.places.setdefault(number, []).append(Stock(str(number), slot, pieces))


def _read_orders(file: _File, lines: Lines, *, alone: bool) -> None:
    if alone:
        line = lines.take("ORDER_SECTION")
        if line.text != "ORDER_SECTION":
            raise line.error(f"{line.text!r:.60} stands where ORDER_SECTION belongs", _CUT)
        _read_order(file, lines, "NUM_ARTICLES")
    else:
        for _ in range(_start(lines, "ORDER_SECTION", "NUM_ORDERS")):
            _read_order(file, lines, "NUM_ARTICLES_IN_ORDER")
    line = lines.take("EOF")
    if line.text != "EOF":
        raise line.error(f"{line.text!r:.60} stands where EOF belongs", _CUT)
    if (rest := next(lines, None)) is not None:
        file.notes.append(f"{rest.where} and what follows stand behind EOF and are not read")


def _read_order(file: _File, lines: Lines, count: str) -> None:
    line = lines.take(count)
    file.order_lines.append(line)
    pieces: dict[int, int] = {}
    listed: dict[int, Line] = {}
    for _ in range(_count(line, count)):
        line = lines.take("an article of an order")
        word, quantity = _values(line, "ID", "QUANTITY")
        article = _article(file, line, word)
        if article not in file.places:
            raise line.error(
                f"article {article} lies nowhere", "add its place to SKU_SECTION, or remove it here"
            )
        listed.setdefault(article, line)
        pieces[article] = pieces.get(article, 0) + line.whole(quantity, "quantity", least=1)
    file.orders.append(pieces)
    file.article_lines.append(listed)


def _stock(file: _File, kind: str) -> list[Stock]:
    """Return what lies where, when articles may be taken from several places; else nothing."""
    if kind != _SCATTERED and all(len(places) == 1 for places in file.places.values()):
        return []
    return [place for places in file.places.values() for place in places if place.quantity]


def _collected(
    file: _File, warehouse: AisleWarehouse, stock: list[Stock]
) -> tuple[tuple[Item, ...], tuple[Order, ...]]:
    """Return items and orders; an article with a stock is taken from the nearest places first."""
    far: dict[Stock, float] = {}
    for chunk in (stock[k : k + _CHUNK] for k in range(0, len(stock), _CHUNK)):
        row = warehouse.distance_matrix([place.place for place in chunk])[0, 1:]
        far.update(zip(chunk, row.tolist(), strict=True))
    left = {place: place.quantity for place in sorted(stock, key=far.__getitem__)}
    near: dict[str, list[Stock]] = {}
    for place in left:
        near.setdefault(place.article, []).append(place)
    items: list[Item] = []
    orders: list[Order] = []
    for o, (order, lines) in enumerate(zip(file.orders, file.article_lines, strict=True), 1):
        first = len(items)
        for article, pieces in order.items():
            taken: list[tuple[Place, int]] = [(file.places[article][0].place, pieces)]
            if stock:
                taken = _taken(near.get(str(article), []), left, pieces)
            if sum(quantity for _, quantity in taken) < pieces:
                raise lines[article].error(
                    f"more pieces of article {article} are asked for than SKU_SECTION has",
                    "ask for fewer, or add to the quantities there",
                )
            for k, (at, quantity) in enumerate(taken, 1):
                name = f"{o}/{article}" + (f"#{k}" if len(taken) > 1 else "")
                weight = quantity * file.weights[article]
                items.append(Item(name, weight, at, quantity=quantity, article=str(article)))
                file.item_lines.append(lines[article])
        orders.append(Order(f"{o}", [item.id for item in items[first:]]))
    return tuple(items), tuple(orders)


def _taken(near: list[Stock], left: dict[Stock, int], pieces: int) -> list[tuple[Place, int]]:
    """Take pieces from the nearest places that have some left, at most as many as there are."""
    taken = []
    for one in near:
        quantity = min(pieces, left[one])
        if quantity:
            left[one] -= quantity
            pieces -= quantity
            taken.append((one.place, quantity))
    return taken


def _capacity(file: _File, kind: str, total: Fraction) -> Fraction:
    if kind in _SINGLE_PICKER and "PICKER_CAPACITY" not in file.header:
        return max(total, Fraction(1))
    line, value = file.field("PICKER_CAPACITY")
    return line.weight(value, "PICKER_CAPACITY")


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable())[:200].strip()


def _read(path: Path, options: ReadOptions) -> Instance:
    return read_hi(path, options.capacity)


def _is_hi(start: str) -> bool:
    return re.search(r"^(ARTICLE_SECTION|NUM_(AISLES|CELLS)\s*:)", start, re.MULTILINE) is not None


FORMAT = builtin(__name__, _read, recognise=_is_hi)
