"""The shape of native JSON, schema ``qrobot.instance/1``, as pydantic models.

The models say what is text, a number, a list or an object, and give the published JSON
Schema. What only the whole can tell (an aisle outside the layout, an item in two orders)
is checked by the domain classes, however an instance was made.
"""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from qrobot._json import json_text
from qrobot.problem.formats.fields import (
    Capacity,
    Count,
    Index,
    Length,
    Matrix,
    Name,
    Number,
    Positive,
    Trips,
    Volume,
    Weight,
    quoted,
    refuse,
)

__all__ = [
    "KINDS",
    "SCHEMA",
    "AislesModel",
    "Document",
    "FleetModel",
    "FloorModel",
    "ItemModel",
    "LanesModel",
    "MapModel",
    "NodeModel",
    "PointModel",
    "PoseModel",
    "SlotModel",
    "StockModel",
    "json_schema",
]

SCHEMA = "qrobot.instance/1"

KINDS = ("aisles", "floor", "matrix", "map", "lanes")
"""Of warehouses."""


class _Strict(BaseModel):
    """Nothing is converted, nothing unknown is passed over."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _name_unknown_fields(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        known = [field.alias or name for name, field in cls.model_fields.items()]
        for key in data:
            if key not in known:
                close = difflib.get_close_matches(key, known, n=1)
                advice = f"did you mean {close[0]!r}?" if close else f"known are {', '.join(known)}"
                raise refuse(
                    "is not a known field",
                    advice,
                    at=f".{key if key.isprintable() else quoted(key):.60}",
                )
        return data


class SlotModel(_Strict):
    """A slot of an aisle warehouse; all numbers count from 0."""

    aisle: Index
    slot: Index
    block: Index = 0
    side: Literal["left", "right"] = "left"


class PointModel(_Strict):
    """A coordinate, metres."""

    x: Number
    y: Number


class NodeModel(_Strict):
    """A row of the distance matrix, from 0."""

    node: Index


class PoseModel(_Strict):
    """A place that a map has a name for."""

    pose: Name


class DepotWayModel(_Strict):
    """A straight way from the depot to another crossing of its cross aisle, metres."""

    aisle: Index
    distance: Length


class DepotModel(_Strict):
    """The crossing that the depot stands at, or left of it, and the way there, metres."""

    aisle: Index = 0
    cross_aisle: Index = 0
    distance: Length = 0.0
    ways: list[DepotWayModel] = []
    offset: Length = 0.0


class SubAisleModel(_Strict):
    """The part of an aisle inside one block."""

    aisle: Index
    block: Index = 0


class CrossingModel(_Strict):
    """The part of a cross aisle between an aisle and its right neighbour."""

    cross_aisle: Index
    aisle: Index


class OneWayAisleModel(SubAisleModel):
    """A sub-aisle that pickers walk towards its front or its back only."""

    towards: Literal["front", "back"]


class OneWayCrossingModel(CrossingModel):
    """A part of a cross aisle that pickers walk to the left or to the right only."""

    towards: Literal["left", "right"]


class GapsModel(_Strict):
    """From the middles of a block's two cross aisles to the nearest slots, metres."""

    front: Length
    back: Length


class AislesModel(_Strict):
    """Parallel aisles in blocks; distances are shortest ways along the aisles."""

    kind: Literal["aisles"]
    aisles: Count
    slots: Count
    blocks: Count = 1
    aisle_pitch: Positive = 3.0
    slot_pitch: Positive = 1.0
    end_gap: Length = 1.0
    depot: DepotModel = DepotModel()
    closed_aisles: list[SubAisleModel] = []
    closed_crossings: list[CrossingModel] = []
    one_way_aisles: list[OneWayAisleModel] = []
    one_way_crossings: list[OneWayCrossingModel] = []
    block_gaps: list[GapsModel] = []


class FloorModel(_Strict):
    """A floor without aisles; distances are the metric's."""

    kind: Literal["floor"]
    metric: Literal["euclidean", "manhattan"] = "euclidean"
    rounding: Literal["none", "nearest"] = "none"
    depot: PointModel = PointModel(x=0.0, y=0.0)


class TableModel(_Strict):
    """A distance matrix, row by row; null where no way leads."""

    kind: Literal["matrix"]
    matrix: Matrix
    depot_node: Index = 0
    positions: list[Annotated[list[Number], Field(min_length=2, max_length=2)]] | None = None


XY = Annotated[list[Number], Field(min_length=2, max_length=2)]


def _named_or(other: str) -> Discriminator:
    """Return what tells a name from an object."""
    return Discriminator(lambda value: "<name>" if isinstance(value, str) else other)


