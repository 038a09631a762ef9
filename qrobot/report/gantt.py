"""The schedule of the robots as a picture: a row a robot, a bar a trip (Gantt 1910)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from qrobot._files import StrPath
from qrobot._numbers import number
from qrobot._text import shown
from qrobot.report.palette import GREY, INK
from qrobot.report.picture import check_picture_path, save, style

if TYPE_CHECKING:
    from qrobot.report.schedules import Schedule

__all__ = ["draw_schedule"]

WIDTH, ROW, REST = 9.0, 0.42, 1.3
"""Inches: of the sheet, of a row, of all above and below."""

TALLEST = 60.0
"""Inches; rows become lower beyond."""

WIDE = 0.035
"""Share of the time from which a trip's number fits into its bar."""


def draw_schedule(schedule: Schedule, path: StrPath) -> None:
    """Draw the schedule and write it as SVG or PNG, as the file's suffix says.

    Bars are trips, their dark parts the stops at which the robot collects.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    InputError
        When the suffix is another one, or the file cannot be written.
    """
    check_picture_path(path)
    title = f"{shown(schedule.scene.instance.name, 60)}: all back after {number(schedule.ends)} s"
    names = [shown(day.robot, 20) for day in schedule.robots]
    with style([title, *names]):
        save(_figure(schedule, title, names), path)


def _figure(schedule: Schedule, title: str, names: list[str]) -> Any:
    from matplotlib.figure import Figure

    height = min(REST + ROW * max(len(names), 1), TALLEST)
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots()
    for row, day in enumerate(schedule.robots):
        for trip in day.trips:
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
            if long > WIDE * schedule.ends:
                axes.text(
                    trip.begins + long / 2, row, trip.journey.tag, color=colour.text,
                    ha="center", va="center", fontsize=8,
                )  # fmt: skip
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(0.0, max(schedule.ends, 1.0))
    axes.set_xlabel("seconds")
    axes.set_title(title, loc="left", fontsize=11, color=INK)
    axes.tick_params(colors=INK)
    axes.grid(axis="x", color=GREY, alpha=0.25)
    axes.set_axisbelow(True)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    return figure
