"""A plan in an aisle warehouse: racks, aisles, closed parts, and each robot's way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import groupby
from typing import Any

from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import FancyArrowPatch, Rectangle

from qrobot.problem import AisleWarehouse, Slot
from qrobot.report.canvas import Canvas, Sheet
from qrobot.report.labels import POINTS, text_width
from qrobot.report.lanes import XY, Lanes, Track
from qrobot.report.maps import Look, Map
from qrobot.report.palette import Colour
from qrobot.report.racks import Racks
from qrobot.report.scene import Journey, Scene

__all__ = ["draw_aisles", "draw_panels"]

RACK, CLOSED = "#d5dbe2", "#f3d9d9"
HATCH = "#b4545c"
ONE_WAY = "#8a95a3"
NOT_PICKED = Colour("#9aa5b1", "#5b6673")


def draw_aisles(scene: Scene) -> Any:
    """Return the figure of a plan in an aisle warehouse."""
    house = scene.instance.warehouse
    assert isinstance(house, AisleWarehouse)
    racks = Racks(house)
    patches = [("slot; numbers: stops in sequence", RACK, "")]
    if house.closed_aisles or house.closed_crossings:
        patches.append(("closed", CLOSED, "////"))
    if house.is_one_way:
        patches.append(("arrows of this colour: one-way", ONE_WAY, ""))
    canvas = Canvas(scene, *_extent(racks), patches)
    _draw_all(canvas.main, scene, racks)
    for journey, own in canvas.panels:
        _draw_small(own, [journey], racks)
    return canvas.finish()


def _draw_all(drawn: Map, scene: Scene, racks: Racks) -> None:
    house = racks.house
    _floor(drawn, racks)
    _slots(drawn, racks)
    _closed(drawn, racks)
    _one_ways(drawn, racks)
    lines, look = _ways(drawn, scene.journeys, racks, most=2.5, every=110)
    for journey, line in zip(scene.journeys, lines, strict=True):
        drawn.halts(journey, line.stops, size=max(1.2, 1.9 * look.line))
    _picks(drawn, scene, racks, lines)
    for journey, line in zip(scene.journeys, lines, strict=True):
        drawn.tag(journey, line)
    depth, y = racks.depth, house.depot[1]
    below = y <= depth / 2
    # The label stands outside the floor, also when the depot stands inside.
    inside = y + racks.cross if below else depth + racks.cross - y
    away = max(12.0, drawn.points(inside) + 3)
    drawn.depot(
        house.depot,
        label=(0, -away if below else away),
        align=("center", "top" if below else "bottom"),
    )
    _names(drawn, racks, above=below)


def draw_panels(title: str, panels: Sequence[tuple[str, Scene]]) -> Any:
    """Return the figure of several scenes of one warehouse, each on a map with its title."""
    house = panels[0][1].instance.warehouse
    assert isinstance(house, AisleWarehouse)
    racks = Racks(house)
    sheet = Sheet(title, [text for text, _ in panels], *_extent(racks))
    for drawn, (_, scene) in zip(sheet.maps, panels, strict=True):
        _draw_small(drawn, scene.journeys, racks)
    return sheet.finish()


def _draw_small(drawn: Map, journeys: Sequence[Journey], racks: Racks) -> None:
    """Draw trips on a small map: racks without slots, stops as numbered marks."""
    _floor(drawn, racks)
    _racks(drawn, racks)
    _closed(drawn, racks)
    _one_ways(drawn, racks)
    lines, _ = _ways(drawn, journeys, racks, most=1.5, every=60)
    for journey, line in zip(journeys, lines, strict=True):
        drawn.stops(journey, line.stops)
    drawn.depot(racks.house.depot, size=7)


def _ways(
    drawn: Map, journeys: Sequence[Journey], racks: Racks, *, most: float, every: float
) -> tuple[list[Track], Look]:
    """Draw the ways, `most` points wide where their corridors have room for that."""
    widths = (1.9 * racks.cross, 1.9 * racks.aisle)
    lanes = Lanes([journey.legs for journey in journeys], margin=drawn.metres(6))
    width = max(0.9, min(most, drawn.points(lanes.widest_gap(widths)) / 1.7))
    look = Look(line=width, halo=0.5 * width, arrow=max(3.6, 3.2 * width), every=every)
    lines = lanes.lines(step=drawn.metres(2.1 * width), widths=widths)
    for journey, line in zip(journeys, lines, strict=True):
        drawn.way(journey, line, look, bend=drawn.metres(2.2 * width))
    return lines, look


def _extent(racks: Racks) -> tuple[XY, XY]:
    """Return two corners of a map, with room around the floor."""
    house = racks.house
    width, y = (house.aisles - 1) * house.aisle_pitch, house.depot[1]
    low = (-house.aisle_pitch / 2, min(-racks.cross, y))
    high = (width + house.aisle_pitch / 2, max(racks.depth + racks.cross, y))
    room = 0.055 * max(high[0] - low[0], high[1] - low[1])
    return (low[0] - room / 3, low[1] - room), (high[0] + room / 3, high[1] + room)


def _corners(left: float, bottom: float, width: float, height: float) -> list[XY]:
    right, top = left + width, bottom + height
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


def _floor(drawn: Map, racks: Racks) -> None:
    left, low, width, height = racks.floor
    drawn.axes.add_artist(
        Rectangle(
            (left, low),
            width,
            height,
            fc="none",
            ec="#8a95a3",
            lw=1.2,
            gid=f"{drawn.prefix}floor",
            zorder=1.5,
        )
    )


def _slots(drawn: Map, racks: Racks) -> None:
    thin = max(0.1, min(0.8, drawn.points(racks.slot) / 14))
    drawn.axes.add_artist(
        PolyCollection(
            [_corners(*box) for box in racks.slots()],
            facecolors=RACK,
            edgecolors="white",
            linewidths=thin,
            zorder=1,
            gid="racks",
        )
    )


def _racks(drawn: Map, racks: Racks) -> None:
    """Draw each side of an aisle's block as one rack."""
    boxes = [_corners(*box) for box in racks.racks()]
    drawn.axes.add_artist(PolyCollection(boxes, facecolors=RACK, edgecolors="none", zorder=1))


