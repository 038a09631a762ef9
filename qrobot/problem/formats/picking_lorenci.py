"""The format of Lorenci: orders in an ``.ord`` file, a layout of one block in an ``.lyt`` file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot
from qrobot.problem.fleets import fleet_of_size
from qrobot.problem.formats.lines import Line, Lines
from qrobot.problem.formats.registry import ReadOptions, builtin, checked

__all__ = ["FORMAT", "read_lorenci"]

_LAYOUT = (
    "aisles", "positions of an aisle", "length of a position", "width of a position",
    "width of an aisle", "distance of the depot", "capacity", "number of orders",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Layout:
    warehouse: AisleWarehouse
    capacity: Fraction
    orders: int


def read_lorenci(
    path: Path, *, layout: StrPath | None = None, capacity: Fraction | None = None
) -> Instance:
    """Return the instance of an ``.ord`` file and its layout.

    Orders have the numbers of the file, items that of their order and their own: ``3/0``.

    Parameters
    ----------
    path
        The orders.
    layout
        The ``.lyt`` file; by default the one beside it whose name that of the orders begins
        with.
    capacity
        Takes the place of the layout's.

    Raises
    ------
    InputError
        When a file is broken, or there is no layout.
    """
    place = _layout_beside(path) if layout is None else Path(layout)
    try:
        plan = _read_layout(Lines(read_text(place)))
    except InputError as error:
        raise error.in_file(str(place)) from None
    items: list[Item] = []
    orders: list[Order] = []
    item_lines: list[Line] = []
    order_lines: dict[str, Line] = {}
    lines = Lines(read_text(path))
    more = 0
    for line in lines:
        number, count = _numbers(line, "an order and its number of items", 2)
        own = [
            _item(lines.take(f"an item of order {number}"), number, plan.warehouse)
            for _ in range(count)
        ]
        if len(orders) == plan.orders:
            more += count > 0  # the last line says 0 0
            continue
        if str(number) in order_lines:
            raise line.error(
                f"order {number} is in line {order_lines[str(number)].number} too",
                "number each once",
            )
        order_lines[str(number)] = line
        orders.append(Order(str(number), [item.id for item, _ in own]))
        items += [item for item, _ in own]
        item_lines += [of for _, of in own]
    if len(orders) < plan.orders:
        raise InputError(
            f"{len(orders)} orders where {place.name} says {plan.orders}",
            advice="complete the file (it may be cut off), or correct the layout",
        )

    note = f"{plan.orders} of {plan.orders + more} orders are read, as {place.name} says"

    def make() -> Instance:
        return Instance(
            warehouse=plan.warehouse,
            items=tuple(items),
            orders=tuple(orders),
            robots=fleet_of_size(
                (Robot("R1", plan.capacity if capacity is None else capacity),), None, len(orders)
            ),
            name=path.stem,
            remarks=(note,) if more else (),
        )

    def where(field: str) -> str:
        found = re.match(r"(items|orders)\[(\d+)\]", field)
        if found is None:
            return field
        rows = item_lines if found[1] == "items" else list(order_lines.values())
        return rows[int(found[2])].where

    return checked(make, where)


def _layout_beside(path: Path) -> Path:
    """Return the layout that an ``.ord`` file is named after, or the only one beside it."""
    try:
        there = sorted(path.parent.glob("*.lyt"))
    except OSError:
        there = []
    named = [
        layout
        for layout in there
        if path.stem.startswith(layout.stem) and not path.stem[len(layout.stem) :][:1].isdigit()
    ]
    if named:
        return max(named, key=lambda layout: len(layout.stem))
    if len(there) == 1:
        return there[0]
    raise InputError(
        "has no layout (.lyt) beside it that its name begins with", advice="give one by --layout"
    )


def _numbers(line: Line, what: str, count: int) -> list[int]:
    if len(line.words) != count:
        raise line.error(
            f"{line.text!r:.60} is not {what}",
            "correct the line, or the number of items above it",
        )
    return [line.whole(word, "the number") for word in line.words]


def _item(line: Line, order: int, warehouse: AisleWarehouse) -> tuple[Item, Line]:
    """Return an item: each aisle has two numbers, one a side."""
    number, side, position = _numbers(line, "an item, its aisle and its position", 3)
    if side >= 2 * warehouse.aisles:
        raise line.error(
            f"aisle {side} is outside the layout", f"use 0 to {2 * warehouse.aisles - 1}"
        )
    if position >= warehouse.slots:
        raise line.error(
            f"position {position} is outside the layout", f"use 0 to {warehouse.slots - 1}"
        )
    slot = Slot(side // 2, position, side="right" if side % 2 else "left")
    return Item(f"{order}/{number}", Fraction(1), slot), line


def _read_layout(lines: Lines) -> _Layout:
    rows = [lines.take(f"the {name}") for name in _LAYOUT]
    if (more := next(lines, None)) is not None:
        raise more.error("is one line too many", f"give {len(rows)} lines")
    aisles, positions = (row.whole(row.text, _LAYOUT[i], least=1) for i, row in enumerate(rows[:2]))
    length, width = (row.length(row.text, _LAYOUT[i]) for i, row in enumerate(rows[2:4], 2))
    for i, row in enumerate(rows[4:6], 4):
        row.length(row.text, _LAYOUT[i])
    try:
        warehouse = AisleWarehouse(
            aisles=aisles,
            slots=positions,
            aisle_pitch=2 * width,
            slot_pitch=length,
            block_gaps=((length, 0.0),),
        )
    except InputError as error:
        of = dict(zip(("aisles", "slots", "slot_pitch", "aisle_pitch"), rows, strict=False))
        raise of[error.field or ""].error(error.problem, error.advice or "correct it") from None
    capacity = rows[6].weight(rows[6].text, _LAYOUT[6])
    if not capacity:
        raise rows[6].error("capacity 0 is not positive", "use a number above zero")
    return _Layout(warehouse, capacity, rows[7].whole(rows[7].text, _LAYOUT[7]))


def _read(path: Path, options: ReadOptions) -> Instance:
    return read_lorenci(path, layout=options.layout, capacity=options.capacity)


FORMAT = builtin(__name__, _read)
