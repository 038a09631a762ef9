"""A plan on an open floor, a map or lanes, or over a table of distances: points and ways."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

from matplotlib.collections import LineCollection
from matplotlib.transforms import Affine2D

from qrobot._numbers import number
from qrobot._text import shown
from qrobot.problem import DistanceTable, FloorMap, LaneNetwork, OpenFloor, Warehouse
from qrobot.report.canvas import Canvas
from qrobot.report.labels import POINTS, placed, spread, text_width
from qrobot.report.lanes import XY, Lanes, Track
from qrobot.report.map_shapes import beside, extent, is_drawn, shades
from qrobot.report.maps import Look, Map
from qrobot.report.palette import GREY
from qrobot.report.scene import Journey, Scene

__all__ = ["draw_floor"]

MOST_NAMES = 25
"""Larger floors show no names of items."""


def draw_floor(scene: Scene) -> Any:
    """Return the figure of a plan where places are points."""
    house = scene.instance.warehouse
    spots = [house.position(item.place) for item in scene.instance.items]
    ends = [house.depot]
    if isinstance(house, FloorMap | LaneNetwork):
        left, bottom, right, top = extent(house)
        ends += [(left, bottom), (right, top)]
    xs, ys = zip(*spots, *ends, strict=True)
    low, high = (min(xs), min(ys)), (max(xs), max(ys))
    span = max(high[0] - low[0], high[1] - low[1]) or 1.0
    # A line of points still gets a sheet that looks like a floor.
    thin = [max(0.0, 0.3 * span - (high[k] - low[k])) / 2 for k in (0, 1)]
    pad = (0.02 if isinstance(house, FloorMap) else 0.075) * span
    named = scene.instance.size <= MOST_NAMES
    canvas = Canvas(
        scene,
        (low[0] - thin[0] - pad, low[1] - thin[1] - pad),
        (high[0] + thin[0] + pad, high[1] + thin[1] + pad),
        [("small text: item (weight)", "", "")] if named and spots else [],
        frame=0.0 if isinstance(house, DistanceTable) else 0.22,
    )
    _draw_all(canvas.main, scene, spots, named)
    for journey, own in canvas.panels:
        _draw_alone(own, scene, journey, spots)
    return canvas.finish()


def _draw_all(drawn: Map, scene: Scene, spots: Sequence[XY], named: bool) -> None:
    house = scene.instance.warehouse
    _frame(drawn, house)
    _ground(drawn, house)
    size = _marker(drawn, len(set(spots)))
    lines = _ways(drawn, scene, scene.journeys, size, arrow=4.0, most=2.3)
    marks = spread(spots, drawn.metres(0.9 * size))
    _points(drawn, scene, marks, size)
    for journey, line in zip(scene.journeys, lines, strict=True):
        drawn.tag(journey, line)
    # The depot's name comes last in the queue for a free side, but is always drawn.
    texts = [f"{shown(i.label or i.id)} ({number(i.weight)})" for i in scene.instance.items]
    texts = texts if named else []
    sides = placed(
        [_on_sheet(drawn, at) for at in (*(marks if named else ()), house.depot)],
        [*((POINTS * text_width(text, 7.5), 8.0) for text in texts), (36.0, 11.0)],
        size / 2,
        [(_on_sheet(drawn, house.depot), 8.0), *((_on_sheet(drawn, m), size / 2) for m in marks)],
        [[_on_sheet(drawn, corner) for corner in line.corners] for line in lines],
    )
    for text, at, (offset, ha, va) in zip(texts, marks, sides, strict=False):
        label = drawn.axes.annotate(
            text, at, xytext=offset, textcoords="offset points", ha=ha, va=va,
            size=7.5, color=GREY, zorder=5.5,
        )  # fmt: skip
        drawn.labels.add(label)
    (dx, dy), ha, va = sides[-1]
    drawn.depot(house.depot, label=(dx + math.copysign(4, dx) * bool(dx), dy), align=(ha, va))


def _draw_alone(drawn: Map, scene: Scene, journey: Journey, spots: Sequence[XY]) -> None:
    """Draw one trip on a small map, all other items as dots."""
    drawn.axes.set_axis_on()
    drawn.axes.set(xticks=[], yticks=[])
    for side in drawn.axes.spines.values():
        side.set_color("#c3ccd6")
    _ground(drawn, scene.instance.warehouse)
    xs, ys = zip(*spots, strict=True)
    drawn.axes.plot(xs, ys, ls="none", marker="o", ms=1.6, mfc="#c3ccd6", mec="none", zorder=2)
    (line,) = _ways(drawn, scene, [journey], 9.0, arrow=4.0, most=1.3)
    drawn.stops(journey, line.stops)
    drawn.depot(scene.instance.warehouse.depot, size=7)


def _ways(
    drawn: Map, scene: Scene, journeys: Sequence[Journey], size: float, *, arrow: float, most: float
) -> list[Track]:
    width = max(0.9, min(most, size / 6))
    look = Look(line=width, halo=0.5 * width, arrow=max(arrow, 3.4 * width), every=1e9)
    lines = _lines(drawn, scene.instance.warehouse, journeys, look, size)
    for journey, line in zip(journeys, lines, strict=True):
        drawn.way(journey, line, look, bend=drawn.metres(2.5 * width))
    return lines


def _on_sheet(drawn: Map, at: XY) -> XY:
    return drawn.points(at[0]), drawn.points(at[1])


def _frame(drawn: Map, house: Warehouse) -> None:
    """Draw a light grid in metres where coordinates mean something."""
    axes = drawn.axes
    if isinstance(house, DistanceTable):
        return
    axes.set_axis_on()
    axes.set_axisbelow(True)
    axes.grid(color="#e9edf1", lw=0.8)
    axes.tick_params(length=0, labelsize=7.5, labelcolor="#5b6673", pad=3)
    for side in axes.spines.values():
        side.set_color("#c3ccd6")


def _ground(drawn: Map, house: Warehouse) -> None:
    """Draw the cells of a map, or the lanes; gid ``map`` or ``lanes``."""
    axes, gid = drawn.axes, f"{drawn.prefix}{house.kind}"
    if isinstance(house, FloorMap):
        x, y, yaw = house.origin
        wide, high = len(house.rows[0]) * house.resolution, len(house.rows) * house.resolution
        turned = Affine2D().rotate(yaw).translate(x, y) + axes.transData
        axes.imshow(
            shades(house), extent=(0, wide, 0, high), origin="lower", interpolation="nearest",
            aspect="auto", transform=turned, zorder=0.5, gid=gid,
        )  # fmt: skip
    elif isinstance(house, LaneNetwork):
        ends = [[house.vertices[a], house.vertices[b]] for a, b in house.lanes]
        axes.add_collection(LineCollection(ends, colors="#c3ccd6", lw=2.2, zorder=1, gid=gid))
        look = Look(line=1.0, halo=0.0, arrow=5.0, every=1e9)
        one_way = [(house.vertices[a], house.vertices[b]) for a, b in house.one_ways]
        drawn.heads(one_way, look, "#8a95a3")


def _marker(drawn: Map, count: int) -> float:
    """Return the size of the items' marks, points: they should hardly overlap."""
    (left, right), (low, high) = drawn.axes.get_xlim(), drawn.axes.get_ylim()
    area = drawn.points(right - left) * drawn.points(high - low)
    return max(2.4, min(17.0, 0.3 * math.sqrt(area / max(count, 1))))


