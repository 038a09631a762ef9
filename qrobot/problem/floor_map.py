"""An occupancy map, as robots make and use it: ways lead over its free cells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from qrobot._arrays import Bools, Floats
from qrobot._extras import load
from qrobot.errors import InputError
from qrobot.problem.checks import check_coordinate, check_length
from qrobot.problem.lane_network import poses_by_name, unknown_pose
from qrobot.problem.shortest_ways import Network
from qrobot.problem.warehouse import Place, Point, Pose

__all__ = ["FREE", "MAX_CELLS", "OCCUPIED", "UNKNOWN", "FloorMap", "clear_line"]

FREE, OCCUPIED, UNKNOWN = ".", "#", "?"
"""What a cell is."""

SLOW = 50_000
"""Cells of planning from which the checker needs noticeable time for each way."""

MAX_CELLS = 25_000_000
"""Cells of a map at most: a hall of 250 by 250 metres at 5 cm."""

STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
"""To the neighbours of a cell, row and column: half of them, for the others lead back."""

XY = tuple[float, float]


@dataclass(frozen=True, repr=False)
class FloorMap:
    """A grid of cells that are free, occupied or unknown; distances are shortest ways over it.

    A robot goes from a free cell to each of its eight neighbours, but past no corner of a cell
    that it may not enter. It may enter free cells only, and none whose middle is within its
    radius of the middle of another kind of cell.

    Parameters
    ----------
    rows
        The cells, the row of the largest y first: ``.`` free, ``#`` occupied, ``?`` unknown.
    resolution
        Side of a cell, metres.
    depot_place
        Where the depot is.
    origin
        Where the lower left corner of the map is in its frame: x, y, metres, and yaw, radians,
        counterclockwise.
    poses
        Names and the coordinates that they stand for, metres of the map's frame.
    radius
        Of the robots, metres.
    coarse
        So many cells in a row are one for planning; it is free where all of them are. Fewer
        cells are planned faster and know fewer ways.
    source
        The file it came from, for errors.
    remarks
        What its reader found worth telling, one sentence each.

    Raises
    ------
    InputError
        When the cells are not a rectangle, or a number is out of range.
    """

    rows: tuple[str, ...]
    resolution: float
    depot_place: Pose | Point
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    poses: tuple[tuple[str, XY], ...] = ()
    radius: float = 0.0
    coarse: int = 1
    source: str = field(default="", compare=False)
    remarks: tuple[str, ...] = field(default=(), compare=False)
    kind: Literal["map"] = "map"

    is_metric: ClassVar = True
    has_given_distances: ClassVar = False
    unit: ClassVar = "m"
    way_out: ClassVar = "give a smaller radius or a smaller cell"

    def __post_init__(self) -> None:
        """Check all that can be checked without inflating obstacles."""
        object.__setattr__(self, "poses", poses_by_name(self.poses))
        check_length(self.resolution, "resolution", least=1e-3, most=1e3)
        check_length(self.radius, "radius", most=1e3)
        for value, name in zip(self.origin, ("x", "y", "yaw"), strict=True):
            check_coordinate(value, f"origin.{name}")
        if self.coarse < 1:
            raise InputError("0 cells", field="cell", advice="give at least the resolution")
        width = len(self.rows[0]) if self.rows else 0
        if not width or width * len(self.rows) > MAX_CELLS:
            raise InputError(
                f"{len(self.rows)} rows of {width} cells are not 1 to {MAX_CELLS} cells",
                field="cells",
                advice="cut the map, or save it at a coarser resolution",
            )
        for i, row in enumerate(self.rows):
            if len(row) != width:
                raise InputError(
                    f"has {len(row)} cells where the first row has {width}",
                    field=f"cells[{i}]",
                    advice="make all rows alike",
                )
            if strange := set(row) - {FREE, OCCUPIED, UNKNOWN}:
                raise InputError(
                    f"holds {min(strange)!r}",
                    field=f"cells[{i}]",
                    advice="use . for free, # for occupied and ? for unknown",
                )
        for name, (x, y) in self.poses:
            check_coordinate(x, f"poses.{name}.x")
            check_coordinate(y, f"poses.{name}.y")
        try:
            self.check(self.depot_place)
        except InputError as error:
            raise error.at("depot") from None

    def __repr__(self) -> str:
        return f"<FloorMap of {len(self.rows[0])} x {len(self.rows)} cells of {self.resolution:g}>"

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is derived: helpers derive it again."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    # -- cells -----------------------------------------------------------------------

    @cached_property
    def free(self) -> Bools:
        """Whether each cell is free, the row of the least y first."""
        text = "".join(reversed(self.rows)).encode()
        cells = np.frombuffer(text, dtype=np.uint8).reshape(len(self.rows), -1)
        return np.asarray(cells == ord(FREE))

    @cached_property
    def clear(self) -> Bools:
        """Whether a robot may stand in the middle of each cell."""
        if self.radius <= 0:
            return self.free
        ndimage = load("scipy.ndimage", "a map")
        # Beside the map nothing is known, which is not free.
        padded = np.pad(self.free, 1)
        apart = ndimage.distance_transform_edt(padded)[1:-1, 1:-1] * self.resolution
        return np.asarray(apart > self.radius * (1 + 1e-9))

    @cached_property
    def walkable(self) -> Bools:
        """Whether a robot may stand in each cell of planning: of `coarse` cells in a row."""
        k = self.coarse
        if k == 1:
            return self.clear
        height, width = (-(-n // k) * k for n in self.clear.shape)
        padded = np.zeros((height, width), dtype=bool)
        padded[: self.clear.shape[0], : self.clear.shape[1]] = self.clear
        blocks = padded.reshape(height // k, k, width // k, k)
        return np.asarray(blocks.all(axis=(1, 3)))

    @property
    def is_slow_to_check(self) -> bool:
        """Whether a plan's deadline must leave its check some time: it measures each way anew."""
        return self.walkable.size > SLOW

    @property
    def cell(self) -> float:
        """Side of a cell of planning, metres."""
        return self.resolution * self.coarse

    def cell_of(self, at: XY) -> tuple[int, int]:
        """Return row (from the least y) and column of the map's cell at coordinates."""
        x, y, yaw = self.origin
        dx, dy = at[0] - x, at[1] - y
        along = dx * math.cos(yaw) + dy * math.sin(yaw)
        across = dy * math.cos(yaw) - dx * math.sin(yaw)
        # A pose on the line between two cells is in the further one, whatever is rounded.
        return tuple(math.floor(v / self.resolution + 1e-9) for v in (across, along))  # type: ignore[return-value]

    def on_floor(self, along: float, across: float) -> XY:
        """Return coordinates in the map's frame of a point so many metres from its corner."""
        x, y, yaw = self.origin
        cos, sin = math.cos(yaw), math.sin(yaw)
        return x + along * cos - across * sin, y + along * sin + across * cos

    @property
    def corners(self) -> list[XY]:
        """The four corners of the map, counterclockwise from its origin, metres."""
        wide, high = len(self.rows[0]) * self.resolution, len(self.rows) * self.resolution
        return [self.on_floor(*at) for at in ((0, 0), (wide, 0), (wide, high), (0, high))]

    # -- places ----------------------------------------------------------------------

    @cached_property
    def _known(self) -> dict[str, XY]:
        return dict(self.poses)

    @property
    def depot(self) -> XY:
        """Where the depot is drawn, metres."""
        return self.position(self.depot_place)

    def position(self, place: Place) -> XY:
        """Return the coordinates of a place, metres."""
        if isinstance(place, Pose):
            return self._known[place.name]
        assert isinstance(place, Point)
        return place.x, place.y

    def check(self, place: Place) -> None:
        """Raise `InputError` when a robot cannot stand in a place."""
        if isinstance(place, Pose) and place.name not in self._known:
            raise unknown_pose(place.name, self._known, self.source)
        if not isinstance(place, Pose | Point):
            raise InputError(f"{place} is not on a map", advice="a map needs a pose, or x and y")
        if isinstance(place, Point):
            check_coordinate(place.x, "x")
            check_coordinate(place.y, "y")
        if (problem := self._obstacle(self.position(place))) is None:
            return
        x, y = self.position(place)
        named = f"{place} at ({x:g}, {y:g})" if isinstance(place, Pose) else str(place)
        of = f" of {self.source}" if self.source else ""
        raise InputError(f"{named}{of} {problem[0]}", advice=problem[1])

    def _obstacle(self, at: XY) -> tuple[str, str] | None:
        """Return why a robot cannot stand at a point, and what to do; None where it can."""
        row, column = self.cell_of(at)
        height, width = self.free.shape
        if not (0 <= row < height and 0 <= column < width):
            return "is outside the map", "move it, or correct the origin of the map"
        what = self.rows[-1 - row][column]
        if what == OCCUPIED:
            return "lies in a wall", "move it to a free cell"
        if what == UNKNOWN:
            return "lies where the map knows nothing", "move it to a free cell, or map the place"
        if not self.clear[row, column]:
            return (
                f"is nearer to a wall than the radius of the robots, {self.radius:g}",
                "move it, or give a smaller radius",
            )
        if not self.walkable[row // self.coarse, column // self.coarse]:
            return (
                f"is in a cell of {self.cell:g} that is not free all over",
                "move it, or give a smaller cell",
            )
        return None

    def planning_cell(self, place: Place | None) -> tuple[int, int]:
        """Return row and column of the cell of planning that a place is in; None is the depot."""
        at = self.depot if place is None else self.position(place)
        row, column = self.cell_of(at)
        return row // self.coarse, column // self.coarse

    # -- ways ------------------------------------------------------------------------

    @cached_property
    def _numbers(self) -> Any:
        """The node of each cell of planning, -1 where none is, and the network of nodes."""
        ok = self.walkable
        number = np.full(ok.shape, -1, dtype=np.int32)
        number[ok] = np.arange(np.count_nonzero(ok), dtype=np.int32)
        height, width = ok.shape
        tails, heads, lengths = [], [], []
        for down, right in STEPS:
            here = slice(0, height - down), slice(max(0, -right), width - max(0, right))
            there = slice(down, height), slice(max(0, right), width + min(0, right))
            both = ok[here] & ok[there]
            if down and right:  # past no corner
                both &= ok[here[0], there[1]] & ok[there[0], here[1]]
            tails.append(number[here][both])
            heads.append(number[there][both])
            lengths.append(np.full(len(tails[-1]), math.hypot(down, right)))
        one, other, long = (np.concatenate(part) for part in (tails, heads, lengths))
        network = Network(
            int(number.max(initial=-1)) + 1,
            np.concatenate((one, other)),
            np.concatenate((other, one)),
            np.concatenate((long, long)),
            "a map",
        )
        return number, np.argwhere(ok), network

    def distance_matrix(self, places: Sequence[Place]) -> Floats:
        """Return the lengths of shortest ways between depot (row 0) and places, metres.

        They begin and end in the middles of cells.
        """
        number, _, network = self._numbers
        nodes = [int(number[self.planning_cell(place)]) for place in (None, *places)]
        found = network.between(nodes)
        # Sums of one way and of the same back may differ by a rounding.
        return np.asarray(np.minimum(found, found.T) * self.cell)

    def way(self, start: Place | None, end: Place | None) -> list[XY]:
        """Return the corner points of a way to be drawn; ``None`` stands for the depot.

        It is a shortest way, pulled straight where nothing stands between: so it may be a
        little shorter than its length over cells.
        """
        number, cells, network = self._numbers
        ends = [self.depot if p is None else self.position(p) for p in (start, end)]
        nodes = network.way(*(int(number[self.planning_cell(p)]) for p in (start, end)))
        way = [tuple(cells[node].tolist()) for node in nodes]
        kept = _pulled(way, self.walkable)[1:-1]
        middles = [((column + 0.5) * self.cell, (row + 0.5) * self.cell) for row, column in kept]
        return [ends[0], *(self.on_floor(*at) for at in middles), ends[1]]

    def notes(self, *_of: object) -> tuple[str, ...]:
        """Return what is worth telling of the file."""
        return self.remarks

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x and y and largest x and y of the map, metres."""
        xs, ys = zip(*self.corners, strict=True)
        return min(xs), min(ys), max(xs), max(ys)


def _pulled(way: list[tuple[int, int]], ok: Bools) -> list[tuple[int, int]]:
    """Return the corners of a way over cells, those left out that a straight line passes by."""
    turns = [
        cell
        for k, cell in enumerate(way)
        if k in (0, len(way) - 1)
        or (2 * cell[0], 2 * cell[1])
        != (way[k - 1][0] + way[k + 1][0], way[k - 1][1] + way[k + 1][1])
    ]
    kept = turns[:1]
    for k, cell in enumerate(turns[1:], 1):
        if k == len(turns) - 1 or not clear_line(kept[-1], turns[k + 1], ok):
            kept.append(cell)
    return kept


def clear_line(a: tuple[int, int], b: tuple[int, int], ok: Bools) -> bool:
    """Return whether the straight line between the middles of two cells passes allowed ones only.

    It touches no corner of another one.
    """
    steps = 8 * max(abs(b[0] - a[0]), abs(b[1] - a[1]), 1)
    share = np.linspace(0.0, 1.0, steps + 1)
    line = [a[k] + 0.5 + (b[k] - a[k]) * share for k in (0, 1)]
    low, high = ([np.floor(part + off).astype(np.intp) for part in line] for off in (-1e-6, 1e-6))
    return all(
        bool(ok[rows, columns].all()) for rows in (low[0], high[0]) for columns in (low[1], high[1])
    )
