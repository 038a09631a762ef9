"""Networks of lanes of fleet managers: Open-RMF's building maps and navigation graphs, and LIF."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from qrobot._files import read_text
from qrobot._text import count
from qrobot.errors import InputError
from qrobot.problem import LaneNetwork
from qrobot.problem.formats.jsontext import loads
from qrobot.problem.formats.yamls import listed, mapping, number, read_yaml, whole

__all__ = ["read_lanes"]

XY = tuple[float, float]


def read_lanes(path: Path, level: str, graph: int, depot: str) -> LaneNetwork:
    """Return the lanes of one level of a file.

    Parameters
    ----------
    path
        A building map or a navigation graph of Open-RMF (``.yaml``), or LIF (``.json``, ``.lif``).
    level
        Its name; empty where there is only one.
    graph
        Of the graphs of a building map.
    depot
        The name of the depot.

    Raises
    ------
    InputError
        When a field is missing or wrong, or there is no such level, graph or name.
    """
    if path.suffix.lower() in (".json", ".lif"):
        return _from_lif(mapping(loads(read_text(path)), ""), level, depot, path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return _from_rmf(read_yaml(path), level, graph, depot, path)
    raise InputError(
        "is no network of lanes",
        advice="give a .building.yaml, a navigation graph (.yaml) or LIF (.json, .lif)",
    )


def _chosen(levels: Mapping[str, Any], wanted: str, what: str) -> str:
    """Return the name of the level that is meant."""
    if wanted in levels or (not wanted and len(levels) == 1):
        return wanted or next(iter(levels))
    known = ", ".join(sorted(levels)[:8]) or "none"
    raise InputError(
        f"{wanted!r} is not a {what}" if wanted else f"has {len(levels)} {what}s",
        field="levels",
        advice=f'name one as "level" in the warehouse: {known}',
    )


def _network(
    vertices: Sequence[XY],
    lanes: Sequence[tuple[int, int]],
    poses: Mapping[str, int],
    depot: str,
    path: Path,
    remarks: Sequence[str],
) -> LaneNetwork:
    """Return the network of the vertices that lanes lead to, in their sequence."""
    used = sorted({vertex for lane in lanes for vertex in lane})
    new = {old: k for k, old in enumerate(used)}
    return LaneNetwork(
        vertices=tuple(vertices[v] for v in used),
        lanes=tuple((new[a], new[b]) for a, b in lanes),
        poses=tuple((name, new[v]) for name, v in poses.items() if v in new),
        depot_pose=depot,
        source=path.name,
        remarks=tuple(f"{path.name}: {remark}" for remark in remarks),
    )


# -- Open-RMF -----------------------------------------------------------------------


def _from_rmf(data: dict[str, Any], level: str, graph: int, depot: str, path: Path) -> LaneNetwork:
    levels = mapping(data.get("levels"), "levels")
    name = _chosen(levels, level, "level")
    found, where = mapping(levels[name], f"levels.{name}"), f"levels.{name}"
    rows = listed(found.get("vertices"), f"{where}.vertices")
    is_building = any(isinstance(row, list) and len(row) > 3 for row in rows)
    vertices, poses = [], dict[str, int]()
    for i, row in enumerate(rows):
        at = f"{where}.vertices[{i}]"
        cells = listed(row, at, least=2)
        vertices.append((number(cells[0], f"{at}[0]"), number(cells[1], f"{at}[1]")))
        text = _vertex_name(cells, is_building)
        if poses.setdefault(text, i) != i and text:
            raise InputError(
                f"the name {text!r} is given twice", field=at, advice="name them apart"
            )
    poses.pop("", None)
    if is_building:
        vertices = _in_metres(data, found, vertices, where)
    lanes, remarks = _rmf_lanes(found, where, len(vertices), graph, is_building)
    return _network(vertices, lanes, poses, depot, path, remarks)


def _vertex_name(cells: list[Any], is_building: bool) -> str:
    if is_building:
        return str(cells[3]) if len(cells) > 3 else ""
    params = cells[2] if len(cells) > 2 and isinstance(cells[2], Mapping) else {}
    return str(params.get("name") or "")


def _in_metres(
    data: dict[str, Any], level: dict[str, Any], vertices: list[XY], where: str
) -> list[XY]:
    """Return the vertices of a building map in metres, y upwards."""
    system = str(data.get("coordinate_system", "reference_image"))
    if system == "cartesian_meters":
        return vertices
    if system != "reference_image":
        raise InputError(
            f"{system!r} is not a system in metres",
            field="coordinate_system",
            advice="give the navigation graph that is generated from the building map",
        )
    scales = []
    for i, row in enumerate(listed(level.get("measurements", []), f"{where}.measurements")):
        at = f"{where}.measurements[{i}]"
        first, last, params = _edge(row, at, len(vertices))
        pixels = math.dist(vertices[first], vertices[last])
        metres = number(_value(params, "distance"), f"{at}.distance")
        if pixels <= 0 or metres <= 0:
            raise InputError("measures nothing", field=at, advice="give two points apart")
        scales.append(metres / pixels)
    if not scales:
        raise InputError(
            "is empty, so that a pixel has no length",
            field=f"{where}.measurements",
            advice="measure something in the traffic editor, or give the navigation graph",
        )
    scale = math.fsum(scales) / len(scales)
    return [(x * scale, -y * scale) for x, y in vertices]


def _rmf_lanes(
    level: dict[str, Any], where: str, size: int, graph: int, is_building: bool
) -> tuple[list[tuple[int, int]], list[str]]:
    """Return the directed lanes of a graph, and what was passed over."""
    lanes, told = [], Counter[str]()
    others = Counter[int]()
    for i, row in enumerate(listed(level.get("lanes"), f"{where}.lanes")):
        at = f"{where}.lanes[{i}]"
        first, last, params = _edge(row, at, size)
        if is_building:
            index = whole(_value(params, "graph_idx", 0), f"{at}.graph_idx")
            if index != graph:
                others[index] += 1
                continue
        lanes.append((first, last))
        both = _value(params, "bidirectional" if is_building else "is_bidirectional", False)
        if both is True:
            lanes.append((last, first))
        told["speed"] += number(_value(params, "speed_limit", 0), f"{at}.speed_limit") > 0
        told["door"] += bool(params.get("door_name"))
    if not lanes:
        known = ", ".join(map(str, sorted(others))) or "none"
        raise InputError(
            f"no lanes of graph {graph}", field=f"{where}.lanes", advice=f"graphs there: {known}"
        )
    return lanes, list(_remarks(told))


def _edge(row: Any, at: str, size: int) -> tuple[int, int, dict[str, Any]]:
    """Return both vertices of a lane or a measurement, and its parameters."""
    cells = listed(row, at, least=2)
    first, last = (whole(cell, f"{at}[{k}]") for k, cell in enumerate(cells[:2]))
    for vertex in (first, last):
        if vertex >= size:
            raise InputError(
                f"vertex {vertex} does not exist", field=at, advice=f"use 0 to {size - 1}"
            )
    params = cells[2] if len(cells) > 2 and cells[2] else {}
    return first, last, mapping(params, f"{at}[2]")


def _value(params: Mapping[str, Any], name: str, default: Any = None) -> Any:
    """Return a parameter; building maps write the number of its type before it."""
    value = params.get(name, default)
    return value[1] if isinstance(value, list) and len(value) == 2 else value


def _remarks(told: Mapping[str, int]) -> Iterator[str]:
    if speeds := told["speed"]:
        yield f"speed limits of {count(speeds, 'lane')} are passed over, robots drive at their own"
    if doors := told["door"]:
        yield f"doors on {count(doors, 'lane')} are taken to be open"
    if curves := told["curve"]:
        yield f"curves of {count(curves, 'edge')} are taken as straight lines"
    if bound := told["vehicles"]:
        yield f"edges are for {bound} types of vehicles, all robots may take each of them"
    if away := told["away"]:
        yield f"ways to other layouts are passed over ({count(away, 'edge')})"
    if restricted := told["load"]:
        yield f"load restrictions of {count(restricted, 'edge')} are passed over"


# -- LIF ----------------------------------------------------------------------------


def _from_lif(data: dict[str, Any], level: str, depot: str, path: Path) -> LaneNetwork:
    if "origins" in data:  # version 2 has layouts in them
        origins = listed(data["origins"], "origins")
        layouts = [
            layout
            for i, origin in enumerate(origins)
            for layout in listed(mapping(origin, f"origins[{i}]").get("layouts"), "layouts")
        ]
    else:
        layouts = listed(data.get("layouts"), "layouts")
    layout, where = _layout(layouts, level)
    vertices, known, names = [], dict[str, int](), list[tuple[str, int]]()
    for i, entry in enumerate(listed(layout.get("nodes"), f"{where}.nodes")):
        at = f"{where}.nodes[{i}]"
        node = mapping(entry, at)
        position = mapping(node.get("nodePosition"), f"{at}.nodePosition")
        x, y = (number(position.get(axis), f"{at}.nodePosition.{axis}") for axis in ("x", "y"))
        name = _text(node, "nodeId", at)
        if known.setdefault(name, i) != i:
            raise InputError(
                f"the node {name!r} is given twice", field=at, advice="keep one of them"
            )
        vertices.append((x, y))
        names.append((str(node.get("nodeName") or node.get("nodeDescriptor") or ""), i))
    everywhere = _all_nodes(layouts)
    told, lanes, vehicles = Counter[str](), [], set[str]()
    for i, entry in enumerate(listed(layout.get("edges"), f"{where}.edges")):
        at = f"{where}.edges[{i}]"
        edge = mapping(entry, at)
        first, last = _text(edge, "startNodeId", at), _text(edge, "endNodeId", at)
        if first in known and last not in known and last in everywhere:
            told["away"] += 1
            continue
        for name in (first, last):
            if name not in known:
                raise InputError(
                    f"the node {name!r} does not exist", field=at, advice="add it, or its layout"
                )
        lanes.append((known[first], known[last]))
        _tell(edge, told, vehicles)
    told["vehicles"] = len(vehicles) if len(vehicles) > 1 else 0
    poses = _lif_poses(layout, where, known, names)
    return _network(vertices, lanes, poses, depot, path, list(_remarks(told)))


def _layout(layouts: list[Any], level: str) -> tuple[dict[str, Any], str]:
    """Return the layout that is meant, by its id, level or name, and its path."""
    found = [mapping(layout, f"layouts[{i}]") for i, layout in enumerate(layouts)]
    for key in ("layoutId", "layoutLevelId", "layoutName"):
        meant = [i for i, layout in enumerate(found) if level and layout.get(key) == level]
        if len(meant) == 1:
            return found[meant[0]], f"layouts[{meant[0]}]"
    ids = {str(layout.get("layoutId", i)): i for i, layout in enumerate(found)}
    index = ids[_chosen(ids, level, "layout")]
    return found[index], f"layouts[{index}]"


def _all_nodes(layouts: list[Any]) -> set[str]:
    return {
        str(node.get("nodeId"))
        for layout in layouts
        for node in mapping(layout, "layouts").get("nodes") or []
        if isinstance(node, Mapping)
    }


def _text(entry: Mapping[str, Any], key: str, at: str) -> str:
    value = entry.get(key)
    if not isinstance(value, str) or not value:
        raise InputError("is missing", field=f"{at}.{key}", advice="give the id as text")
    return value


def _tell(edge: dict[str, Any], told: Counter[str], vehicles: set[str]) -> None:
    """Note what an edge says that distances do not know."""
    key = "vehicleTypeEdgeProperties"
    rules = edge.get(key) or edge.get("mobileRobotTypeEdgeProperties") or []
    rules = [rule for rule in rules if isinstance(rule, Mapping)]
    told["speed"] += any(rule.get("maxSpeed") or rule.get("maximumSpeed") for rule in rules)
    told["curve"] += any(_bends(rule.get("trajectory")) for rule in rules)
    told["load"] += any(rule.get("loadRestriction") for rule in rules)
    vehicles.update(str(rule["vehicleTypeId"]) for rule in rules if "vehicleTypeId" in rule)


def _bends(trajectory: Any) -> bool:
    """Return whether a trajectory is more than the straight line between two points."""
    points = trajectory.get("controlPoints") if isinstance(trajectory, Mapping) else None
    return isinstance(points, list) and len(points) > 2


def _lif_poses(
    layout: dict[str, Any], where: str, known: Mapping[str, int], names: list[tuple[str, int]]
) -> dict[str, int]:
    """Return all names: those of stations first, then ids of nodes, then names of either.

    A station stands for the first of the nodes at which vehicles serve it.
    """
    poses, later = dict[str, int](), list[tuple[str, int]]()
    for i, entry in enumerate(listed(layout.get("stations") or [], f"{where}.stations")):
        at = f"{where}.stations[{i}]"
        station = mapping(entry, at)
        nodes = listed(station.get("interactionNodeIds"), f"{at}.interactionNodeIds", least=1)
        if (vertex := known.get(str(nodes[0]))) is None:
            raise InputError(
                f"the node {nodes[0]!r} does not exist", field=at, advice="add it, or correct it"
            )
        if poses.setdefault(_text(station, "stationId", at), vertex) != vertex:
            raise InputError("the station is given twice", field=at, advice="keep one of them")
        later.append((str(station.get("stationName") or ""), vertex))
    for name, vertex in [*known.items(), *later, *names]:
        if name:
            poses.setdefault(name, vertex)
    return poses