def _closed(drawn: Map, racks: Racks) -> None:
    for n, (left, bottom, width, height) in enumerate(racks.closed(), 1):
        drawn.axes.add_artist(
            Rectangle(
                (left, bottom),
                width,
                height,
                fc=CLOSED,
                ec=HATCH,
                lw=0.6,
                hatch="////",
                zorder=2,
                gid=f"{drawn.prefix}closed-{n}",
            )
        )


def _one_ways(drawn: Map, racks: Racks) -> None:
    """Draw an arrow along each part that is walked in one direction only."""
    for n, (first, last) in enumerate(racks.one_ways(), 1):
        arrow = FancyArrowPatch(
            first,
            last,
            arrowstyle="-|>",
            mutation_scale=10,
            shrinkA=2,
            shrinkB=2,
            lw=0.8,
            ls=(0, (1, 2)),
            color=ONE_WAY,
            zorder=2.5,
            gid=f"{drawn.prefix}one-way-{n}",
        )
        drawn.axes.add_artist(arrow)


def _picks(drawn: Map, scene: Scene, racks: Racks, lines: list[Track]) -> None:
    """Colour the slots that are picked from and number them by stop."""
    at: defaultdict[Slot, list[tuple[int, int]]] = defaultdict(list)  # (journey, stop)
    for j, journey in enumerate(scene.journeys):
        for stop, item in enumerate(journey.items):
            assert isinstance(item.place, Slot)
            at[item.place].append((j, stop))
    boxes: defaultdict[int, list[list[XY]]] = defaultdict(list)
    arms: defaultdict[int, list[list[XY]]] = defaultdict(list)
    for slot, visits in at.items():
        left, bottom, width, height = racks.slot_box(slot)
        parts = [(j, [s for _, s in group]) for j, group in groupby(sorted(visits), lambda v: v[0])]
        each = width / len(parts)
        for k, (j, stops) in enumerate(parts):
            x = left + k * each
            boxes[j].append(_corners(x, bottom, each, height))
            _number(drawn, (x + each / 2, bottom + height / 2), (each, height), stops, scene, j)
            arm = lines[j].stops[stops[0]]
            side = left + width if slot.side == "left" else left
            arms[j].append([arm, (side, arm[1])])
    waiting = [
        i.place for i in scene.instance.items if isinstance(i.place, Slot) and i.place not in at
    ]
    if waiting:
        boxes[-1] = [_corners(*racks.slot_box(slot)) for slot in waiting]
    for j, polygons in boxes.items():
        colour = NOT_PICKED if j < 0 else scene.journeys[j].colour
        name = "not-picked" if j < 0 else f"trip-{scene.journeys[j].number}-picks"
        drawn.axes.add_artist(
            PolyCollection(
                polygons,
                facecolors=colour.fill,
                edgecolors=colour.edge,
                linewidths=min(0.8, drawn.points(racks.slot) / 12),
                zorder=3,
                gid=name,
            )
        )
    for j, segments in arms.items():
        drawn.axes.add_artist(
            LineCollection(
                segments,
                colors=scene.journeys[j].colour.edge,
                linewidths=min(0.9, drawn.points(racks.slot) / 12),
                zorder=3.5,
            )
        )


def _number(drawn: Map, at: XY, box: XY, stops: list[int], scene: Scene, journey: int) -> None:
    first, last = stops[0] + 1, stops[-1] + 1
    texts = [f"{first}+"]
    if first == last:
        texts = [f"{first}"]
    elif last - first == len(stops) - 1:
        texts = [f"{first}-{last}", *texts]
    elif len(stops) == 2:
        texts = [f"{first},{last}", *texts]
    for text in texts:
        wide = drawn.points(box[0]) * 0.84 / (POINTS * text_width(text, 1.0, "bold"))
        size = min(8.5, drawn.points(box[1]) * 0.78, wide)
        if size >= 3.4:
            drawn.number(scene.journeys[journey], at, text, size)
            return


def _names(drawn: Map, racks: Racks, *, above: bool) -> None:
    """Write the numbers of the aisles on the side away from the depot."""
    house = racks.house
    y = racks.depth + racks.cross if above else -racks.cross
    offset = 5 if above else -5
    every = 1 + int(house.aisles * 17 / max(drawn.points((house.aisles) * house.aisle_pitch), 1))
    for aisle in range(0, house.aisles, every):
        text = drawn.axes.annotate(
            f"aisle {aisle}" if aisle == 0 else f"{aisle}",
            (aisle * house.aisle_pitch, y),
            xytext=(0, offset),
            textcoords="offset points",
            ha="center",
            va="bottom" if above else "top",
            size=7.5,
            color="#5b6673",
        )
        drawn.labels.add(text)
