"""Animated pages to test, and what they say of where the robots are.

>>> from report.animated import Page, page_of
"""

from __future__ import annotations

import json
from bisect import bisect_right
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from qrobot.plan import Plan
from qrobot.problem import Instance
from qrobot.report import plot

__all__ = ["XY", "Page", "at", "page_of", "timed"]

XY = tuple[float, float]


class Page(HTMLParser):
    """The data of a page, and its tags."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.data: dict[str, Any] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        found = dict(attributes)
        assert not any(name.startswith("on") for name in found)
        if "data-plan" in found:
            self.data = json.loads(found["data-plan"] or "")


def timed(instance: Instance) -> Instance:
    """Return the question with robots of unlike speed and picks that take a while."""
    return replace(
        instance,
        items=tuple(
            replace(item, pick_seconds=float(k % 4)) for k, item in enumerate(instance.items)
        ),
        robots=tuple(
            replace(robot, speed=0.5 + 0.25 * k) for k, robot in enumerate(instance.robots)
        ),
    )


def page_of(plan: Plan, instance: Instance, folder: Path) -> str:
    plot(plan, folder / "page.html", instance)
    return (folder / "page.html").read_text()


def at(trip: dict[str, Any], moment: float) -> XY:
    """Return where a robot is at a moment, from the frames."""
    k = bisect_right(trip["t"], moment)
    if k == 0:
        return trip["x"][0], trip["y"][0]
    if k == len(trip["t"]):
        return trip["x"][-1], trip["y"][-1]
    share = (moment - trip["t"][k - 1]) / (trip["t"][k] - trip["t"][k - 1])
    x, y = (trip[n][k - 1] + share * (trip[n][k] - trip[n][k - 1]) for n in "xy")
    return x, y
