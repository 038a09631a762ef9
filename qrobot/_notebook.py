"""Tables for notebooks: plain HTML in which no name of a user is ever markup."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

__all__ = ["MOST_ROWS", "html_table", "shown_name"]

MOST_ROWS = 60
"""Rows of a table in a notebook; the rest is counted."""

LONGEST = 400
"""Characters of a cell."""


def html_table(
    title: str, heads: Sequence[str], rows: Sequence[Sequence[object]], below: str = ""
) -> str:
    """Return a table with a line above it.

    Parameters
    ----------
    title
        The line above, as plain text.
    heads, rows
        The cells, as plain text.
    below
        What follows, as HTML of ours.
    """
    more = len(rows) - MOST_ROWS
    body = "".join(_row("td", row) for row in rows[:MOST_ROWS])
    if more > 0:
        body += f'<tr><td colspan="{max(len(heads), 1)}">... and {more} more</td></tr>'
    head = f"<thead>{_row('th', heads)}</thead>" if heads else ""
    return f"<div><p>{_text(title)}</p><table>{head}<tbody>{body}</tbody></table>{below}</div>"


def shown_name(name: str) -> str:
    """Return a name in quotes on one line, cut where it is long."""
    return repr(name if len(name) <= 40 else f"{name[:37]}...")


def _row(tag: str, cells: Sequence[object]) -> str:
    return f"<tr>{''.join(f'<{tag}>{_text(cell)}</{tag}>' for cell in cells)}</tr>"


def _text(value: object) -> str:
    text = str(value)
    text = text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."
    # A notebook is UTF-8: a name that is not must not keep it from being saved.
    text = text.encode("utf-8", "backslashreplace").decode()
    return escape(text).replace("\n", "<br/>")