def _lines(
    drawn: Map, house: Warehouse, journeys: Sequence[Journey], look: Look, size: float
) -> list[Track]:
    legs = [journey.legs for journey in journeys]
    if is_drawn(house):
        return beside(legs, drawn.metres(1.6 * look.line), drawn.metres(12))
    if isinstance(house, OpenFloor) and house.metric == "manhattan":
        room = drawn.metres(30)
        lanes = Lanes(legs, margin=drawn.metres(4))
        return lanes.lines(step=drawn.metres(1.9 * look.line), widths=(room, room))
    ends = Counter(frozenset((leg[0], leg[-1])) for trip in legs for leg in trip)
    least = drawn.metres(2.2 * look.arrow + size)
    found = []
    for trip in legs:
        curves = [
            _curve(leg[0], leg[-1], bow=ends[frozenset((leg[0], leg[-1]))] > 1) for leg in trip
        ]
        heads = [_head(c) for c in curves if math.dist(c[0], c[-1]) > least]
        corners = [trip[0][0], *(point for curve in curves for point in curve[1:])]
        found.append(Track(corners, [leg[-1] for leg in trip[:-1]], heads))
    return found


def _curve(a: XY, b: XY, *, bow: bool) -> list[XY]:
    """Return the points of a leg; one that others share bows to its right."""
    if not bow or a == b:
        return [a, b]
    (dx, dy), points = (b[0] - a[0], b[1] - a[1]), []
    for k in range(17):
        t = k / 16
        off = 0.2 * t * (1 - t)
        points.append((a[0] + dx * t + dy * off, a[1] + dy * t - dx * off))
    return points


def _head(curve: list[XY]) -> tuple[XY, XY]:
    """Return where a leg's arrow stands, a little before the middle, and its direction."""
    (ax, ay), (bx, by) = (curve[len(curve) * 3 // 8 - 1], curve[len(curve) * 3 // 8])
    if len(curve) == 2:
        (ax, ay), (bx, by) = curve
    length = math.dist((ax, ay), (bx, by))
    share = 0.42 if len(curve) == 2 else 0.5
    at = ax + (bx - ax) * share, ay + (by - ay) * share
    return at, ((bx - ax) / length, (by - ay) / length)


def _points(drawn: Map, scene: Scene, places: Sequence[XY], size: float) -> None:
    """Draw the items, coloured by robot and numbered by stop."""
    marks = dict(zip((item.id for item in scene.instance.items), places, strict=True))
    axes = drawn.axes
    shape: dict[str, Any] = {"ls": "none", "marker": "o", "ms": size, "mew": min(1.1, size / 9)}
    for journey in scene.journeys:
        spots = [marks.pop(item.id) for item in journey.items if item.id in marks]
        axes.plot(
            [x for x, _ in spots], [y for _, y in spots], mfc=journey.colour.fill,
            mec=journey.colour.edge, zorder=6, gid=f"trip-{journey.number}-stops", **shape,
        )  # fmt: skip
        for n, (x, y) in enumerate(spots, 1):
            font = min(8.5, (0.62 if n < 100 else 0.45) * size)
            if font >= 3.2:
                drawn.number(journey, (x, y), str(n), font)
    if marks:
        axes.plot(
            [x for x, _ in marks.values()], [y for _, y in marks.values()],
            mfc="#c3ccd6", mec=GREY, zorder=5, gid="not-picked", **shape,
        )  # fmt: skip
