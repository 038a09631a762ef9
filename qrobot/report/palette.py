"""Colours and marks: of the robots, by the paper's convention, and of all else on a picture."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from typing import Any

__all__ = ["DASHES", "DEPOT", "GREY", "INK", "Colour", "colour_of", "depot_marker"]

INK = "#1f2933"
GREY = "#5b6673"
DEPOT = "#ffef5c"

DASHES: tuple[Any, ...] = ("solid", (0, (5, 1.6)), (0, (2.2, 1.2)), (0, (6, 1.4, 1.4, 1.4)))
"""Of a robot's first, second, ... trip."""


@dataclass(frozen=True, slots=True)
class Colour:
    """How a robot is drawn.

    Parameters
    ----------
    fill
        Of its way and of the slots it picks from.
    edge
        Outline, dark enough to be seen on white.
    text
        Of numbers on the fill.
    """

    fill: str
    edge: str
    text: str = "#ffffff"


# Robot 1 red, 2 blue, 3 yellow: the paper's figures. The others stay apart from these and
# from each other, for people who see red and green alike too, by their lightness.
_ROBOTS = (
    Colour("#d62839", "#8f1523"),
    Colour("#1d63c9", "#0f3c80"),
    Colour("#f2b705", "#6b4e00", INK),
    Colour("#1b9e63", "#0d6640"),
    Colour("#7a3e9d", "#4f2269"),
    Colour("#16b1c4", "#0a6873", INK),
    Colour("#8a5a3c", "#573622"),
    Colour("#ee7db2", "#a23a70", INK),
    Colour("#4d5766", "#2b323d"),
    Colour("#9bc53d", "#587518", INK),
    Colour("#f26b21", "#963b07"),
    Colour("#0b2e59", "#051a35"),
)


def colour_of(robot: int) -> Colour:
    """Return the colour of a robot by its index in the fleet, from 0."""
    if robot < len(_ROBOTS):
        return _ROBOTS[robot]
    turn = robot - len(_ROBOTS)
    hue = (0.09 + turn * 0.618034) % 1.0  # the golden ratio keeps neighbours apart
    light = (0.42, 0.58, 0.34)[turn % 3]
    dark = light > 0.5
    return Colour(
        _hex(colorsys.hls_to_rgb(hue, light, 0.62)),
        _hex(colorsys.hls_to_rgb(hue, light * 0.55, 0.62)),
        INK if dark else "#ffffff",
    )


def _hex(rgb: tuple[float, float, float]) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in rgb)


def depot_marker(size: float) -> dict[str, Any]:
    """Return how the depot is drawn."""
    return {"ls": "none", "marker": "s", "ms": size, "mfc": DEPOT, "mec": INK, "mew": size / 11}
