"""Aligned text columns: the same with and without a terminal."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["columns", "shortened", "shown"]


def columns(
    heads: Sequence[str], rows: Sequence[Sequence[str]], numbers: frozenset[int] = frozenset()
) -> str:
    """Return a table as lines of text.

    Parameters
    ----------
    heads
        Column titles.
    rows
        Cells, as many as titles.
    numbers
        Columns that are set to the right.
    """
    cells = [list(heads), *(list(row) for row in rows)]
    widths = [max(len(row[c]) for row in cells) for c in range(len(heads))]

    def line(row: Sequence[str]) -> str:
        parts = [
            cell.rjust(width) if c in numbers else cell.ljust(width)
            for c, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        return "  ".join(parts).rstrip()

    return "\n".join(
        [line(cells[0]), *("  ".join("-" * w for w in widths).splitlines()), *map(line, cells[1:])]
    )


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
