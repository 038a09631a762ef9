"""Maps and lanes in native JSON: read from the files that they name, written whole.

An instance that is written again holds the cells or the lanes themselves, so that it is complete
wherever it is read.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from qrobot.errors import InputError
from qrobot.problem import FloorMap, LaneNetwork, Place, Point, Pose
from qrobot.problem.formats.nav_graphs import read_lanes
from qrobot.problem.formats.ros_map import poses_beside, read_poses, read_ros_map
from qrobot.problem.formats.schema import LanesModel, MapModel

__all__ = ["lanes_of", "map_data", "map_of"]


def map_of(model: MapModel, folder: Path) -> FloorMap:
    """Return the map that a document describes; its files are relative to a folder.

    Raises
    ------
    InputError
        When a file cannot be read, or the depot lies in a wall.
    """
    depot = (
        Pose(model.depot) if isinstance(model.depot, str) else Point(model.depot.x, model.depot.y)
    )
    rows, resolution, source = tuple(model.cells), model.resolution, ""
    origin = (model.origin[0], model.origin[1], model.origin[2])
    poses: Any = model.poses
    remarks: tuple[str, ...] = ()
    _one_of(bool(model.file), bool(model.cells), "cells")
    if model.file:
        path, source = folder / model.file, model.file
        try:
            rows, resolution, origin, remarks = read_ros_map(path)
        except InputError as error:
            raise error.in_file(str(path)) from None
        beside = None if "poses" in model.model_fields_set else poses_beside(path)
        poses = poses if beside is None else beside
    if isinstance(poses, str | Path):
        path = folder / poses if isinstance(poses, str) else poses
        try:
            poses = dict(read_poses(path))
        except InputError as error:
            raise error.in_file(str(path)) from None
    return FloorMap(
        rows=rows,
        resolution=resolution,
        depot_place=depot,
        origin=origin,
        poses=tuple((name, (x, y)) for name, (x, y) in poses.items()),
        radius=model.radius,
        coarse=_coarse(model.cell, resolution),
        source=source,
        remarks=remarks,
    )


def _coarse(cell: float, resolution: float) -> int:
    """Return how many cells of a map in a row are one of planning."""
    times = round(cell / resolution) if cell else 1
    if cell and (times < 1 or abs(times * resolution - cell) > 1e-6 * cell):
        raise InputError(
            f"{cell:g} is not a whole multiple of the map's resolution, {resolution:g}",
            field="cell",
            advice=f"give {max(1, times) * resolution:g}",
        )
    return times


def lanes_of(model: LanesModel, folder: Path) -> LaneNetwork:
    """Return the network that a document describes; its file is relative to a folder.

    Raises
    ------
    InputError
        When the file cannot be read, or has no such level, graph or depot.
    """
    _one_of(bool(model.file), bool(model.vertices), "vertices")
    if not model.file:
        return LaneNetwork(
            vertices=tuple((x, y) for x, y in model.vertices),
            lanes=tuple((a, b) for a, b in model.lanes),
            poses=tuple(model.poses.items()),
            depot_pose=model.depot,
        )
    path = folder / model.file
    try:
        return read_lanes(path, model.level, model.graph, model.depot)
    except InputError as error:
        if error.field == "depot":
            raise error.at("depot") from None
        raise error.in_file(str(path)) from None


def _one_of(file: bool, inline: bool, name: str) -> None:
    if file == inline:
        raise InputError(
            f"has both file and {name}" if file else f"has neither file nor {name}",
            field="file",
            advice="give one of them",
        )


def map_data(warehouse: FloorMap | LaneNetwork) -> dict[str, Any]:
    """Return a map or a network as native JSON has it, with all that its files said."""
    if isinstance(warehouse, LaneNetwork):
        return {
            "kind": "lanes",
            "depot": warehouse.depot_pose,
            "vertices": [list(at) for at in warehouse.vertices],
            "lanes": [list(lane) for lane in warehouse.lanes],
            "poses": dict(warehouse.poses),
        }
    w = warehouse
    return {
        "kind": "map",
        "depot": _depot_data(w.depot_place),
        "radius": w.radius,
        **({"cell": w.cell} if w.coarse > 1 else {}),
        "resolution": w.resolution,
        "origin": list(w.origin),
        "poses": {name: list(at) for name, at in w.poses},
        "cells": list(w.rows),
    }


def _depot_data(place: Place) -> Any:
    if isinstance(place, Pose):
        return place.name
    assert isinstance(place, Point)
    return {"x": place.x, "y": place.y}
