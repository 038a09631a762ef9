"""Networks of lanes: shortest ways against networkx, and the files they come from."""

from __future__ import annotations

import json
import math
from itertools import product
from pathlib import Path
from typing import Any

import networkx as nx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.plan.ruler import Ruler
from qrobot.problem import LaneNetwork, Point, Pose
from qrobot.problem.formats.native import to_text
from qrobot.problem.formats.nav_graphs import read_lanes


@st.composite
def networks(draw: st.DrawFn) -> LaneNetwork:
    """Draw vertices, some of them in one place, and lanes, some of them twice."""
    size = draw(st.integers(1, 8))
    at = st.integers(0, 6).map(float)
    vertex = st.integers(0, size - 1)
    return LaneNetwork(
        vertices=tuple(draw(st.lists(st.tuples(at, at), min_size=size, max_size=size))),
        lanes=tuple(draw(st.lists(st.tuples(vertex, vertex), max_size=20))),
        poses=tuple((f"p{k}", k) for k in range(size)),
        depot_pose="p0",
    )


@settings(max_examples=200, deadline=None)
@given(networks())
def test_distances_are_those_of_dijkstra_along_directed_lanes(network: LaneNetwork) -> None:
    graph = nx.DiGraph()
    graph.add_nodes_from(range(len(network.vertices)))
    for a, b in network.lanes:
        graph.add_edge(a, b, weight=math.dist(network.vertices[a], network.vertices[b]))
    places = [Pose(name) for name, _ in network.poses]
    found = network.distance_matrix(places)
    ruler = Ruler(network)
    for a, b in product(range(len(places)), repeat=2):
        try:
            length = nx.dijkstra_path_length(graph, a, b)
        except nx.NetworkXNoPath:
            length = math.inf
        assert found[a + 1, b + 1] == pytest.approx(length, abs=1e-9)
        assert ruler.leg(places[a], places[b]) == pytest.approx(length, abs=1e-9)
        if math.isfinite(length):
            way = network.way(places[a], places[b])
            assert sum(map(math.dist, way, way[1:])) == pytest.approx(length, abs=1e-9)
            assert (way[0], way[-1]) == (network.vertices[a], network.vertices[b])


def test_a_way_against_a_lane_goes_round() -> None:
    square = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    lanes = ((0, 1), (1, 2), (2, 3), (3, 0))
    network = LaneNetwork(square, lanes, (("dock", 0), ("next", 1)), "dock")
    assert network.distance_matrix([Pose("next")]).tolist() == [[0, 4], [10, 0]]
    assert network.way(Pose("next"), None) == [square[1], square[2], square[3], square[0]]
    assert network.one_ways == list(lanes)


# -- Open-RMF -----------------------------------------------------------------------


def building(vertices: list[Any], lanes: list[Any], **level: Any) -> dict[str, Any]:
    """Return a building map of one level, as the traffic editor saves it."""
    found = {"vertices": vertices, "lanes": lanes, **level}
    return {"name": "site", "coordinate_system": "reference_image", "levels": {"L1": found}}


PIXELS = [
    [100, 300, 0, "dock", {"is_charger": [4, True]}],
    [300, 300, 0, ""],
    [300, 100, 0, "shelf"],
    [900, 900, 0, "a corner of a wall"],
]
BOTH = {"bidirectional": [4, True], "graph_idx": [2, 0]}
ONE = {"bidirectional": [4, False], "graph_idx": [2, 0], "speed_limit": [3, 0.4]}
MEASURED = [[0, 1, {"distance": [3, 4.0]}], [1, 2, {"distance": [3, 6.0]}]]


def saved(folder: Path, data: Any, name: str = "site.building.yaml") -> Path:
    (folder / name).write_text(json.dumps(data))  # JSON is YAML
    return folder / name


def test_a_building_map_has_metres_from_its_measurements(tmp_path: Path) -> None:
    lanes = [[0, 1, BOTH], [1, 2, ONE], [2, 0, ONE], [0, 3, {"graph_idx": [2, 1]}]]
    path = saved(tmp_path, building(PIXELS, lanes, measurements=MEASURED))
    network = read_lanes(path, "", 0, "dock")
    # A pixel is 2.5 cm, the mean of 2 and 3; y is turned upwards.
    assert network.vertices == ((2.5, -7.5), (7.5, -7.5), (7.5, -2.5))
    assert network.poses == (("dock", 0), ("shelf", 2))
    assert sorted(network.lanes) == [(0, 1), (1, 0), (1, 2), (2, 0)]
    assert network.notes() == (
        "site.building.yaml: speed limits of 2 lanes are passed over, robots drive at their own",
    )
    found = network.distance_matrix([Pose("shelf")])
    assert found[0, 1] == pytest.approx(10)
    assert found[1, 0] == pytest.approx(math.hypot(5, 5))