class MapModel(_Strict):
    """An occupancy map, of a file or of its cells; distances are shortest ways over free cells."""

    kind: Literal["map"]
    file: Name = ""
    depot: Annotated[
        Annotated[Name, Tag("<name>")] | Annotated[PointModel, Tag("<point>")],
        _named_or("<point>"),
    ]
    poses: Annotated[
        Annotated[Name, Tag("<name>")] | Annotated[dict[Name, XY], Tag("<each>")],
        _named_or("<each>"),
    ] = {}
    radius: Length = 0.0
    cell: Positive = 0.0
    cells: list[str] = []
    resolution: Positive = 1.0
    origin: Annotated[list[Number], Field(min_length=3, max_length=3)] = [0.0, 0.0, 0.0]


class LanesModel(_Strict):
    """A network of lanes, of a file or of its vertices; distances are shortest ways along lanes."""

    kind: Literal["lanes"]
    file: Name = ""
    level: Name = ""
    graph: Index = 0
    depot: Name
    vertices: list[XY] = []
    lanes: list[Annotated[list[Index], Field(min_length=2, max_length=2)]] = []
    poses: dict[Name, Index] = {}


class OrderModel(_Strict):
    """Items that stay together on one trip."""

    id: Name
    items: Annotated[list[Name], Field(min_length=1)]
    release: Length = 0.0
    due: Length | None = None
    deadline: Length | None = None
    priority: Length = 1.0


class TimesModel(_Strict):
    """Seconds beside driving, the same for all robots."""

    per_trip: Length = 0.0
    per_pick: Length = 0.0
    per_piece: Length = 0.0
    per_level: Length = 0.0


class _Drive(_Strict):
    capacity: Capacity
    speed: Positive = 1.0
    trips: Trips = 1
    available: Length = 0.0


class FleetModel(_Drive):
    """Robots R1 to RK, all alike."""

    count: Count


class RobotModel(_Drive):
    """One robot."""

    id: Name


def _by_keys(**tags: str) -> Callable[[Any], str | None]:
    """Return a function that tells an object's kind by a key that only this kind has."""

    def kind(value: Any) -> str | None:
        found = value if isinstance(value, dict) else {}
        return next((f"<{tag}>" for key, tag in tags.items() if key in found), None)

    return kind


def _warehouse_kind(value: Any) -> str | None:
    kind = value.get("kind") if isinstance(value, dict) else None
    return f"<{kind}>" if kind in KINDS else None


def _robots_kind(value: Any) -> str | None:
    return "<each>" if isinstance(value, list) else "<fleet>" if isinstance(value, dict) else None


PlaceModel = Annotated[
    Annotated[SlotModel, Tag("<slot>")]
    | Annotated[PointModel, Tag("<point>")]
    | Annotated[NodeModel, Tag("<node>")]
    | Annotated[PoseModel, Tag("<pose>")],
    Discriminator(
        _by_keys(aisle="slot", slot="slot", x="point", y="point", node="node", pose="pose"),
        custom_error_type="place",
        custom_error_message="place",
    ),
]
WarehouseModel = Annotated[
    Annotated[AislesModel, Tag("<aisles>")]
    | Annotated[FloorModel, Tag("<floor>")]
    | Annotated[TableModel, Tag("<matrix>")]
    | Annotated[MapModel, Tag("<map>")]
    | Annotated[LanesModel, Tag("<lanes>")],
    Discriminator(_warehouse_kind, custom_error_type="kind", custom_error_message="kind"),
]
RobotsModel = Annotated[
    Annotated[FleetModel, Tag("<fleet>")]
    | Annotated[Annotated[list[RobotModel], Field(min_length=1)], Tag("<each>")],
    Discriminator(_robots_kind, custom_error_type="robots", custom_error_message="robots"),
]


class ItemModel(_Strict):
    """One thing to collect, from one place."""

    id: Name
    weight: Weight
    at: PlaceModel
    pick_seconds: Length = 0.0
    quantity: Count = 1
    article: Name = ""
    level: Index = 0
    label: Name = ""
    volume: Volume = Field(default_factory=Fraction)
    category: Name = ""


class StockModel(_Strict):
    """Pieces of an article in one place."""

    article: Name
    at: PlaceModel
    quantity: Count
    level: Index = 0
    label: Name = ""


class Document(_Strict):
    """A warehouse, what to collect from it, and who collects.

    Without items and orders it is a layout, for orders from CSV. Without orders every item
    is an order of its own.
    """

    schema_: Annotated[Literal["qrobot.instance/1"], Field(alias="schema")]
    editor_schema: Annotated[str, Field(alias="$schema")] = ""
    name: Name = "instance"
    comment: str = ""
    reference: Length | None = None
    warehouse: WarehouseModel
    robots: RobotsModel
    items: list[ItemModel] = []
    orders: list[OrderModel] = []
    stock: list[StockModel] = []
    times: TimesModel = TimesModel()


def json_schema() -> Mapping[str, Any]:
    """Return the JSON Schema (2020-12) that is published beside the package's code."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:qrobot:instance:1",
        **Document.model_json_schema(by_alias=True),
        "title": "qRobot instance, version 1",
    }


if __name__ == "__main__":
    sys.stdout.write(json_text(json_schema(), indent=1) + "\n")
