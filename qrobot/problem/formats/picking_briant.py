"""The format of Briant and others (2020) for joint order batching and picker routing.

Every section has a title that begins with ``//``. The files tell all distances. Where aisles,
blocks and depot give the same ones, the instance has an aisle warehouse; otherwise it has the
table of the file.
"""

from __future__ import annotations

import bisect
import math
import re
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from qrobot._files import read_text
from qrobot.errors import InputError
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    Order,
    Place,
    Robot,
    Slot,
    Warehouse,
)
from qrobot.problem.fleets import fleet_of_size
from qrobot.problem.formats.lines import Line, Lines
from qrobot.problem.formats.registry import ReadOptions, builtin, checked
from qrobot.problem.units import common_unit, exact

__all__ = ["FORMAT", "read_briant"]

_CUT = "complete the section (the file may be cut off), or correct the number"


@dataclass(slots=True)
class _Section:
    """A title and the lines below it."""

    title: Line
    rows: list[Line]

    def one(self) -> Line:
        """Return the only line."""
        if len(self.rows) != 1:
            raise self.title.error(f"{len(self.rows)} lines where one number belongs", _CUT)
        return self.rows[0]

    def whole(self, *, least: int = 0) -> int:
        """Return the only line as a whole number."""
        line = self.one()
        return line.whole(line.text, "the number", least=least)


class _File:
    """The sections of a file by their titles."""

    def __init__(self, text: str) -> None:
        self._sections: list[_Section] = []
        for line in Lines(text):
            if line.text.startswith("//"):
                self._sections.append(_Section(line, []))
            elif not self._sections:
                raise line.error("stands before the first title", "begin with //NbLocations")
            else:
                self._sections[-1].rows.append(line)

    def section(self, title: str) -> _Section:
        """Return the section whose title begins so."""
        start = title.lower()
        for section in self._sections:
            if section.title.text.removeprefix("//").strip().lower().startswith(start):
                return section
        raise InputError("is missing", field=f"//{title}", advice="add it (the file may be cut)")


@dataclass(slots=True)
class _Map:
    """Where the locations of a file are, and how far apart."""

    depot: int
    end: int
    points: dict[int, tuple[Fraction, Fraction]]
    crossings: list[int]
    doors: dict[int, float]
    """Arcs of the depot: location and length."""
    ways: dict[tuple[int, int], float]


def read_briant(path: Path, capacity: Fraction | None = None) -> Instance:
    """Return the instance of a file of Briant and others.

    A robot carries so many boxes, and each order fills the boxes that the file says: the first
    item of an order weighs all of them. An item is named by its order and its product: ``3/17``.

    Parameters
    ----------
    path
        A file of joint order batching and picker routing.
    capacity
        Boxes of a trolley, in the place of the file's K.

    Raises
    ------
    InputError
        When the file is broken.
    """
    file = _File(read_text(path, fallback="latin-1"))
    locations = _products(file)
    boxes, orders, lines = _orders(file, locations)
    map_ = _map(file)
    for number, (place, line) in locations.items():
        if place in map_.crossings or place in (map_.depot, map_.end) or place not in map_.points:
            raise line.error(
                f"location {place} of product {number} is not a place in an aisle",
                "give it one that is neither depot nor crossing, and has coordinates",
            )
    picked = sorted({place for place, _ in locations.values()})
    warehouse, places, remarks = _warehouse(map_, picked)
    items: list[Item] = []
    item_lines: list[Line] = []
    for number, pieces in orders.items():
        for i, (product, quantity) in enumerate(pieces.items()):
            weight = Fraction(0 if i else boxes[number])
            at = places[locations[product][0]]
            name = f"{number}/{product}"
            items.append(Item(name, weight, at, quantity=quantity, article=str(product)))
            item_lines.append(lines[number])
    if capacity is None:
        capacity = Fraction(file.section("K").whole(least=1))

    def make() -> Instance:
        return Instance(
            warehouse=warehouse,
            items=tuple(items),
            orders=tuple(
                Order(f"{number}", tuple(f"{number}/{product}" for product in pieces))
                for number, pieces in orders.items()
            ),
            robots=fleet_of_size((Robot("R1", capacity),), None, len(orders)),
            name=path.stem,
            remarks=remarks,
        )

    def where(field: str) -> str:
        found = re.match(r"(items|orders)\[(\d+)\]", field)
        if found is None:
            return field
        rows = item_lines if found[1] == "items" else list(lines.values())
        return rows[int(found[2])].where

    return checked(make, where)


