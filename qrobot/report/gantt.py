"""The schedule of the robots as a picture: a row a robot, a bar a trip (Gantt 1910)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from qrobot._files import StrPath
from qrobot._numbers import number
from qrobot._text import shown
from qrobot.report.fonts import font_notes
from qrobot.report.palette import GREY, INK
from qrobot.report.picture import check_picture_path, save, style

if TYPE_CHECKING:
    from qrobot.report.schedules import RobotSchedule, Schedule

__all__ = ["draw_schedule"]

WIDTH, ROW, REST = 9.0, 0.42, 1.3
"""Inches: of the sheet, of a row, of all above and below."""

TALLEST = 60.0
"""Inches that all rows take at most: more become lower, and their texts smaller."""

TEXT = 8.0
"""Points of the numbers on the bars."""

PALE = 0.6
"""How much white lies over the parts of a trip in which the robot stands and does not collect."""

WIDE = 0.035
"""Share of the time from which a trip's number fits into its bar."""


def draw_schedule(schedule: Schedule, path: StrPath) -> tuple[str, ...]:
    """Draw the schedule and write it as SVG or PNG, as the file's suffix says.

    Bars are trips, their dark parts the stops at which the robot collects, their pale parts the
    set-up at the depot and waiting for other robots. Robots without a trip are left out.

    Returns
    -------
    tuple of str
        What a person should know of the picture, a sentence each.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    InputError
        When the suffix is another one, or the file cannot be written.
    """
    kind = check_picture_path(path)
    busy = [own for own in schedule.robots if own.trips]
    title = f"{shown(schedule.scene.instance.name, 60)}: all back after {number(schedule.ends)} s"
    texts = [title, *(shown(own.robot, 20) for own in busy)]
    with style(texts) as missing:
        save(_figure(busy, schedule.ends, *texts), path)
        # In an SVG text stays text, and who looks at it has fonts of their own.
        return tuple(font_notes(missing, texts)) if kind == "png" else ()


def _figure(busy: Sequence[RobotSchedule], ends: float, title: str, *names: str) -> Any:
    from matplotlib.figure import Figure

    row_height = min(ROW, TALLEST / max(len(busy), 1))
    figure = Figure(figsize=(WIDTH, REST + row_height * len(busy)), layout="constrained")
    axes = figure.subplots()
    small = TEXT * row_height / ROW
    for row, own in enumerate(busy):
        for trip in own.trips:
            colour = trip.journey.colour
            long = trip.ends - trip.begins
            axes.barh(
                row, long, left=trip.begins, height=0.72, color=colour.fill, edgecolor=colour.edge,
                linewidth=0.8, gid=f"trip-{trip.journey.number}",
            )  # fmt: skip
            stops = [
                (trip.begins + visit.arrives, visit.leaves - visit.arrives)
                for visit in trip.visits
                if visit.leaves > visit.arrives
            ]
            axes.broken_barh(stops, (row - 0.36, 0.14), color=colour.edge)
            still = [(trip.begins, trip.leaves), *trip.waits]
            axes.broken_barh(
                [(since, until - since) for since, until in still if until > since],
                (row + 0.19, 0.14), color="white", alpha=PALE, linewidth=0.0,
            )  # fmt: skip
            if long > WIDE * ends:
                axes.text(
                    trip.begins + long / 2, row, trip.journey.tag, color=colour.text,
                    ha="center", va="center", fontsize=small,
                )  # fmt: skip
    axes.set_yticks(range(len(busy)), names, fontsize=small + 1.0)
    axes.set_ylim(len(busy) - 0.4, -0.6)
    axes.set_xlim(0.0, ends or 1.0)
    axes.set_xlabel("seconds")
    axes.set_title(title, loc="left", fontsize=11, color=INK)
    axes.tick_params(colors=INK)
    axes.grid(axis="x", color=GREY, alpha=0.25)
    axes.set_axisbelow(True)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    return figure
