"""The view of many machines as one page."""

from __future__ import annotations

from html import escape

from qrobot.health.reports.charts import Bar, bars
from qrobot.health.reports.fleet import Column, Fleet
from qrobot.health.reports.page import frame, html_table, mark

__all__ = ["fleet_html"]


def fleet_html(fleet: Fleet) -> str:
    """Return the page: who is unhealthy, what differs and on whom, and who is slow."""
    parts = [
        "<h1>Health of the fleet</h1>",
        f'<p class="verdict">{mark("unhealthy" if fleet.unhealthy else "healthy")} '
        f"{escape(fleet.headline())}</p>",
    ]
    notes = [*fleet.notes, *fleet.bad_lines(), *fleet.slow_lines()]
    if notes:
        items = "\n".join(f"<li>{escape(note)}</li>" for note in notes)
        parts.append(f'<h2>Needs attention</h2>\n<ul class="notes">\n{items}\n</ul>')
    if fleet.columns:
        items = "\n".join(f"<li>{_sentence(column)}</li>" for column in fleet.columns)
        parts.append(f'<h2>What differs</h2>\n<ul class="notes">\n{items}\n</ul>')
    else:
        parts.append("<h2>What differs</h2>\n<p>Nothing: all machines are alike.</p>")
    parts += ["<h2>Machines</h2>", html_table(fleet.table(), wide=True)]
    paced = [Bar(name, (pace,), f"{pace:.2f}") for name, pace in fleet.pace.items() if pace]
    if len(paced) > 1:
        drawn = bars("pace", "Time of every machine over the median of the fleet", paced)
        parts.append(
            "<h2>Time over the fleet's median</h2>\n"
            f"<figure><figcaption>1 is the median</figcaption>\n{drawn}</figure>"
        )
    return frame("Health of the fleet", "\n".join(parts))


def _sentence(column: Column) -> str:
    head, _, rest = column.sentence().partition(": ")
    return f"<b>{escape(head)}</b>: {escape(rest)}"