def test_a_map_in_metres_needs_no_measurement(tmp_path: Path) -> None:
    data = building([[0, 0, 0, "dock"], [3, 4, 0, "shelf"]], [[0, 1, BOTH]])
    data["coordinate_system"] = "cartesian_meters"
    network = read_lanes(saved(tmp_path, data), "L1", 0, "dock")
    assert network.distance_matrix([Pose("shelf")])[0, 1] == 5


def test_a_navigation_graph_is_read(tmp_path: Path) -> None:
    level = {
        "vertices": [[0, 0, {"name": "dock"}], [3, 4, {"name": ""}], [3, 9, {"name": "shelf"}]],
        "lanes": [
            [0, 1, {"door_name": "gate"}],
            [1, 0, {"door_name": "gate"}],
            [1, 2, {"is_bidirectional": True, "speed_limit": 0.0}],
        ],
    }
    data = {"building_name": "site", "doors": {}, "levels": {"L1": level}, "lifts": {}}
    network = read_lanes(saved(tmp_path, data, "0.yaml"), "", 0, "dock")
    assert network.distance_matrix([Pose("shelf")]).tolist() == [[0, 10], [10, 0]]
    assert network.notes() == ("0.yaml: doors on 2 lanes are taken to be open",)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"measurements": []}, r"levels.L1.measurements: is empty, so that a pixel has no length"),
        ({"measurements": [[0, 0, {"distance": [3, 1]}]]}, "measurements.0.: measures nothing"),
        ({"vertices": [[1, 2, 0, "dock"], ["x", 1, 0, ""]]}, r'vertices\[1\]\[0\]: "x" is not a n'),
        ({"vertices": None}, "levels.L1.vertices: is not a list"),
        ({"lanes": [[0, 7, BOTH]]}, r"levels.L1.lanes\[0\]: vertex 7 does not exist; use 0 to 3"),
        ({"lanes": [[0, 1.5, BOTH]]}, r"lanes\[0\]\[1\]: 1.5 is not a whole number"),
        ({"lanes": [[0, 1, {"graph_idx": [2, 3]}]]}, "no lanes of graph 0; graphs there: 3"),
        ({"lanes": []}, "no lanes of graph 0; graphs there: none"),
        ({"vertices": [*PIXELS[:2], [1, 1, 0, "dock"]]}, "the name 'dock' is given twice; name"),
    ],
)
def test_faults_of_a_building_map_are_told(
    tmp_path: Path, change: dict[str, Any], problem: str
) -> None:
    lanes = [[0, 1, BOTH], [1, 2, BOTH]]
    data = building(**{"vertices": PIXELS, "lanes": lanes, "measurements": MEASURED, **change})
    with pytest.raises(InputError, match=problem):
        read_lanes(saved(tmp_path, data), "", 0, "dock")


def test_levels_are_chosen_by_name(tmp_path: Path) -> None:
    data = building(PIXELS, [[0, 1, BOTH], [1, 2, BOTH]], measurements=MEASURED)
    data["levels"]["L2"] = {**data["levels"]["L1"], "lanes": [[0, 2, BOTH]]}
    path = saved(tmp_path, data)
    assert read_lanes(path, "L2", 0, "dock").lanes == ((0, 1), (1, 0))
    with pytest.raises(InputError, match=r'levels: has 2 levels; name one as "level" .*: L1, L2'):
        read_lanes(path, "", 0, "dock")
    with pytest.raises(InputError, match="levels: 'L3' is not a level"):
        read_lanes(path, "L3", 0, "dock")
    data["coordinate_system"] = "wgs84"
    with pytest.raises(InputError, match="coordinate_system: 'wgs84' is not a system in metres"):
        read_lanes(saved(tmp_path, data), "L1", 0, "dock")


# -- LIF ----------------------------------------------------------------------------


