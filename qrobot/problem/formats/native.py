"""Native JSON, schema ``qrobot.instance/1``: read, and checked with our own words."""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from qrobot._files import StrPath, read_text
from qrobot.errors import InputError
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Place,
    Point,
    Pose,
    Robot,
    Slot,
    Stock,
    Times,
    Warehouse,
)
from qrobot.problem.fleets import check_fleet_size
from qrobot.problem.formats.fields import shown
from qrobot.problem.formats.jsontext import loads, located
from qrobot.problem.formats.native_maps import lanes_of, map_of
from qrobot.problem.formats.native_text import to_text
from qrobot.problem.formats.registry import ReadOptions, builtin, checked
from qrobot.problem.formats.schema import (
    KINDS,
    SCHEMA,
    AislesModel,
    Document,
    FleetModel,
    FloorModel,
    ItemModel,
    LanesModel,
    MapModel,
    NodeModel,
    PointModel,
    PoseModel,
    SlotModel,
    StockModel,
)
from qrobot.problem.validity import check_robots

__all__ = [
    "FORMAT",
    "Layout",
    "instance_of_data",
    "parse_native",
    "read_layout",
    "read_native",
    "to_text",
]


_WISHES = {
    "int_type": "a whole number",
    "string_type": "text",
    "string_unicode": "text",
    "string_too_short": "at least 1 letter",
    "string_too_long": "at most 200 letters",
    "string_pattern_mismatch": "text without control characters",
    "list_type": "a list",
    "model_type": "an object",
    "dict_type": "an object",
    "too_short": "more entries",
    "too_long": "fewer entries",
}
"""What is needed, for faults that pydantic tells in words of Python."""


@dataclass(frozen=True, slots=True)
class Layout:
    """What a document says without items and orders."""

    name: str
    comment: str
    warehouse: Warehouse
    robots: tuple[Robot, ...]
    times: Times


def parse_native(text: str, folder: Path | None = None, *, pool: bool = False) -> Instance:
    """Return the instance of native JSON text; a `pool` may be larger than one plan.

    Files that it names are relative to `folder`.

    Raises
    ------
    InputError
        When the text is not a document of this schema, or what it asks makes no sense.
    """
    with located(text):
        return _instance(_document(loads(text)), folder or Path(), pool)


def instance_of_data(data: Any) -> Instance:
    """Return the instance of a document that stands in another one, read by `jsontext.loads`.

    Whether a way leads to every item is not looked at.
    """
    return dataclasses.replace(_instance(_document(data), Path(), pool=True), pool=False)


def _instance(document: Document, folder: Path, pool: bool) -> Instance:
    if "items" not in document.model_fields_set:
        raise InputError(
            "is missing (a document without items is a layout)",
            field="items",
            advice="add the items, or give the orders as CSV with this layout",
        )
    layout = _layout(document, folder)
    items = tuple(_item(one) for one in document.items)
    if "orders" in document.model_fields_set:
        orders = tuple(
            Order(
                o.id,
                tuple(o.items),
                o.release,
                math.inf if o.due is None else o.due,
                math.inf if o.deadline is None else o.deadline,
                o.priority,
            )
            for o in document.orders
        )
    else:
        orders = tuple(Order(item.id, (item.id,)) for item in items)

    def make() -> Instance:
        return Instance(
            warehouse=layout.warehouse,
            items=items,
            orders=orders,
            robots=layout.robots,
            name=document.name,
            comment=document.comment,
            reference=document.reference,
            stock=tuple(map(_stock, document.stock)),
            times=layout.times,
            pool=pool,
        )

    return checked(make, lambda field: field)


def read_layout(path: StrPath) -> Layout:
    """Return the layout of a native document that has neither items nor orders."""
    text = read_text(path)
    with located(text):
        document = _document(loads(text))
        for name in ("items", "orders", "stock", "reference"):
            if name in document.model_fields_set:
                raise InputError(
                    "does not belong into a layout",
                    field=name,
                    advice="remove it, or solve this file",
                )
        return _layout(document, Path(path).parent)


def _document(data: Any) -> Document:
    """Check the version first: another one may mean anything by the same words."""
    if not isinstance(data, dict):
        raise InputError(f"is {shown(data)}, not an object", advice=f"see schema {SCHEMA!r}")
    if (version := data.get("schema")) != SCHEMA:
        problem = f"unknown schema {shown(version)}" if "schema" in data else "is missing"
        if isinstance(version, str) and version.startswith("qrobot.plan/"):
            problem = f"this is a plan ({version}), not an instance"
        raise InputError(problem, field="schema", advice=f"this version reads {SCHEMA!r}")
    try:
        return Document.model_validate(data)
    except ValidationError as error:
        raise _sentence(error) from None


