"""Pages that need nothing but themselves: no font, no request, and no script but one of ours.

Who has a page keeps its template beside the code that fills it: it extends ``frame.html`` of this
folder and takes tables, badges and charts from ``parts.html``. All values are escaped. A page that
moves names its `script` in the block ``policy``; a browser runs no other one.
"""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from qrobot._text import shortened

__all__ = ["Bar", "Script", "bars", "render", "script"]

if TYPE_CHECKING:
    from jinja2 import Environment

HERE = Path(__file__).parent

SIGNS = {
    "pass": "✓", "good": "✓", "healthy": "✓", "fail": "✗", "error": "✗", "fault": "✗",
    "unhealthy": "✗", "worse": "✗", "warning": "!", "absent": "–", "unknown": "?",
    "same": "✓", "drift": "✗", "unreachable": "–",
}  # fmt: skip
"""Of the statuses: colour alone tells nothing to those who do not see it."""

WIDTH, NAMES, NUMBERS, ROW, TOP = 370, 162, 42, 20, 22
"""Of a chart, of the names left and the numbers right of the bars, of a row, above all."""

LONGEST = 23
"""Letters of a name in a chart; longer ones are cut, and complete in the tooltip."""


def render(template: Path, **values: object) -> str:
    """Return a page.

    Parameters
    ----------
    template
        A Jinja2 template that extends ``frame.html``.
    values
        What it names. Text is escaped, whatever it holds.
    """
    return _environment(template.parent).get_template(template.name).render(values)


@cache
def _environment(folder: Path) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    made = Environment(
        loader=FileSystemLoader([folder, HERE]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.globals |= {"bars": bars, "signs": SIGNS}
    return made


@dataclass(frozen=True)
class Script:
    """A script of ours.

    Parameters
    ----------
    text
        Itself, safe in a template.
    source
        What the page's policy allows: its digest.
    """

    text: str
    source: str


def script(path: Path) -> Script:
    """Return the script of a file."""
    from markupsafe import Markup

    text = path.read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return Script(Markup(text), f"sha256-{digest}")  # noqa: S704 - a file of the package


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
    """Return a chart of horizontal bars: SVG that the page colours, safe in a template.

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
    from markupsafe import Markup

    room = WIDTH - NAMES - NUMBERS
    end = _round_up(max((sum(map(abs, row.parts)) for row in rows), default=0.0))
    drawn = []
    for k, row in enumerate(rows):
        x, parts = float(NAMES), []
        for length in row.parts:
            wide = room * max(length, 0.0) / end
            parts.append((x, wide))
            x += wide
        drawn.append((row, shortened(row.name, LONGEST), TOP + ROW * k, parts, x + 4))
    return Markup(  # noqa: S704 - made by a template that escapes
        render(
            HERE / "bars.html",
            ident=ident,
            title=title,
            size=(WIDTH, TOP + ROW * len(rows) + 4),
            names=NAMES,
            top=TOP,
            row_height=ROW,
            ticks=[(NAMES + room * share, f"{end * share:g}") for share in (0.0, 0.5, 1.0)],
            rows=drawn,
            legend=legend,
        )
    )


def _round_up(value: float) -> float:
    """Return the next of 1, 2, 5, 10, 20, 50 and so on: the end of a scale that reads well."""
    if not value > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9))
