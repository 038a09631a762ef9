"""A plan on its floor as shapes of an SVG, for pages: no drawing library is needed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from qrobot.problem import AisleWarehouse, FloorMap, LaneNetwork, OpenFloor, Place, Slot
from qrobot.report.lanes import XY, Lanes, Track, rounded
from qrobot.report.map_shapes import beside, extent, is_drawn, walls
from qrobot.report.palette import Colour
from qrobot.report.racks import Box, Racks
from qrobot.report.scene import Journey, Scene

__all__ = ["FloorPlan", "Mark", "Way", "floor_plan"]

EDGE = 26.0
"""Around the floor, for the depot and the names of the aisles; these are units of the drawing."""
LANE = 5.0
"""Between two lanes of one aisle, where it is wide enough."""
BEND = 4.0
ONE_WAY_HEAD = 6.0
"""Of the arrows along one-way parts: smaller than those of the trips."""
LEAST_SLOT = 3.0
"""Smaller slots are not drawn one by one, but each rack as one."""
Sharing = dict[Place, list[int]]
"""The numbers of the trips that pick from a place."""

FONTS = (6.5, 11.0)
"""Of the number on a slot, at least and at most; a smaller one is left out."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A place that something is picked from.

    Parameters
    ----------
    x, y, width, height
        Its box.
    text
        Which stops of the trip; empty where there is no room.
    font
        Size of the text.
    last
        Number of the last stop there.
    """

    x: float
    y: float
    width: float
    height: float
    text: str
    font: float
    last: int


@dataclass(frozen=True, slots=True)
class Way:
    """A trip on the floor.

    Parameters
    ----------
    number
        Of the trip.
    colour
        Of its robot.
    path
        As the attribute ``d`` of a path.
    arrows
        As the attribute ``points`` of a polygon each.
    marks
        Where it picks.
    legs
        Corner points from the depot to the first stop, ..., from the last to the depot.
    """

    number: int
    colour: Colour
    path: str
    arrows: tuple[str, ...]
    marks: tuple[Mark, ...]
    legs: tuple[tuple[XY, ...], ...]


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """What a map shows; all in units of the drawing, y downwards.

    Parameters
    ----------
    width, height
        Of the whole.
    floor
        Outline; None where the warehouse has none.
    racks
        As the attribute ``d`` of one path: racks, or walls of a map.
    lanes
        Lanes of a network: where each begins and leads to.
    closed
        Boxes that nobody can enter.
    one_ways
        Parts that are walked in one direction only: where each begins and leads to.
    heads
        Their arrow heads, as the attribute ``points`` of a polygon each.
    dots
        Places of other items.
    names
        Numbers of the aisles, each with its place.
    depot
        Where it stands.
    ways
        The trips.
    round_marks
        Whether places are points and not slots.
    """

    width: float
    height: float
    floor: Box | None
    racks: str
    lanes: tuple[tuple[XY, XY], ...]
    closed: tuple[Box, ...]
    one_ways: tuple[tuple[XY, XY], ...]
    heads: tuple[str, ...]
    dots: tuple[XY, ...]
    names: tuple[tuple[XY, str], ...]
    depot: XY
    ways: tuple[Way, ...]
    round_marks: bool


def floor_plan(scene: Scene, journeys: Sequence[Journey], size: tuple[float, float]) -> FloorPlan:
    """Return the map of some trips.

    Parameters
    ----------
    scene
        The plan.
    journeys
        The trips that are shown.
    size
        Width and height of the drawing at most; the floor keeps its shape.
    """
    house = scene.instance.warehouse
    racks = Racks(house) if isinstance(house, AisleWarehouse) else None
    frame = _Frame(_extent(scene, racks), size)
    shown = {item.id for journey in journeys for item in journey.items}
    sharing: Sharing = {}
    for journey in journeys:
        for place in dict.fromkeys(item.place for item in journey.items):
            sharing.setdefault(place, []).append(journey.number)
    others = [item.place for item in scene.instance.items if item.id not in shown]
    boxes = [] if racks is None else _rack_boxes(racks, frame)
    ends: Iterable[tuple[XY, XY]] = () if racks is None else racks.one_ways()
    lanes: Iterable[tuple[XY, XY]] = ()
    if isinstance(house, LaneNetwork):
        at = house.vertices
        ends, lanes = ([(at[a], at[b]) for a, b in some] for some in (house.one_ways, house.lanes))
    one_ways = tuple((frame.point(first), frame.point(last)) for first, last in ends)
    outlines = walls(house) if isinstance(house, FloorMap) else ()
    return FloorPlan(
        width=frame.width,
        height=frame.height,
        floor=None if racks is None else frame.box(racks.floor),
        racks="".join(f"M{x:.1f} {y:.1f}h{w:.1f}v{h:.1f}h{-w:.1f}z" for x, y, w, h in boxes)
        + "".join("M" + "L".join(map(frame.text, corners)) + "z" for corners in outlines),
        lanes=tuple((frame.point(first), frame.point(last)) for first, last in lanes),
        closed=() if racks is None else tuple(map(frame.box, racks.closed())),
        one_ways=one_ways,
        heads=tuple(head for part in one_ways for head in _arrows(part, size=ONE_WAY_HEAD)),
        dots=tuple(dict.fromkeys(frame.point(_middle(scene, racks, place)) for place in others)),
        names=() if racks is None else tuple(_names(racks, frame)),
        depot=frame.point(house.depot),
        ways=tuple(
            _way(journey, track, scene, racks, frame, sharing)
            for journey, track in zip(journeys, _tracks(scene, journeys, racks, frame), strict=True)
        ),
        round_marks=racks is None,
    )


class _Frame:
    """From metres of the floor to units of the drawing."""

    def __init__(self, extent: tuple[float, float, float, float], size: tuple[float, float]):
        left, low, right, high = extent
        room = size[0] - 2 * EDGE, size[1] - 2 * EDGE
        spans = (right - left, high - low)
        self.scale = min((r / s for r, s in zip(room, spans, strict=True) if s > 0), default=1.0)
        self._left, self._high = left, high
        # A floor that is a line or a point still gets some room.
        self.width = max(spans[0] * self.scale, 0.3 * room[0]) + 2 * EDGE
        self.height = max(spans[1] * self.scale, 0.3 * room[1]) + 2 * EDGE
        self._shift = (
            (self.width - spans[0] * self.scale) / 2,
            (self.height - spans[1] * self.scale) / 2,
        )

    def point(self, at: XY) -> XY:
        x = self._shift[0] + (at[0] - self._left) * self.scale
        return round(x, 2), round(self._shift[1] + (self._high - at[1]) * self.scale, 2)

    def text(self, at: XY) -> str:
        x, y = self.point(at)
        return f"{x:.1f} {y:.1f}"

    def box(self, box: Box) -> Box:
        left, low, width, height = box
        x, y = self.point((left, low + height))
        return x, y, round(width * self.scale, 2), round(height * self.scale, 2)


def _extent(scene: Scene, racks: Racks | None) -> tuple[float, float, float, float]:
    house = scene.instance.warehouse
    points = [house.depot]
    if racks is None:
        points += [house.position(place) for place in scene.instance.places]
        if isinstance(house, FloorMap | LaneNetwork):
            left, low, right, high = extent(house)
            points += [(left, low), (right, high)]
    else:
        left, low, width, height = racks.floor
        points += [(left, low), (left + width, low + height)]
    xs, ys = zip(*points, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _rack_boxes(racks: Racks, frame: _Frame) -> list[Box]:
    small = racks.slot * frame.scale < LEAST_SLOT
    return [frame.box(box) for box in (racks.racks() if small else racks.slots())]


def _names(racks: Racks, frame: _Frame) -> Iterable[tuple[XY, str]]:
    """Yield the numbers of the aisles, on the side away from the depot."""
    house = racks.house
    depth = racks.depth
    above = house.depot[1] <= depth / 2
    every = 1 + int(18 / (house.aisle_pitch * frame.scale))
    for aisle in range(0, house.aisles, every):
        x, y = frame.point(
            (aisle * house.aisle_pitch, depth + racks.cross if above else -racks.cross)
        )
        yield (x, y - 6 if above else y + 14), str(aisle)


def _middle(scene: Scene, racks: Racks | None, place: Place) -> XY:
    """Return where a place is drawn, metres: the middle of its slot."""
    if racks is None or not isinstance(place, Slot):
        return scene.instance.warehouse.position(place)
    left, low, width, height = racks.slot_box(place)
    return left + width / 2, low + height / 2


def _tracks(
    scene: Scene, journeys: Sequence[Journey], racks: Racks | None, frame: _Frame
) -> list[Track]:
    """Return the ways: beside each other along aisles, straight on other floors."""
    house = scene.instance.warehouse
    step = LANE / frame.scale
    if racks is not None:
        widths = 1.9 * racks.cross, 1.9 * racks.aisle
    elif isinstance(house, OpenFloor) and house.metric == "manhattan":
        widths = 6 * step, 6 * step
    elif is_drawn(house):
        return beside([j.legs for j in journeys], step, 3 * step)
    else:
        return [
            Track(
                [j.legs[0][0], *(p for leg in j.legs for p in leg[1:])],
                [leg[-1] for leg in j.legs[:-1]],
            )
            for j in journeys
        ]
    return Lanes([j.legs for j in journeys], margin=step).lines(step=step, widths=widths)


def _way(
    journey: Journey,
    track: Track,
    scene: Scene,
    racks: Racks | None,
    frame: _Frame,
    sharing: Sharing,
) -> Way:
    corners = [frame.point(at) for at in track.corners]
    letters = {"move": "M", "line": "L", "control": "Q", "curve": ""}
    steps = rounded(corners, BEND)
    path = "".join(f"{letters[kind]} {x:.1f} {y:.1f}" for kind, (x, y) in steps)
    return Way(
        number=journey.number,
        colour=journey.colour,
        path=path,
        arrows=tuple(_arrows(corners)),
        marks=tuple(_marks(journey, scene, racks, frame, sharing)),
        legs=tuple(_legs(corners, [frame.point(stop) for stop in track.stops])),
    )


def _arrows(corners: Sequence[XY], every: float = 120.0, size: float = 9.0) -> Iterable[str]:
    """Yield an arrow head for every so much of each straight part."""
    for (ax, ay), (bx, by) in pairwise(corners):
        length = math.dist((ax, ay), (bx, by))
        if length < 2.5 * size:
            continue
        dx, dy = (bx - ax) / length, (by - ay) / length
        number = max(1, round(length / every))
        for k in range(number):
            along = length * (k + 0.5) / number
            x, y = ax + dx * along, ay + dy * along
            back, side = size / 2, size * 0.42
            tip = x + dx * back, y + dy * back
            left = x - dx * back - dy * side, y - dy * back + dx * side
            right = x - dx * back + dy * side, y - dy * back - dx * side
            yield " ".join(f"{px:.1f},{py:.1f}" for px, py in (tip, left, right))


def _marks(
    journey: Journey, scene: Scene, racks: Racks | None, frame: _Frame, sharing: Sharing
) -> Iterable[Mark]:
    """Yield the places that the trip picks from, with the numbers of its stops there."""
    stops: dict[Place, list[int]] = {}
    for number, item in enumerate(journey.items, 1):
        stops.setdefault(item.place, []).append(number)
    for place, numbers in stops.items():
        texts = _texts(numbers)
        if racks is not None and isinstance(place, Slot):
            x, y, width, height = frame.box(racks.slot_box(place))
        else:
            x, y = frame.point(scene.instance.warehouse.position(place))
            wide = 9 + 7 * len(texts[0])
            x, y, width, height = x - wide / 2, y - 8, wide, 16.0
        others = sharing[place]  # each has a part of the box, from left to right
        width /= len(others)
        x += width * others.index(journey.number)
        for text in texts:
            font = min(FONTS[1], 0.85 * height, 1.5 * width / len(text))
            if font >= FONTS[0]:
                break
        else:
            text, font = "", 0.0
        yield Mark(round(x, 2), y, round(width, 2), height, text, round(font, 1), numbers[-1])


def _texts(numbers: Sequence[int]) -> list[str]:
    """Return how stops at one place can be told, the longest text first."""
    first, last = numbers[0], numbers[-1]
    if first == last:
        return [str(first)]
    if last - first == len(numbers) - 1:
        return [f"{first}-{last}", f"{first}+"]
    return [",".join(map(str, numbers)), f"{first}+"] if len(numbers) == 2 else [f"{first}+"]


def _legs(corners: Sequence[XY], stops: Sequence[XY]) -> list[tuple[XY, ...]]:
    """Cut a way at its stops, which lie on it in this sequence."""
    legs, at, k = [], corners[0], 0  # k: the corner that was passed last
    for wanted in stops:
        stop, part = wanted, [at]
        ahead = k
        while ahead < len(corners) - 1:
            start = at if ahead == k else corners[ahead]
            if _off(stop, start, corners[ahead + 1]) < 0.1:
                break
            ahead += 1
        else:
            ahead = k  # a rounding too much: it halts where it is
            stop = at
        part += corners[k + 1 : ahead + 1]
        legs.append((*part, stop))
        at, k = stop, ahead
    legs.append((at, *corners[k + 1 :]))
    return legs


def _off(at: XY, start: XY, end: XY) -> float:
    """Return how far a point is from a straight part of a way."""
    (ax, ay), (bx, by) = start, end
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    share = 0.0 if square == 0 else ((at[0] - ax) * dx + (at[1] - ay) * dy) / square
    share = min(max(share, 0.0), 1.0)
    return math.dist(at, (ax + share * dx, ay + share * dy))