def _products(file: _File) -> dict[int, tuple[int, Line]]:
    """Return location and line of each product."""
    section = file.section("Idx Location")
    count = file.section("NbProducts").whole()
    if len(section.rows) != count:
        raise section.title.error(f"{len(section.rows)} products where NbProducts is {count}", _CUT)
    found: dict[int, tuple[int, Line]] = {}
    for line in section.rows:
        number, place, *_ = _wholes(line, 2)
        if number in found:
            raise line.error(f"product {number} is given twice", "keep one of the lines")
        found[number] = place, line
    return found


def _orders(
    file: _File, products: dict[int, tuple[int, Line]]
) -> tuple[dict[int, int], dict[int, dict[int, int]], dict[int, Line]]:
    """Return the boxes of each order, the pieces of each of its products, and its line."""
    section = file.section("Idx M")
    count = file.section("Nb Orders").whole()
    if len(section.rows) != count:
        raise section.title.error(f"{len(section.rows)} orders where Nb Orders is {count}", _CUT)
    boxes: dict[int, int] = {}
    orders: dict[int, dict[int, int]] = {}
    lines: dict[int, Line] = {}
    for line in section.rows:
        number, filled, kinds, *rest = _wholes(line, 3)
        if number in orders:
            raise line.error(
                f"order {number} is in line {lines[number].number} too", "number each once"
            )
        if len(rest) != 2 * kinds:
            raise line.error(
                f"{len(rest)} numbers where {kinds} products and quantities belong", _CUT
            )
        boxes[number], lines[number] = filled, line
        pieces: dict[int, int] = {}
        for product, quantity in zip(rest[::2], rest[1::2], strict=True):
            if product not in products:
                raise line.error(
                    f"order {number} names the unknown product {product}",
                    "add the product or correct the number",
                )
            if quantity < 1:
                raise line.error(f"0 pieces of product {product}", "use a number from 1")
            pieces[product] = pieces.get(product, 0) + quantity
        orders[number] = pieces
    return boxes, orders, lines


def _wholes(line: Line, least: int) -> list[int]:
    """Return the words of a line as whole numbers, at least so many."""
    if len(line.words) < least:
        raise line.error(f"{len(line.words)} numbers where {least} belong", _CUT)
    return [line.whole(word, "the number") for word in line.words]


def _map(file: _File) -> _Map:
    depot, end = (file.section(title).whole() for title in ("DepartingDepot", "ArrivalDepot"))
    last = file.section("NbLocations").whole(least=1)
    crossings = file.section("NbVerticesIntersections").whole()
    points = {}
    for line in file.section("Vertices").rows:
        number, x, y, *_ = [*line.text.split(maxsplit=3), "", ""]
        at = line.whole(number, "location"), _coordinate(line, x), _coordinate(line, y)
        points[at[0]] = at[1:]
    doors, ways = {}, {}
    for line in file.section("Start End").rows:
        a, b, length = _way(line)
        if depot in (a, b):
            doors[a + b - depot] = length
    for line in file.section("LocStart").rows:
        a, b, length = _way(line)
        ways[a, b] = length
    return _Map(depot, end, points, list(range(max(last - crossings, 0), last)), doors, ways)


def _coordinate(line: Line, word: str) -> Fraction:
    try:
        return exact(word, field="")
    except InputError as error:
        raise line.error(f"the coordinate {error.problem}", error.advice or "correct it") from None