def layout(name: str = "ground", **more: Any) -> dict[str, Any]:
    """Return a layout of three nodes and a round way, with a station at the last node."""
    spots = {"n1": (0, 0), "n2": (6, 0), "n3": (6, 8)}
    ways = [("n1", "n2"), ("n2", "n3"), ("n3", "n1")]
    return {
        "layoutId": name,
        "nodes": [
            {"nodeId": node, "nodeName": f"name of {node}", "nodePosition": {"x": x, "y": y}}
            for node, (x, y) in spots.items()
        ],
        "edges": [
            {"edgeId": f"e{k}", "startNodeId": a, "endNodeId": b} for k, (a, b) in enumerate(ways)
        ],
        "stations": [{"stationId": "rack", "interactionNodeIds": ["n3"], "stationName": "Rack 7"}],
        **more,
    }


def lif(*layouts: dict[str, Any]) -> dict[str, Any]:
    return {"metaInformation": {"lifVersion": "1.0.0"}, "layouts": list(layouts)}


def test_lif_is_read_and_stations_are_poses(tmp_path: Path) -> None:
    path = saved(tmp_path, lif(layout()), "site.json")
    network = read_lanes(path, "", 0, "n1")
    assert dict(network.poses) == {
        "rack": 2, "n1": 0, "n2": 1, "n3": 2, "Rack 7": 2,
        "name of n1": 0, "name of n2": 1, "name of n3": 2,
    }  # fmt: skip
    assert network.distance_matrix([Pose("rack"), Pose("n2")]).tolist() == [
        [0, 14, 6], [10, 0, 16], [18, 8, 0],
    ]  # fmt: skip
    assert network.notes() == ()


def test_version_2_has_layouts_in_origins(tmp_path: Path) -> None:
    data = {"metaInformation": {}, "origins": [{"originId": "o", "layouts": [layout("a")]}]}
    network = read_lanes(saved(tmp_path, data, "site.json"), "a", 0, "n1")
    assert len(network.lanes) == 3


def test_what_lif_says_beside_the_ways_is_told(tmp_path: Path) -> None:
    edges = layout()["edges"]
    curve = {"degree": 2, "controlPoints": [{"x": 0, "y": 0}, {"x": 3, "y": 1}, {"x": 6, "y": 0}]}
    edges[0]["vehicleTypeEdgeProperties"] = [
        {"vehicleTypeId": "cart", "maxSpeed": 0.3, "trajectory": curve},
        {"vehicleTypeId": "lift", "loadRestriction": {"unloaded": True, "loaded": False}},
    ]
    edges.append({"edgeId": "up", "startNodeId": "n1", "endNodeId": "n9"})
    upper = layout("upper", nodes=[{"nodeId": "n9", "nodePosition": {"x": 0, "y": 0}}])
    path = saved(tmp_path, lif(layout(edges=edges), upper), "site.json")
    assert read_lanes(path, "ground", 0, "n1").notes() == tuple(
        f"site.json: {text}"
        for text in (
            "speed limits of 1 lane are passed over, robots drive at their own",
            "curves of 1 edge are taken as straight lines",
            "edges are for 2 types of vehicles, all robots may take each of them",
            "ways to other layouts are passed over (1 edge)",
            "load restrictions of 1 edge are passed over",
        )
    )


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (
            {"nodes": [{"nodeId": "n1"}]},
            r"layouts\[0\].nodes\[0\].nodePosition: is null, not a map",
        ),
        ({"nodes": [{"nodePosition": {"x": 1, "y": 2}}]}, r"nodes\[0\].nodeId: is missing"),
        ({"nodes": layout()["nodes"] * 2}, r"nodes\[3\]: the node 'n1' is given twice"),
        ({"edges": [{"startNodeId": "n1", "endNodeId": "n7"}]}, "the node 'n7' does not exist; ad"),
        ({"edges": [{"endNodeId": "n1"}]}, r"edges\[0\].startNodeId: is missing"),
        ({"edges": None}, "edges: is not a list"),
        ({"stations": [{"stationId": "s", "interactionNodeIds": []}]}, "is not a list of at least"),
        ({"stations": [{"stationId": "s", "interactionNodeIds": ["n8"]}]}, "'n8' does not exist"),
    ],
)
def test_faults_of_lif_are_told(tmp_path: Path, change: dict[str, Any], problem: str) -> None:
    path = saved(tmp_path, lif(layout(**change)), "site.json")
    with pytest.raises(InputError, match=problem):
        read_lanes(path, "", 0, "n1")


