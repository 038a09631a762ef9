"""The frame of a page that needs nothing but itself: no script, no font, no request."""

from __future__ import annotations

from html import escape
from importlib import resources

from qrobot.health.reports.table import Table

__all__ = ["frame", "html_table"]

POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""So that a browser refuses any request, even one that got in by a mistake of ours."""

MARKS = {
    "pass": "✓", "good": "✓", "healthy": "✓", "fail": "✗", "error": "✗", "fault": "✗",
    "unhealthy": "✗", "worse": "✗", "warning": "!", "absent": "–", "unknown": "?",
}  # fmt: skip
"""Colour alone tells nothing to those who do not see it."""


def frame(title: str, body: str) -> str:
    """Return a whole page.

    Parameters
    ----------
    title
        Plain text.
    body
        HTML.
    """
    style = (resources.files("qrobot.health.reports") / "page.css").read_text(encoding="utf-8")
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="color-scheme" content="light dark">
<title>{escape(title)}</title>
<link rel="icon" href="data:,">
<style>
{style.strip()}
</style>
</head>
<body>
<main>
{body.strip()}
</main>
</body>
</html>
"""


def mark(status: str) -> str:
    """Return a status as a coloured badge with a sign."""
    if status not in MARKS:
        return escape(status)
    return f'<span class="badge {status}">{MARKS[status]} {status}</span>'


def html_table(table: Table, *, wide: bool = False) -> str:
    """Return a table; on a narrow screen its rows become cards, or it scrolls when it is wide.

    Roles are given in words too: a browser forgets them for tables that are laid out as cards.
    """
    lines = [
        f'<table role="table" class="{"wide" if wide else "cards"}">',
        f"<caption>{escape(table.caption)}</caption>",
        '<thead role="rowgroup"><tr role="row">',
    ]
    kinds = ["number" if column in table.numbers else "" for column in range(len(table.heads))]
    for head, kind in zip(table.heads, kinds, strict=True):
        lines.append(f'<th role="columnheader" scope="col" class="{kind}">{escape(head)}</th>')
    lines.append('</tr></thead>\n<tbody role="rowgroup">')
    for number, row in enumerate(table.rows):
        cells = []
        for column, (cell, head) in enumerate(zip(row, table.heads, strict=True)):
            text = mark(cell) if column == table.status else escape(cell)
            if column == 0:
                cells.append(f'<th role="rowheader" scope="row">{text}</th>')
                continue
            kind = "odd" if (number, column) in table.odd else kinds[column]
            cells.append(f'<td role="cell" class="{kind}" data-label="{escape(head)}">{text}</td>')
        lines.append(f'<tr role="row">{"".join(cells)}</tr>')
    lines.append("</tbody></table>")
    made = "\n".join(lines).replace(' class=""', "")
    if not wide:
        return made
    label = escape(table.caption)
    # A focus, so that a keyboard can scroll it too.
    return f'<div class="scroll" role="region" tabindex="0" aria-label="{label}">\n{made}\n</div>'