def _way(line: Line) -> tuple[int, int, float]:
    if len(line.words) != 3:
        raise line.error(f"{len(line.words)} words where two locations and a length belong", _CUT)
    a, b, length = line.words
    return line.whole(a, "location"), line.whole(b, "location"), line.length(length, "the length")


# -- the warehouse -------------------------------------------------------------------


def _warehouse(
    map_: _Map, picked: list[int]
) -> tuple[Warehouse, dict[int, Place], tuple[str, ...]]:
    """Return a warehouse with the distances of the file, and where the locations are in it."""
    rows, columns = [map_.depot, *picked], [map_.end, *picked]
    matrix = [[map_.ways.get((a, b), math.inf) for b in columns] for a in rows]
    try:
        found = _aisles(map_, picked)
    except InputError:
        found = None  # no such layout can be built
    if found is not None:
        warehouse, slots = found
        own = warehouse.distance_matrix([slots[place] for place in picked])
        if all(
            abs(float(own[i, j]) - length) <= 1e-6 or i == j
            for i, row in enumerate(matrix)
            for j, length in enumerate(row)
        ):
            return warehouse, dict(slots), ()
    positions = [map_.points.get(place) for place in rows]
    table = DistanceTable(
        tuple(tuple(row) for row in matrix),
        positions=None
        if None in positions
        else tuple((float(p[0]), float(p[1])) for p in positions if p is not None),
    )
    remark = "the locations do not make up an aisle warehouse: the distances are a table"
    return table, {place: Node(i + 1) for i, place in enumerate(picked)}, (remark,)


def _aisles(map_: _Map, picked: list[int]) -> tuple[AisleWarehouse, dict[int, Slot]] | None:
    """Return the layout that the coordinates show, and the slot of each location."""
    if not map_.doors or not {*map_.crossings} <= map_.points.keys():
        return None
    xs, ys = (sorted({map_.points[c][axis] for c in map_.crossings}) for axis in (0, 1))
    pitches = {b - a for a, b in pairwise(xs)} or {Fraction(1)}
    doors = [(map_.points[c], length) for c, length in map_.doors.items() if c in map_.crossings]
    bottoms = {y for (_, y), _ in doors}
    grid = len(xs) * len(ys) == len(map_.crossings) and len(ys) > 1 and len(pitches) == 1
    if not grid or len(doors) < len(map_.doors) or len(bottoms) != 1:
        return None
    at = {}
    for place in picked:
        x, y = map_.points[place]
        block = bisect.bisect(ys, y) - 1
        if x not in xs or y in ys or not 0 <= block < len(ys) - 1:
            return None
        at[place] = xs.index(x), block, y - ys[block]
    front = min(offset for *_, offset in at.values())
    steps = [offset - front for *_, offset in at.values()]
    pitch = common_unit(steps, field="")
    slots = int(max(steps) / pitch) + 1
    inside = front + (slots - 1) * pitch
    (door, length), *others = sorted(
        ((xs.index(x), length) for (x, _), length in doors), key=lambda way: way[1]
    )
    warehouse = AisleWarehouse(
        aisles=len(xs),
        blocks=len(ys) - 1,
        slots=slots,
        aisle_pitch=float(pitches.pop()),
        slot_pitch=float(pitch),
        depot_aisle=door,
        depot_cross_aisle=ys.index(bottoms.pop()),
        depot_distance=length,
        block_gaps=tuple((float(front), float(b - a - inside)) for a, b in pairwise(ys)),
        depot_ways=tuple(others),
    )
    return warehouse, {
        place: Slot(aisle, int((offset - front) / pitch), block)
        for place, (aisle, block, offset) in at.items()
    }


def _read(path: Path, options: ReadOptions) -> Instance:
    return read_briant(path, options.capacity)


def _is_briant(start: str) -> bool:
    return re.match(r"\s*//\s*Nb", start, re.IGNORECASE) is not None


FORMAT = builtin(__name__, _read, recognise=_is_briant)
