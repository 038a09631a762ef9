"""A plan on an open floor or over a table of distances: points and the ways between them."""

from __future__ import annotations

from typing import Any

from qrobot.problem import DistanceTable, OpenFloor
from qrobot.report.canvas import Canvas, Look
from qrobot.report.scene import Scene

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
