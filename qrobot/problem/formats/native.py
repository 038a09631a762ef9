"""Native JSON, schema ``qrobot.instance/1``: read, checked with our own words, and written."""

from __future__ import annotations

import dataclasses
import decimal
import math
import re
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
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
    Robot,
    Slot,
    Stock,
    Times,
    Warehouse,
)
from qrobot.problem.fleets import NO_LIMIT, check_fleet_size
from qrobot.problem.formats.fields import shown
from qrobot.problem.formats.jsontext import dumps, loads, located
from qrobot.problem.formats.registry import ReadOptions, builtin, checked
from qrobot.problem.formats.schema import (
    SCHEMA,
    AislesModel,
    Document,
    FleetModel,
    FloorModel,
    NodeModel,
    PointModel,
    SlotModel,
)
from qrobot.problem.validity import check_robots

__all__ = ["FORMAT", "Layout", "parse_native", "read_layout", "read_native", "to_text"]


_WISHES = {
    "int_type": "a whole number",
    "string_type": "text",
    "string_unicode": "text",
    "string_too_short": "at least 1 letter",
    "string_too_long": "at most 200 letters",
    "string_pattern_mismatch": "text without control characters",
    "list_type": "a list",
    "model_type": "an object",
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


def parse_native(text: str, *, pool: bool = False) -> Instance:
    """Return the instance of native JSON text; a `pool` may be larger than one plan.

    Raises
    ------
    InputError
        When the text is not a document of this schema, or what it asks makes no sense.
    """
    with located(text):
        return _instance(_document(loads(text)), pool)


def _instance(document: Document, pool: bool) -> Instance:
    if "items" not in document.model_fields_set:
        raise InputError(
            "is missing (a document without items is a layout)",
            field="items",
            advice="add the items, or give the orders as CSV with this layout",
        )
    layout = _layout(document)
    items = tuple(
        Item(i.id, i.weight, _place(i.at), i.pick_seconds, i.quantity, i.article, i.level)
        for i in document.items
    )
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
            stock=tuple(Stock(s.article, _place(s.at), s.quantity) for s in document.stock),
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
        return _layout(document)


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
        advice = "give 'aisles', 'floor' or 'matrix'"
    elif kind == "place":
        problem = f"{value} is not a place"
        advice = "give aisle, block and slot; or x and y; or node"
    elif kind == "robots":
        problem, advice = f"{value} is not a fleet", "give count and capacity, or a list of robots"
    else:
        wish = _WISHES.get(kind, first["msg"].removeprefix("Input should be "))
        problem, advice = f"{value} is not right", f"needed: {wish}"
    return InputError(problem, field=path.removeprefix("."), advice=advice)


def _layout(document: Document) -> Layout:
    try:
        warehouse = _warehouse(document)
    except InputError as error:
        raise error.at(f"warehouse.{error.field}") from None
    fleet = document.robots
    if isinstance(fleet, FleetModel):
        check_fleet_size(fleet.count, "robots.count")
        robots = tuple(
            Robot(f"R{k + 1}", fleet.capacity, fleet.speed, fleet.trips) for k in range(fleet.count)
        )
    else:
        robots = tuple(Robot(r.id, r.capacity, r.speed, r.trips) for r in fleet)
    try:
        check_robots(robots)
    except InputError as error:
        if isinstance(fleet, FleetModel) and error.field:
            raise error.at(re.sub(r"^robots\[\d+\]", "robots", error.field)) from None
        raise
    times = Times(**document.times.model_dump())
    return Layout(document.name, document.comment, warehouse, robots, times)


def _warehouse(document: Document) -> Warehouse:
    model = document.warehouse
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


def _place(model: SlotModel | PointModel | NodeModel) -> Place:
    if isinstance(model, SlotModel):
        return Slot(model.aisle, model.slot, model.block, model.side)
    if isinstance(model, PointModel):
        return Point(model.x, model.y)
    return Node(model.node)


# -- writing ------------------------------------------------------------------------


def to_text(instance: Instance) -> str:
    """Return an instance as native JSON text.

    Raises
    ------
    InputError
        When a weight, such as one third, has no finite decimal.
    """
    data: dict[str, Any] = {"schema": SCHEMA, "name": instance.name}
    if instance.comment:
        data["comment"] = instance.comment
    if instance.reference is not None:
        data["reference"] = instance.reference
    data["warehouse"] = _warehouse_data(instance.warehouse)
    data["robots"] = _robots_data(instance.robots)
    data["items"] = [
        {
            "id": item.id,
            "weight": _decimal(item.weight, i),
            "at": _place_data(item.place),
            **({"pick_seconds": item.pick_seconds} if item.pick_seconds else {}),
            **({"quantity": item.quantity} if item.quantity > 1 else {}),
            **({"article": item.article} if item.article else {}),
            **({"level": item.level} if item.level else {}),
        }
        for i, item in enumerate(instance.items)
    ]
    if instance.orders != tuple(Order(item.id, (item.id,)) for item in instance.items):
        data["orders"] = [_order_data(order) for order in instance.orders]
    if instance.stock:
        data["stock"] = [
            {"article": s.article, "at": _place_data(s.place), "quantity": s.quantity}
            for s in instance.stock
        ]
    if instance.times != Times():
        data["times"] = {k: v for k, v in dataclasses.asdict(instance.times).items() if v}
    return dumps(data)


def _order_data(order: Order) -> dict[str, Any]:
    """Return an order without what is usual."""
    usual = dataclasses.asdict(Order(order.id, order.items))
    own = dataclasses.asdict(order).items()
    return {"id": order.id, "items": list(order.items), **{k: v for k, v in own if v != usual[k]}}


def _decimal(value: Fraction, index: int | None = None) -> Decimal:
    with decimal.localcontext() as context:
        context.prec = 200
        number = Decimal(value.numerator) / Decimal(value.denominator)
        if Fraction(number) != value:
            raise InputError(
                f"{value} has no finite decimal",
                field="robots" if index is None else f"items[{index}].weight",
                advice="round it before writing",
            )
    return number


def _robots_data(robots: tuple[Robot, ...]) -> Any:
    drives = [
        {
            "capacity": _decimal(r.capacity),
            "speed": r.speed,
            "trips": r.trips if r.trips < NO_LIMIT else "free",
        }
        for r in robots
    ]
    alike = all(drive == drives[0] for drive in drives)
    if alike and all(r.id == f"R{k + 1}" for k, r in enumerate(robots)):
        return {"count": len(robots), **drives[0]}
    return [{"id": r.id, **drive} for r, drive in zip(robots, drives, strict=True)]


def _place_data(place: Place) -> dict[str, Any]:
    if isinstance(place, Slot):
        return {"aisle": place.aisle, "block": place.block, "slot": place.slot, "side": place.side}
    if isinstance(place, Point):
        return {"x": place.x, "y": place.y}
    return {"node": place.index}


def _warehouse_data(warehouse: Warehouse) -> dict[str, Any]:
    if isinstance(warehouse, AisleWarehouse):
        w = warehouse
        gaps = [{"front": front, "back": back} for front, back in w.block_gaps]
        ways = [{"aisle": aisle, "distance": length} for aisle, length in w.depot_ways]
        along = [{"aisle": a, "block": b, "towards": t} for a, b, t in sorted(w.one_way_aisles)]
        across = [
            {"cross_aisle": c, "aisle": a, "towards": t} for c, a, t in sorted(w.one_way_crossings)
        ]
        return {
            "kind": "aisles",
            "aisles": w.aisles,
            "blocks": w.blocks,
            "slots": w.slots,
            "aisle_pitch": w.aisle_pitch,
            "slot_pitch": w.slot_pitch,
            "end_gap": w.end_gap,
            **({"block_gaps": gaps} if gaps else {}),
            "depot": {
                "aisle": w.depot_aisle,
                "cross_aisle": w.depot_cross_aisle,
                "distance": w.depot_distance,
                **({"ways": ways} if ways else {}),
                **({"offset": w.depot_offset} if w.depot_offset else {}),
            },
            "closed_aisles": [{"aisle": a, "block": b} for a, b in sorted(w.closed_aisles)],
            "closed_crossings": [
                {"cross_aisle": c, "aisle": a} for c, a in sorted(w.closed_crossings)
            ],
            **({"one_way_aisles": along} if along else {}),
            **({"one_way_crossings": across} if across else {}),
        }
    if isinstance(warehouse, OpenFloor):
        return {
            "kind": "floor",
            "metric": warehouse.metric,
            "rounding": warehouse.rounding,
            "depot": {"x": warehouse.depot_x, "y": warehouse.depot_y},
        }
    if not isinstance(warehouse, DistanceTable):
        raise InputError(
            f"{warehouse.kind!r} is not a kind of warehouse that native JSON has",
            field="warehouse",
            advice="use another format",
        )
    rows = [[d if math.isfinite(d) else None for d in row] for row in warehouse.matrix]
    data = {"kind": "matrix", "matrix": rows, "depot_node": warehouse.depot_node}
    if warehouse.positions is not None:
        data["positions"] = [list(xy) for xy in warehouse.positions]
    return data


def read_native(path: Path, options: ReadOptions) -> Instance:
    """Return the instance of a native JSON file."""
    return parse_native(read_text(path), pool=options.pool)


FORMAT = builtin(__name__, read_native, write=to_text)