def _sentence(error: ValidationError) -> InputError:
    """Return the first fault as one sentence: field, value, advice."""
    first = error.errors(include_url=False)[0]
    path = ""
    for part in first["loc"]:
        if isinstance(part, int):
            path += f"[{part}]"
        elif not part.startswith("<"):  # a tag of ours, not a field
            path += f".{part}"
    context, value, kind = first.get("ctx", {}), shown(first["input"]), first["type"]
    if kind == "qrobot":
        problem, advice = context["problem"], context["advice"]
        path += context["at"]
    elif kind == "missing":
        problem, advice = "is missing", "add it"
    elif kind == "kind":
        inside = isinstance(first["input"], dict)
        path += ".kind" if inside else ""
        problem = f"{shown(first['input'].get('kind')) if inside else value} is not known"
        advice = f"give {', '.join(map(repr, KINDS[:-1]))} or {KINDS[-1]!r}"
    elif kind == "place":
        problem = f"{value} is not a place"
        advice = "give aisle, block and slot; or x and y; or node; or pose"
    elif kind == "robots":
        problem, advice = f"{value} is not a fleet", "give count and capacity, or a list of robots"
    else:
        wish = _WISHES.get(kind, first["msg"].removeprefix("Input should be "))
        problem, advice = f"{value} is not right", f"needed: {wish}"
    return InputError(problem, field=path.removeprefix("."), advice=advice)


def _layout(document: Document, folder: Path) -> Layout:
    try:
        warehouse = _warehouse(document, folder)
    except InputError as error:
        if error.source is not None:  # it is about another file
            raise
        raise error.at(f"warehouse.{error.field}") from None
    fleet = document.robots
    if isinstance(fleet, FleetModel):
        check_fleet_size(fleet.count, "robots.count")
        robots = tuple(
            Robot(f"R{k + 1}", fleet.capacity, fleet.speed, fleet.trips, fleet.available)
            for k in range(fleet.count)
        )
    else:
        robots = tuple(Robot(r.id, r.capacity, r.speed, r.trips, r.available) for r in fleet)
    try:
        check_robots(robots)
    except InputError as error:
        if isinstance(fleet, FleetModel) and error.field:
            raise error.at(re.sub(r"^robots\[\d+\]", "robots", error.field)) from None
        raise
    times = Times(**document.times.model_dump())
    return Layout(document.name, document.comment, warehouse, robots, times)


def _warehouse(document: Document, folder: Path) -> Warehouse:
    model = document.warehouse
    if isinstance(model, MapModel):
        return map_of(model, folder)
    if isinstance(model, LanesModel):
        return lanes_of(model, folder)
    if isinstance(model, AislesModel):
        return AisleWarehouse(
            aisles=model.aisles,
            slots=model.slots,
            blocks=model.blocks,
            aisle_pitch=model.aisle_pitch,
            slot_pitch=model.slot_pitch,
            end_gap=model.end_gap,
            depot_aisle=model.depot.aisle,
            depot_cross_aisle=model.depot.cross_aisle,
            depot_distance=model.depot.distance,
            closed_aisles=frozenset((c.aisle, c.block) for c in model.closed_aisles),
            closed_crossings=frozenset((c.cross_aisle, c.aisle) for c in model.closed_crossings),
            one_way_aisles=frozenset((c.aisle, c.block, c.towards) for c in model.one_way_aisles),
            one_way_crossings=frozenset(
                (c.cross_aisle, c.aisle, c.towards) for c in model.one_way_crossings
            ),
            block_gaps=tuple((g.front, g.back) for g in model.block_gaps),
            depot_ways=tuple((way.aisle, way.distance) for way in model.depot.ways),
            depot_offset=model.depot.offset,
        )
    if isinstance(model, FloorModel):
        return OpenFloor(model.depot.x, model.depot.y, model.metric, model.rounding)
    positions = None if model.positions is None else tuple((x, y) for x, y in model.positions)
    return DistanceTable(model.matrix, model.depot_node, positions)


def _item(model: ItemModel) -> Item:
    fields = dict(model)
    return Item(place=_place(fields.pop("at")), **fields)


def _stock(model: StockModel) -> Stock:
    fields = dict(model)
    return Stock(place=_place(fields.pop("at")), **fields)


def _place(model: SlotModel | PointModel | NodeModel | PoseModel) -> Place:
    if isinstance(model, SlotModel):
        return Slot(model.aisle, model.slot, model.block, model.side)
    if isinstance(model, PointModel):
        return Point(model.x, model.y)
    return Pose(model.pose) if isinstance(model, PoseModel) else Node(model.node)


def read_native(path: Path, options: ReadOptions) -> Instance:
    """Return the instance of a native JSON file."""
    return parse_native(read_text(path), path.parent, pool=options.pool)


FORMAT = builtin(__name__, read_native, write=to_text)
