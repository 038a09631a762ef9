"""A network of lanes, as fleet managers have it: ways lead from vertex to vertex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from qrobot._arrays import Floats
from qrobot._parameters import near
from qrobot.errors import InputError
from qrobot.problem.checks import canonical, check_coordinate, check_index
from qrobot.problem.shortest_ways import Network
from qrobot.problem.warehouse import Place, Pose

__all__ = ["LaneNetwork", "poses_by_name", "unknown_pose"]


@dataclass(frozen=True)
class LaneNetwork:
    """Vertices and the directed lanes between them; distances are shortest ways along lanes.

    Parameters
    ----------
    vertices
        Coordinates, metres.
    lanes
        The vertices that each leads from and to, counted from 0. A lane for both directions is
        two of these. A lane is straight, and as long as its vertices are apart.
    poses
        Names and the vertices that they stand for.
    depot_pose
        The name of the depot.
    source
        The file it came from, for errors.
    remarks
        What the reader of the file passed over, one sentence each.

    Raises
    ------
    InputError
        When a lane or a name leads to a vertex that there is not, or no name is the depot's.
    """

    vertices: tuple[tuple[float, float], ...]
    lanes: tuple[tuple[int, int], ...]
    poses: tuple[tuple[str, int], ...]
    depot_pose: str
    source: str = field(default="", compare=False)
    remarks: tuple[str, ...] = field(default=(), compare=False)
    kind: Literal["lanes"] = "lanes"

    is_metric: ClassVar = True
    has_given_distances: ClassVar = False
    unit: ClassVar = "m"
    way_out: ClassVar = "add lanes there and back"

    def __post_init__(self) -> None:
        """Check that names and lanes lead to vertices."""
        object.__setattr__(self, "depot_pose", canonical(self.depot_pose))
        object.__setattr__(self, "poses", poses_by_name(self.poses))
        for i, (x, y) in enumerate(self.vertices):
            check_coordinate(x, f"vertices[{i}].x")
            check_coordinate(y, f"vertices[{i}].y")
        for i, lane in enumerate(self.lanes):
            for vertex in lane:
                check_index(vertex, f"lanes[{i}]", count=len(self.vertices))
        for name, vertex in self.poses:
            check_index(vertex, f"poses.{name}", count=len(self.vertices))
        if self.depot_pose not in self._vertex_of:
            raise unknown_pose(self.depot_pose, self._vertex_of, self.source).at("depot")

    def __repr__(self) -> str:
        return f"<LaneNetwork of {len(self.vertices)} vertices, depot {self.depot_pose!r}>"

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is derived: helpers derive it again."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @cached_property
    def _vertex_of(self) -> dict[str, int]:
        return dict(self.poses)

    @cached_property
    def _network(self) -> Network:
        xy = np.array(self.vertices, dtype=np.float64).reshape(-1, 2)
        # A lane from a vertex to itself leads nowhere.
        lanes = [(a, b) for a, b in self.lanes if a != b]
        tails, heads = np.array(lanes, dtype=np.int32).reshape(-1, 2).T
        # The graph takes a length of 0 for no lane at all.
        lengths = np.maximum(np.hypot(*(xy[heads] - xy[tails]).T), 1e-12)
        return Network(len(xy), tails, heads, lengths, "a network of lanes")

    @property
    def depot(self) -> tuple[float, float]:
        """Where the depot is drawn, metres."""
        return self.vertices[self._vertex_of[self.depot_pose]]

    def check(self, place: Place) -> None:
        """Raise `InputError` when a place is not a known name."""
        if not isinstance(place, Pose):
            raise InputError(f"{place} is not a pose", advice="lanes need the name of a pose")
        if place.name not in self._vertex_of:
            raise unknown_pose(place.name, self._vertex_of, self.source)

    def vertex(self, place: Place | None) -> int:
        """Return the vertex of a place; ``None`` stands for the depot."""
        assert place is None or isinstance(place, Pose)
        return self._vertex_of[self.depot_pose if place is None else place.name]

    def position(self, place: Place) -> tuple[float, float]:
        """Return the coordinates of a place, metres."""
        return self.vertices[self.vertex(place)]

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return the lengths of shortest ways between depot (row 0) and places, metres."""
        found = self._network.between([self.vertex(place) for place in (None, *places)])
        found[found < 1e-9] = 0.0
        return found

    def way(self, start: Place | None, end: Place | None) -> list[tuple[float, float]]:
        """Return the vertices of a shortest way; ``None`` stands for the depot."""
        first, last = self.vertex(start), self.vertex(end)
        nodes = self._network.way(first, last) or [first, last]
        return [self.vertices[node] for node in nodes]

    def notes(self, *_of: object) -> tuple[str, ...]:
        """Return what the file says that distances do not know."""
        return self.remarks

    @property
    def one_ways(self) -> list[tuple[int, int]]:
        """The lanes that have none back."""
        known = set(self.lanes)
        return [(a, b) for a, b in self.lanes if (b, a) not in known]

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x and y and largest x and y of the lanes, metres."""
        ends = {v for lane in self.lanes for v in lane} or {self.vertex(None)}
        xs, ys = zip(*(self.vertices[v] for v in ends), strict=True)
        return min(xs), min(ys), max(xs), max(ys)


def unknown_pose(name: str, known: Sequence[str] | dict[str, Any], source: str) -> InputError:
    """Return the error that says which poses there are."""
    names = list(known)
    advice = near(name, names)
    if not advice:
        listed = ", ".join(sorted(names)[:8]) + (", .." if len(names) > 8 else "")
        advice = f"known are {listed}" if names else "add it to the poses of the map"
    of = f" of {source}" if source else ""
    return InputError(f"{name!r} is not a pose{of}", field="pose", advice=advice)


def poses_by_name(poses: Sequence[tuple[str, Any]]) -> tuple[tuple[str, Any], ...]:
    """Return named places with the names' composed form.

    Raises
    ------
    InputError
        When a name stands for two places.
    """
    found: dict[str, Any] = {}
    for name, where in poses:
        if canonical(name) in found:
            raise InputError(
                f"the pose {name!r} is given twice", field="poses", advice="keep one of them"
            )
        found[canonical(name)] = where
    return tuple(found.items())
