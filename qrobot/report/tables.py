"""Tables of text: the trips of a plan, and the backends."""

from __future__ import annotations

import math
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from qrobot._extras import install_command
from qrobot._numbers import number
from qrobot._text import columns, shown
from qrobot.backends import available, get, names, registry
from qrobot.errors import QRobotError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from qrobot.planning import RankedOrder, Result

__all__ = ["backend_rows", "backend_table", "ranking_table", "table"]

STOPS_WIDTH = 60


def table(result: Result) -> str:
    """Return the trips of a result as aligned text, long stop lists on several lines."""
    capacity = {robot.id: float(robot.capacity) for robot in result.instance.robots}
    rows: list[list[str]] = []
    for place, trip in enumerate(result.plan.trips, 1):
        wrapped = textwrap.wrap(
            " ".join(trip.named_stops()),
            STOPS_WIDTH,
            break_long_words=False,
            break_on_hyphens=False,
        )
        rows.append(
            [
                str(place),
                trip.robot,
                f"{number(trip.load)} / {number(capacity[trip.robot])}",
                number(trip.distance),
                f"{trip.seconds:.0f} s",
                str(len(trip.orders)),
                wrapped[0] if wrapped else "",
            ]
        )
        rows.extend([["", "", "", "", "", "", more] for more in wrapped[1:]])
    heads = ["trip", "robot", "load", "distance", "time", "orders", "stops in sequence"]
    return columns(heads, rows, numbers=frozenset({0, 2, 3, 4, 5}))


def ranking_table(ranked: Sequence[RankedOrder]) -> str:
    """Return orders as `rank_orders` ranks them as aligned text; ``-``: no way leads there."""
    heads = ["order", "extra distance", "distance", "seconds", "load"]
    rows = [
        [
            shown(one.order),
            *("-" if math.isinf(v) else number(v) for v in (one.extra, one.distance)),
            "-" if math.isinf(one.seconds) else f"{one.seconds:.0f} s",
            number(one.load),
        ]
        for one in ranked
    ]
    return columns(heads, rows, numbers=frozenset({1, 2, 3, 4}))


def backend_rows() -> list[dict[str, Any]]:
    """Return what every known backend says about itself; absent ones say how to install."""
    rows: list[dict[str, Any]] = []
    for name in names():
        row: dict[str, Any] = {"name": name, "installed": available(name)}
        try:
            row |= asdict(get(name).capabilities)
            row["extra"] = row["extra"] or registry.extra_for(name)
        except (QRobotError, ImportError) as error:
            row |= {"installed": False, "problem": str(error), "extra": registry.extra_for(name)}
        rows.append(row)
    return rows


def backend_table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as aligned text."""
    heads = ["backend", "kind", "where", "installed", "repeatable", "proves", "whole orders"]
    lines = []
    for row in rows:
        installed = "yes" if row["installed"] else "no"
        if not row["installed"] and row.get("extra"):
            installed = f"no: {install_command(row['extra'])}"
        where, facts = "-", ["-"] * 3
        if "kind" in row:
            where = "local" if row["local"] else "remote"
            flags = (row["deterministic"], row["proves"], row["whole_orders"])
            facts = ["yes" if flag else "no" for flag in flags]
        lines.append([row["name"], row.get("kind", "-"), where, installed, *facts])
    return columns(heads, lines)
