"""An instance as native JSON text, schema ``qrobot.instance/1``; what is usual is left out."""

from __future__ import annotations

import dataclasses
import decimal
import math
from decimal import Decimal
from fractions import Fraction
from typing import Any

from qrobot.errors import InputError
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    FloorMap,
    Instance,
    Item,
    LaneNetwork,
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
from qrobot.problem.fleets import NO_LIMIT
from qrobot.problem.formats.jsontext import dumps
from qrobot.problem.formats.native_maps import map_data
from qrobot.problem.formats.schema import SCHEMA

__all__ = ["to_text"]


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
            "weight": _decimal(item.weight, f"items[{i}].weight"),
            "at": _place_data(item.place),
            **({"pick_seconds": item.pick_seconds} if item.pick_seconds else {}),
            **({"quantity": item.quantity} if item.quantity > 1 else {}),
            **({"article": item.article} if item.article else {}),
            **_bin_data(item),
            **({"volume": _decimal(item.volume, f"items[{i}].volume")} if item.volume else {}),
            **({"category": item.category} if item.category else {}),
        }
        for i, item in enumerate(instance.items)
    ]
    if instance.orders != tuple(Order(item.id, (item.id,)) for item in instance.items):
        data["orders"] = [_order_data(order) for order in instance.orders]
    if instance.stock:
        data["stock"] = [
            {
                "article": s.article,
                "at": _place_data(s.place),
                "quantity": s.quantity,
                **_bin_data(s),
            }
            for s in instance.stock
        ]
    if instance.times != Times():
        data["times"] = {k: v for k, v in dataclasses.asdict(instance.times).items() if v}
    return dumps(data)


def _bin_data(one: Item | Stock) -> dict[str, Any]:
    return {name: value for name in ("label", "level") if (value := getattr(one, name))}


def _order_data(order: Order) -> dict[str, Any]:
    """Return an order without what is usual."""
    usual = dataclasses.asdict(Order(order.id, order.items))
    own = dataclasses.asdict(order).items()
    return {"id": order.id, "items": list(order.items), **{k: v for k, v in own if v != usual[k]}}


def _decimal(value: Fraction, field: str = "robots") -> Decimal:
    with decimal.localcontext() as context:
        context.prec = 200
        number = Decimal(value.numerator) / Decimal(value.denominator)
        if Fraction(number) != value:
            raise InputError(
                f"{value} has no finite decimal",
                field=field,
                advice="round it before writing",
            )
    return number


def _robots_data(robots: tuple[Robot, ...]) -> Any:
    drives = [
        {
            "capacity": _decimal(r.capacity),
            "speed": r.speed,
            "trips": r.trips if r.trips < NO_LIMIT else "free",
            **({"available": r.available} if r.available else {}),
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
    return {"pose": place.name} if isinstance(place, Pose) else {"node": place.index}


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
    if isinstance(warehouse, FloorMap | LaneNetwork):
        return map_data(warehouse)
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
