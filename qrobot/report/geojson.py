"""Plans as GeoJSON (RFC 7946), for maps of other programs: a line a trip, a point a stop."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from qrobot._files import StrPath
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.problem import DistanceTable, Instance
from qrobot.problem.formats.jsontext import dumps
from qrobot.report.lanes import XY
from qrobot.report.picklist import location
from qrobot.report.scene import Journey, Scene, checked_scene

if TYPE_CHECKING:
    from qrobot.planning import Result

__all__ = ["GEOJSON_SCHEMA", "geojson", "geojson_text"]

GEOJSON_SCHEMA = "qrobot.geojson/1"

FRAME = "metres of the warehouse's own frame, x and y; not longitude and latitude"


def geojson(
    answer: Result | Plan | StrPath, instance: Instance | StrPath | None = None
) -> dict[str, Any]:
    """Return the ways and the stops of a plan as a GeoJSON feature collection.

    Parameters
    ----------
    answer
        A result, or a plan (or the path of its file) together with its instance.
    instance
        The question; needed for a plan alone.

    Returns
    -------
    dict
        A ``LineString`` a trip and a ``Point`` a stop, and one for the depot. Coordinates are
        metres of the warehouse's frame, as the member ``frame`` says.

    Raises
    ------
    InputError
        When the plan is not right for the instance, as `qrobot.check` says, or the places of
        the warehouse have no coordinates.
    """
    scene = checked_scene(answer, instance)
    house = scene.instance.warehouse
    if isinstance(house, DistanceTable) and house.positions is None:
        raise InputError(
            "the nodes have no coordinates",
            field="warehouse.positions",
            advice="give each node its position",
        )
    features = list(_features(scene))
    points = [
        at
        for feature in features
        for at in (
            feature["geometry"]["coordinates"]
            if feature["geometry"]["type"] == "LineString"
            else [feature["geometry"]["coordinates"]]
        )
    ]
    xs, ys = zip(*points, strict=True)
    return {
        "type": "FeatureCollection",
        "schema": GEOJSON_SCHEMA,
        "instance": scene.instance.name,
        "frame": FRAME,
        "bbox": [min(xs), min(ys), max(xs), max(ys)],
        "features": features,
    }


def geojson_text(
    answer: Result | Plan | StrPath, instance: Instance | StrPath | None = None
) -> str:
    """Return what `geojson` returns as text."""
    return dumps(geojson(answer, instance))


def _features(scene: Scene) -> Iterator[dict[str, Any]]:
    yield _feature("depot", "Point", _xy(scene.instance.warehouse.depot), {"kind": "depot"})
    owner = {item: order.id for order in scene.instance.orders for item in order.items}
    for journey in scene.journeys:
        yield _way(journey)
        for stop, item in enumerate(journey.items, 1):
            at = scene.instance.warehouse.position(item.place)
            about = {
                "kind": "stop",
                "trip": journey.number,
                "robot": journey.trip.robot,
                "stop": stop,
                "item": item.id,
                "article": item.article or item.id,
                "quantity": item.quantity,
                "order": owner[item.id],
                "location": location(scene.instance, item),
            }
            yield _feature(f"trip-{journey.number}-stop-{stop}", "Point", _xy(at), about)


def _way(journey: Journey) -> dict[str, Any]:
    line = [journey.legs[0][0], *(at for leg in journey.legs for at in leg[1:])]
    if len(line) == 1:  # all is collected at the depot, and a line has two positions
        line *= 2
    about = {
        "kind": "way",
        "trip": journey.number,
        "robot": journey.trip.robot,
        "turn": journey.turn + 1,
        "distance": journey.trip.distance,
        "seconds": journey.trip.seconds,
        "load": journey.trip.load,
        "orders": list(journey.trip.orders),
        "colour": journey.colour.fill,
    }
    return _feature(f"trip-{journey.number}", "LineString", [_xy(at) for at in line], about)


def _xy(at: XY) -> list[float]:
    """Return a position, to a tenth of a millimetre."""
    return [round(value, 4) + 0.0 for value in at]


def _feature(id_: str, kind: str, coordinates: Any, about: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "id": id_,
        "geometry": {"type": kind, "coordinates": coordinates},
        "properties": about,
    }
