"""Bars as inline SVG: readable on a narrow screen, coloured by the page, without a script."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

__all__ = ["Bar", "bars"]

WIDTH, NAMES, NUMBERS, ROW, TOP = 370, 162, 42, 20, 22
"""Of the drawing, of the names left and the numbers right of the bars, of a row, above all."""

LONGEST = 23
"""Letters of a name; longer ones are cut, and whole in the tooltip."""


@dataclass(frozen=True)
class Bar:
    """One row of a chart.

    Parameters
    ----------
    name
        At its left.
    parts
        Lengths of the parts of the bar, one colour each, all at least zero.
    text
        At its right.
    """

    name: str
    parts: tuple[float, ...]
    text: str


def bars(ident: str, title: str, rows: Sequence[Bar], legend: Sequence[str] = ()) -> str:
    """Return a chart of horizontal bars.

    Parameters
    ----------
    ident
        Unique in the page.
    title
        For those who do not see it.
    rows
        From top to bottom.
    legend
        Names of the parts.
    """
    longest = max((sum(map(abs, row.parts)) for row in rows), default=0.0)
    most = _round_up(longest)
    room = WIDTH - NAMES - NUMBERS
    height = TOP + ROW * len(rows) + 4
    drawn = [
        f'<svg class="chart" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'aria-labelledby="{ident}-title">',
        f'<title id="{ident}-title">{escape(title)}</title>',
        *_scale(most, room, height),
    ]
    for number, row in enumerate(rows):
        y = TOP + ROW * number
        name = row.name if len(row.name) <= LONGEST else row.name[: LONGEST - 1] + "…"
        drawn.append(f"<g><title>{escape(row.name)}: {escape(row.text)}</title>")
        drawn.append(f'<text class="name" x="{NAMES - 6}" y="{y + 14}">{escape(name)}</text>')
        x = float(NAMES)
        for part, length in enumerate(row.parts):
            wide = room * max(length, 0.0) / most
            drawn.append(
                f'<rect class="part{part}" x="{x:.1f}" y="{y + 4}" '
                f'width="{wide:.1f}" height="{ROW - 7}"/>'
            )
            x += wide
        drawn.append(f'<text class="number" x="{x + 4:.1f}" y="{y + 14}">{escape(row.text)}</text>')
        drawn.append("</g>")
    drawn.append("</svg>")
    keys = "".join(
        f'<span><i class="key part{part}"></i>{escape(name)}</span>'
        for part, name in enumerate(legend)
    )
    return "\n".join([*drawn, f'<p class="legend">{keys}</p>' if keys else ""])


def _scale(most: float, room: float, height: int) -> list[str]:
    lines = []
    for share in (0.0, 0.5, 1.0):
        x = NAMES + room * share
        lines.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP - 4}" y2="{height}"/>')
        lines.append(f'<text class="tick" x="{x:.1f}" y="{TOP - 8}">{most * share:g}</text>')
    return lines


def _round_up(value: float) -> float:
    """Return the next of 1, 2, 5, 10, 20, 50 and so on: the end of a scale that reads well."""
    if not value > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9))
