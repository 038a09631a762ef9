"""Text for people: tables, names and counts, the same on a terminal, a page and a picture."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Table", "columns", "count", "printable", "shortened", "shown"]

CONTROLS = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters (a terminal obeys them), what turns the direction of writing, and what no
UTF-8 can hold."""


@dataclass(frozen=True)
class Table:
    """Rows of text under heads, as `columns` and the pages show them.

    Parameters
    ----------
    caption
        What it shows.
    heads, rows
        As many cells in a row as heads; the first one names the row.
    numbers
        Columns that are set to the right.
    status
        The column that holds a status, which a page colours; None without one.
    odd
        Cells (row, column) that a page points out.
    """

    caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: frozenset[int] = frozenset()
    status: int | None = None
    odd: frozenset[tuple[int, int]] = frozenset()


def columns(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    numbers: frozenset[int] = frozenset(),
    *,
    ruled: bool = True,
) -> str:
    """Return a table as aligned lines of text.

    Parameters
    ----------
    numbers
        Columns that are set to the right.
    ruled
        Whether a rule stands under the titles.
    """
    cells = [list(heads), *map(list, rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    if ruled and any(widths):
        cells.insert(1, ["-" * width for width in widths])
    return "\n".join(
        "  ".join(
            cell.rjust(width) if k in numbers else cell.ljust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    )


def count(number: int, thing: str) -> str:
    """Return so many things: ``1 robot``, ``2 robots``."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def printable(text: str) -> str:
    """Return a text of others, such as another machine's report, as one line.

    A sign stands in place of every character that a terminal would obey or not show.
    """
    return CONTROLS.sub("\ufffd", text)


def shortened(text: str, most: int) -> str:
    """Return a text of at most so many letters."""
    return text if len(text) <= most else text[: most - 1] + "…"


def shown(text: str, most: int = 24) -> str:
    """Return a name as one line of at most so many letters.

    A longer one loses its middle: the ends of names that begin alike tell them apart.
    """
    line = " ".join(text.split())
    line = "".join(c if c.isprintable() else "\ufffd" for c in line)
    last = most // 2
    return line if len(line) <= most else f"{line[: most - last - 1]}…{line[-last:]}"
