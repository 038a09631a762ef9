"""Plans as GeoJSON: what RFC 7946 asks for, and the ways and stops of the plan."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from cli.test_commands import one_sentence
from cli.test_commands import qrobot as command
from scenes import CASES, shared

import qrobot
from qrobot.errors import InputError
from qrobot.plan import Plan
from qrobot.problem import DistanceTable, Instance, Item, Node, OpenFloor, Order, Point, Robot
from qrobot.report import geojson, geojson_text

EXAMPLES = Path(__file__).parents[2] / "examples"

POSITION = {"type": "array", "minItems": 2, "maxItems": 3, "items": {"type": "number"}}


def geometry(kind: str, coordinates: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "object",
        "required": ["type", "coordinates"],
        "properties": {"type": {"const": kind}, "coordinates": coordinates},
        # Section 7.1: a member that defines another kind of object must not be here.
        "not": {"anyOf": [{"required": [n]} for n in ("geometry", "properties", "features")]},
    }


RFC_7946 = {
    "type": "object",
    "required": ["type", "features"],
    "not": {
        "anyOf": [
            {"required": [n]} for n in ("coordinates", "geometries", "geometry", "properties")
        ]
    },
    "properties": {
        "type": {"const": "FeatureCollection"},
        "bbox": {"type": "array", "minItems": 4, "maxItems": 4, "items": {"type": "number"}},
        "features": {
            "type": "array",
            "items": {
                "type": "object",
                "required": ["type", "geometry", "properties"],
                "properties": {
                    "type": {"const": "Feature"},
                    "id": {"type": ["string", "number"]},
                    "properties": {"type": ["object", "null"]},
                    "geometry": {
                        "oneOf": [
                            geometry("Point", POSITION),
                            geometry(
                                "LineString", {"type": "array", "minItems": 2, "items": POSITION}
                            ),
                        ]
                    },
                },
            },
        },
    },
}
"""What sections 1 to 4 and 7 of RFC 7946 say of points and lines, written from its text."""


def valid(data: dict[str, Any]) -> dict[str, Any]:
    jsonschema.Draft202012Validator(RFC_7946).validate(json.loads(json.dumps(data)))
    ids = [feature["id"] for feature in data["features"]]
    assert len(set(ids)) == len(ids)
    return data


def of_kind(data: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [one for one in data["features"] if one["properties"]["kind"] == kind]


@pytest.mark.parametrize("case", ["aisles", "euclid", "manhattan", "many"])
def test_a_line_a_trip_and_a_point_a_stop(case: str) -> None:
    instance, plan = CASES[case], shared(CASES[case])
    data = valid(geojson(plan, instance))
    assert "not longitude and latitude" in data["frame"]
    trips, stops = of_kind(data, "way"), of_kind(data, "stop")
    assert [trip["properties"]["robot"] for trip in trips] == [t.robot for t in plan.trips]
    assert [stop["properties"]["item"] for stop in stops] == [
        s for t in plan.trips for s in t.stops
    ]
    (depot,) = of_kind(data, "depot")
    left, low, right, top = data["bbox"]
    for trip, line in zip(plan.trips, trips, strict=True):
        corners = line["geometry"]["coordinates"]
        assert corners[0] == corners[-1] == depot["geometry"]["coordinates"]
        length = sum(math.dist(a, b) for a, b in pairwise(corners))
        assert length == pytest.approx(trip.distance, abs=1e-3 * len(corners))
        assert line["properties"]["distance"] == trip.distance
        own = [s for s in stops if s["properties"]["trip"] == line["properties"]["trip"]]
        assert [s["properties"]["stop"] for s in own] == list(range(1, len(trip.stops) + 1))
        places = [s["geometry"]["coordinates"] for s in own]
        assert all(place in corners or on_line(place, corners) for place in places)
        assert all(left <= x <= right and low <= y <= top for x, y in corners)


def on_line(at: list[float], corners: list[list[float]]) -> bool:
    return any(
        math.dist(a, at) + math.dist(at, b) <= math.dist(a, b) + 1e-3 for a, b in pairwise(corners)
    )


def test_lines_along_lanes_have_their_length() -> None:
    instance = qrobot.read(EXAMPLES / "maps/on-lanes.json")
    result = qrobot.solve(instance, backend="exact")
    data = valid(geojson(result))
    for trip, line in zip(result.plan.trips, of_kind(data, "way"), strict=True):
        corners = line["geometry"]["coordinates"]
        length = sum(math.dist(a, b) for a, b in pairwise(corners))
        assert length == pytest.approx(trip.distance, abs=1e-2)
    assert {s["properties"]["location"] for s in of_kind(data, "stop")} == {
        item.place.name for item in instance.items
    }


def test_a_trip_that_collects_at_the_depot_is_a_line_all_the_same() -> None:
    instance = Instance(
        OpenFloor(), (Item("a", Fraction(1), Point(0, 0)),), (Order("o", ("a",)),),
        (Robot("R1", Fraction(1)),),
    )  # fmt: skip
    data = valid(geojson(Plan.from_routes(instance, [[1]]), instance))
    (way,) = of_kind(data, "way")
    assert way["geometry"]["coordinates"] == [[0.0, 0.0], [0.0, 0.0]]


def test_a_plan_without_trips_has_its_depot() -> None:
    instance = Instance(OpenFloor(3, 4), (), (), (Robot("R1", Fraction(1)),))
    data = valid(geojson(Plan((), 0.0), instance))
    assert data["bbox"] == [3.0, 4.0, 3.0, 4.0]
    assert len(data["features"]) == 1


def test_nodes_without_positions_have_no_place_on_a_map() -> None:
    table = DistanceTable(((0.0, 1.0), (1.0, 0.0)))
    instance = Instance(
        table,
        (Item("a", Fraction(1), Node(1)),),
        (Order("o", ("a",)),),
        (Robot("R1", Fraction(1)),),
    )
    with pytest.raises(
        InputError, match=r"warehouse.positions: the nodes have no coordinates; give"
    ):
        geojson(Plan.from_routes(instance, [[1]]), instance)


def test_the_text_is_what_the_data_say() -> None:
    instance, plan = CASES["aisles"], shared(CASES["aisles"])
    assert json.loads(geojson_text(plan, instance)) == geojson(plan, instance)


def test_the_command_writes_a_file_or_prints(tmp_path: Path) -> None:
    question, plan, output = EXAMPLES / "maps/on-map.json", tmp_path / "p.json", tmp_path / "w.json"
    assert command("solve", question, "-o", plan).returncode == 0
    done = command("ways", plan, question, "-o", output)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"written: {output}\n", "")
    printed = command("ways", plan, question)
    data = valid(json.loads(printed.stdout))
    assert data == json.loads(output.read_text())
    assert data["schema"] == "qrobot.geojson/1"
    done = command("ways", plan, EXAMPLES / "maps/on-lanes.json")
    assert done.returncode == 2
    assert "the plan is not right for this instance" in one_sentence(done)
    done = command("ways", plan, question, "-o", question)
    assert "is an input" in one_sentence(done)
