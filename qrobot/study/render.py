"""The renderer of every study: CSV, Markdown, a plot, and the machine in one sentence."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from qrobot._csv import csv_text
from qrobot._files import write_text_atomic
from qrobot._numbers import number
from qrobot.report.picture import save, style

__all__ = ["figure_text", "machine_text", "markdown_table", "percent", "plotted", "write_csv"]


def write_csv(
    rows: Sequence[dict[str, Any]], columns: Sequence[str], path: str | os.PathLike[str]
) -> None:
    """Write some columns of rows as CSV."""
    write_text_atomic(path, csv_text(rows, columns))


def markdown_table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], left: Collection[int] = ()
) -> list[str]:
    """Return the lines of a Markdown table: numbers to the right, columns of `left` to the left."""
    marks = "|".join("---" if k in left else "--:" for k in range(len(heads)))
    lines = [f"| {' | '.join(row)} |" for row in (heads, *rows)]
    return [lines[0], f"|{marks}|", *lines[1:]]


def machine_text(report: dict[str, Any]) -> str:
    """Return the machine, the versions and the day of a report in one sentence."""
    host = report["machine"]
    packages = ", ".join(f"{name} {version}" for name, version in host["packages"].items())
    return (
        f"{host['processor']}, {host['cores']} cores, {host['memory_gb']} GB; Python "
        f"{host['python']}; qrobot {host['qrobot']}, {packages}; {report['started'][:10]}."
    )


def percent(value: float | None, digits: int = 2) -> str:
    """Return a share in percent, ``-`` where there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{round(100 * value, digits) + 0.0:.{digits}f} %"  # never "-0"


def figure_text(value: float | None, digits: int | None = None) -> str:
    """Return a number as people read it, rounded to some digits; ``-`` where there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    return number(value if digits is None else round(value, digits))


@contextmanager
def plotted(path: str | os.PathLike[str], size: tuple[float, float]) -> Iterator[tuple[Any, Any]]:
    """Give a figure with one pair of axes to draw on, and write it as SVG or PNG."""
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=size, layout="constrained", facecolor="white")
        axes = figure.add_subplot()
        axes.grid(alpha=0.3)
        yield figure, axes
        save(figure, path)
