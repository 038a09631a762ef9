"""Tables for notebooks: plain HTML in which no name of a user is ever markup."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from qrobot import pages

__all__ = ["MOST_ROWS", "html_table", "shown_name"]

MOST_ROWS = 60
"""Rows of a table in a notebook; the rest is counted."""

LONGEST = 400
"""Characters of a cell."""


def html_table(
    title: str, heads: Sequence[str], rows: Sequence[Sequence[object]], picture: str = ""
) -> str:
    """Return a table of plain text, with its title above, and a picture (SVG of ours) below it."""
    return pages.render(
        Path(pages.__file__).with_name("notebook.html"),
        title=_text(title),
        heads=[_text(head) for head in heads],
        rows=[[_text(cell) for cell in row] for row in rows[:MOST_ROWS]],
        more=len(rows) - MOST_ROWS,
        picture=picture,
    )


def shown_name(name: str) -> str:
    """Return a name in quotes on one line, cut where it is long."""
    return repr(name if len(name) <= 40 else f"{name[:37]}...")


def _text(value: object) -> str:
    text = str(value)
    text = text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."
    # A notebook is UTF-8: a name that is not must not keep it from being saved.
    return text.encode("utf-8", "backslashreplace").decode()