def test_layouts_are_chosen_by_id_level_or_name(tmp_path: Path) -> None:
    other = layout("x", layoutLevelId="2", layoutName="upstairs", edges=[])
    path = saved(tmp_path, lif(layout(), other), "site.json")
    assert len(read_lanes(path, "ground", 0, "n1").lanes) == 3
    for name in ("x", "2", "upstairs"):
        with pytest.raises(InputError, match="'n1' is not a pose"):  # no lane leads there
            read_lanes(path, name, 0, "n1")
    with pytest.raises(InputError, match=r"has 2 layouts; name one as .*: ground, x"):
        read_lanes(path, "", 0, "n1")


# -- in native JSON -----------------------------------------------------------------


def question(folder: Path, **warehouse: Any) -> Path:
    saved(folder, building(PIXELS, [[0, 1, BOTH], [1, 2, ONE], [2, 0, ONE]], measurements=MEASURED))
    house = {"kind": "lanes", "file": "site.building.yaml", "depot": "dock", **warehouse}
    data = {
        "schema": "qrobot.instance/1",
        "warehouse": {key: value for key, value in house.items() if value is not None},
        "robots": {"count": 1, "capacity": 5},
        "items": [{"id": "a", "weight": 1, "at": {"pose": "shelf"}}],
    }
    (folder / "wave.json").write_text(json.dumps(data))
    return folder / "wave.json"


def test_a_question_on_lanes_is_planned_checked_and_written_complete(tmp_path: Path) -> None:
    instance = qrobot.read(question(tmp_path))
    result = qrobot.solve(instance, backend="exact")
    assert result.plan.distance == pytest.approx(10 + math.hypot(5, 5))
    assert any("speed limits" in note for note in result.notes)
    assert qrobot.check(result.plan, instance).ok
    qrobot.write(instance, tmp_path / "again.json")
    (tmp_path / "site.building.yaml").unlink()
    again = qrobot.read(tmp_path / "again.json")
    assert again == instance
    assert to_text(again) == (tmp_path / "again.json").read_text()


@pytest.mark.parametrize(
    ("warehouse", "problem"),
    [
        ({"depot": "dok"}, "wave.json: warehouse.depot, .*'dok' is not a pose of .*; did you mean"),
        ({"file": "x.dxf"}, r"x.dxf: is no network of lanes; give a \.building\.yaml"),
        ({"file": None}, "warehouse.file, .*has neither file nor vertices"),
        ({"graph": 2}, "site.building.yaml: levels.L1.lanes: no lanes of graph 2; graphs there: 0"),
        ({"level": "L7"}, "site.building.yaml: levels: 'L7' is not a level"),
    ],
)
def test_faults_of_the_document_are_told(
    tmp_path: Path, warehouse: dict[str, Any], problem: str
) -> None:
    with pytest.raises(InputError, match=problem):
        qrobot.read(question(tmp_path, **warehouse))


def test_an_item_at_no_pose_and_one_that_no_lane_leads_to_are_told(tmp_path: Path) -> None:
    path = question(tmp_path)
    data = json.loads(path.read_text())
    data["items"][0]["at"] = {"pose": "a corner of a wall"}
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=r"items\[0\].at.pose, .*is not a pose of site.building"):
        qrobot.read(path)
    vertices = [[0, 0], [1, 0], [2, 0]]
    data["warehouse"] = {
        "kind": "lanes", "depot": "dock", "vertices": vertices, "lanes": [[0, 1], [1, 0], [0, 2]],
        "poses": {"dock": 0, "a corner of a wall": 2},
    }  # fmt: skip
    path.write_text(json.dumps(data))
    with pytest.raises(
        InputError, match=r"no way leads .* to items a and back; move .*, or add lan"
    ):
        qrobot.read(path)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"lanes": ((0, 2),)}, r"lanes\[0\]: 2 is outside the layout; use 0 to 1"),
        ({"poses": (("dock", 5),)}, "poses.dock: 5 is outside"),
        ({"vertices": ((0.0, math.inf), (1.0, 1.0))}, r"vertices\[0\].y"),
    ],
)
def test_networks_that_make_no_sense_are_refused(change: dict[str, Any], problem: str) -> None:
    good: dict[str, Any] = {
        "vertices": ((0.0, 0.0), (1.0, 1.0)), "lanes": ((0, 1),),
        "poses": (("dock", 0),), "depot_pose": "dock",
    }  # fmt: skip
    with pytest.raises(InputError, match=problem):
        LaneNetwork(**{**good, **change})
    with pytest.raises(InputError, match=r"coordinate .* is not a pose; lanes need the name"):
        LaneNetwork(**good).check(Point(0, 0))
