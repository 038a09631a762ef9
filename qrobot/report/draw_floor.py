"""A plan on an open floor or over a table of distances: points and the ways between them."""

from __future__ import annotations

from typing import Any

from qrobot.problem import DistanceTable, OpenFloor
from qrobot.report.canvas import Canvas, Look
from qrobot.report.scene import Scene, number

__all__ = ["draw_floor"]


def draw_floor(scene: Scene) -> Any:
    """Return the figure of a plan on an open floor or over a table of distances."""
    house = scene.instance.warehouse
    assert isinstance(house, OpenFloor | DistanceTable)
    spots = [house.position(item.place) for item in scene.instance.items]
    xs, ys = zip(*spots, house.depot, strict=True)
    low, high = (min(xs), min(ys)), (max(xs), max(ys))
    span = max(high[0] - low[0], high[1] - low[1]) or 1.0
    # A line of points still gets a sheet that looks like a floor.
    thin = [max(0.0, 0.3 * span - (high[k] - low[k])) / 2 for k in (0, 1)]
    pad = 0.075 * span
    canvas = Canvas(
        scene,
        (low[0] - thin[0] - pad, low[1] - thin[1] - pad),
        (high[0] + thin[0] + pad, high[1] + thin[1] + pad),
    )
    _frame(canvas, house)
    marker = _marker(canvas, spots)
    line = max(0.9, min(2.3, marker / 6))
    look = Look(line=line, halo=1.2, arrow=max(4.0, 3.4 * line), every=1e9)
    lines = _lines(canvas, scene, house, look)
    for journey, drawn in zip(scene.journeys, lines, strict=True):
        canvas.way(journey, drawn.corners, look, bend=canvas.metres(2.5 * line))
    _points(canvas, scene, marker)
    canvas.depot(house.depot, label=(0, -11), align=("center", "top"))
    return canvas.figure


def _frame(canvas: Canvas, house: OpenFloor | DistanceTable) -> None:
    """Draw a light grid in metres where coordinates mean something."""
    axes = canvas.axes
    if isinstance(house, DistanceTable):
        return
    axes.set_axis_on()
    axes.set_axisbelow(True)
    axes.grid(color="#e9edf1", lw=0.8)
    axes.tick_params(length=0, labelsize=7.5, labelcolor="#5b6673", pad=3)
    for side in axes.spines.values():
        side.set_color("#c3ccd6")


def _marker(canvas: Canvas, spots: Sequence[XY]) -> float:
    """Return the size of the items' markers, points: they should hardly overlap."""
    box = canvas.axes.get_window_extent()
    area = box.width * box.height / canvas.figure.dpi**2 * 72**2
    return max(2.0, min(17.0, 0.62 * math.sqrt(area / max(len(set(spots)), 1)) * 0.5))


def _lines(canvas: Canvas, scene: Scene, house: OpenFloor | DistanceTable, look: Look) -> list[Line]:
    legs = [journey.legs for journey in scene.journeys]
    if isinstance(house, OpenFloor) and house.metric == "manhattan":
        room = canvas.metres(30)
        lanes = Lanes(legs, margin=canvas.metres(4))
        return lanes.lines(step=canvas.metres(1.9 * look.line), widths=(room, room))
    ends = Counter(frozenset((leg[0], leg[-1])) for trip in legs for leg in trip)
    return [
        Line(
            [trip[0][0], *(p for leg in trip for p in _leg(leg, ends))],
            [leg[-1] for leg in trip[:-1]],
        )
        for trip in legs
    ]


def _leg(leg: Sequence[XY], ends: Counter[frozenset[XY]]) -> list[XY]:
    """Return the points after the first; a leg that others share bows to its right."""
    (ax, ay), (bx, by) = leg[0], leg[-1]
    if ends[frozenset((leg[0], leg[-1]))] < 2 or leg[0] == leg[-1]:
        return list(leg[1:])
    bow, points = 0.05, []
    for k in range(1, 17):
        t = k / 16
        off = 4 * bow * t * (1 - t)
        points.append((ax + (bx - ax) * t + (by - ay) * off, ay + (by - ay) * t - (bx - ax) * off))
    return points


def _points(canvas: Canvas, scene: Scene, size: float) -> None:
    """Draw the items: coloured and numbered by stop, small floors with their names."""
    axes = canvas.axes
    house = scene.instance.warehouse
    few = scene.instance.size <= 25
    picked = set()
    for journey in scene.journeys:
        spots = [house.position(item.place) for item in journey.items]
        picked |= {item.id for item in journey.items}
        axes.plot(
            [x for x, _ in spots], [y for _, y in spots], ls="none", marker="o", ms=size,
            mfc=journey.colour.fill, mec=journey.colour.edge, mew=min(1.1, size / 9), zorder=6,
            gid=f"trip-{journey.number}-stops",
        )
        for n, (x, y) in enumerate(spots, 1):
            font = min(8.5, 0.62 * size) if n < 100 else 0.45 * size
            if font >= 3.2:
                axes.text(
                    x, y, str(n), size=font, color=journey.colour.text, weight="bold",
                    ha="center", va="center_baseline", zorder=7,
                )
    waiting = [house.position(i.place) for i in scene.instance.items if i.id not in picked]
    if waiting:
        axes.plot(
            [x for x, _ in waiting], [y for _, y in waiting], ls="none", marker="o", ms=size,
            mfc="#c3ccd6", mec="#5b6673", zorder=5, gid="not-picked",
        )
    if few:
        for item in scene.instance.items:
            axes.annotate(
                f"{item.id} ({number(item.weight)})", house.position(item.place),
                xytext=(0.55 * size + 1.5, 0.55 * size - 1), textcoords="offset points",
                size=8, color="#5b6673", zorder=7,
            )
