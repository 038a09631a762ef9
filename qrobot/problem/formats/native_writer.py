"""An instance as native JSON text, schema ``qrobot.instance/1``."""

from __future__ import annotations

import decimal
import math
from decimal import Decimal
from fractions import Fraction
from typing import Any

from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Instance, OpenFloor, Place, Point, Robot, Slot, Warehouse
from qrobot.problem.formats.jsontext import dumps

__all__ = ["SCHEMA", "to_text"]

SCHEMA = "qrobot.instance/1"


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
        {"id": item.id, "weight": _decimal(item.weight, i), "at": _place_data(item.place)}
        for i, item in enumerate(instance.items)
    ]
    if [o.items for o in instance.orders] != [(item.id,) for item in instance.items] or any(
        order.id != order.items[0] for order in instance.orders
    ):
        data["orders"] = [{"id": o.id, "items": list(o.items)} for o in instance.orders]
    return dumps(data)


def _decimal(value: Fraction, index: int | None = None) -> Decimal:
    with decimal.localcontext() as context:
        context.prec = 200
        number = Decimal(value.numerator) / Decimal(value.denominator)
        if Fraction(number) != value:
            raise InputError(
                f"{value} has no finite decimal",
                field="robots" if index is None else f"items[{index}].weight",
                mend="round it before writing",
            )
    return number


def _robots_data(robots: tuple[Robot, ...]) -> Any:
    drives = [
        {"capacity": _decimal(r.capacity), "speed": r.speed, "trips": r.trips} for r in robots
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
        return {
            "kind": "aisles",
            "aisles": w.aisles,
            "blocks": w.blocks,
            "slots": w.slots,
            "aisle_pitch": w.aisle_pitch,
            "slot_pitch": w.slot_pitch,
            "end_gap": w.end_gap,
            "depot": {
                "aisle": w.depot_aisle,
                "cross_aisle": w.depot_cross_aisle,
                "distance": w.depot_distance,
            },
            "closed_aisles": [{"aisle": a, "block": b} for a, b in sorted(w.closed_aisles)],
            "closed_crossings": [
                {"cross_aisle": c, "aisle": a} for c, a in sorted(w.closed_crossings)
            ],
        }
    if isinstance(warehouse, OpenFloor):
        return {
            "kind": "floor",
            "metric": warehouse.metric,
            "rounding": warehouse.rounding,
            "depot": {"x": warehouse.depot_x, "y": warehouse.depot_y},
        }
    rows = [[d if math.isfinite(d) else None for d in row] for row in warehouse.matrix]
    data = {"kind": "matrix", "matrix": rows, "depot_node": warehouse.depot_node}
    if warehouse.positions is not None:
        data["positions"] = [list(xy) for xy in warehouse.positions]
    return data
