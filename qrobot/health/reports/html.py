"""A report as one page: what needs attention first, then charts, then all of it."""

from __future__ import annotations

from html import escape

from qrobot.health.model import Report
from qrobot.health.reports.charts import Bar, bars
from qrobot.health.reports.compare import Comparison
from qrobot.health.reports.page import frame, html_table, mark
from qrobot.health.reports.table import (
    attention,
    checks_table,
    machine_line,
    system_table,
    totals_line,
    when,
)

__all__ = ["html"]


def html(report: Report, comparison: Comparison | None = None) -> str:
    """Return the page.

    Parameters
    ----------
    report
        What was found.
    comparison
        With an earlier report, to be shown beside it.
    """
    parts = [
        f"<h1>Health of {escape(report.host)}</h1>",
        f'<p class="soft">{escape(machine_line(report))}</p>',
        f'<p class="soft"><time datetime="{escape(report.made)}">{when(report)} UTC</time>, '
        f"qRobot {escape(report.qrobot)}, {report.seconds:.0f} s, {escape(_asked(report))}</p>",
        f'<p class="verdict">{mark("healthy" if report.healthy else "unhealthy")} '
        f"{escape(totals_line(report))}</p>",
        _attention(report),
    ]
    if comparison is not None:
        parts.append(f"<h2>Drift</h2>\n<p>{escape(comparison.headline())}</p>")
        if comparison.changes:
            parts.append(html_table(comparison.table()))
    if report.checks:
        parts += ["<h2>Time and memory</h2>", _charts(report), "<h2>Checks</h2>"]
        parts.append(html_table(checks_table(report)))
    if report.system:
        parts += ["<h2>Machine</h2>", html_table(system_table(report))]
    if report.versions:
        versions = ", ".join(f"{name} {number}" for name, number in report.versions.items())
        parts.append(f"<h2>Versions</h2>\n<p>{escape(versions)}</p>")
    return frame(f"Health of {report.host}", "\n".join(parts))


def _asked(report: Report) -> str:
    what = "the checks that were named" if report.profile == "named" else report.profile
    return f"checks: {what}" + (", none may be absent" if report.required else "")


def _attention(report: Report) -> str:
    findings, checks = attention(report)
    bad = {"fault", "fail", "error"}
    rows: list[tuple[str, str, str]] = [(f.status, f.title, f.message) for f in findings]
    rows += [(check.status, check.name, check.message) for check in checks]
    if not rows:
        return ""
    rows.sort(key=lambda row: row[0] not in bad)
    items = "\n".join(
        f"<li>{mark(status)} <b>{escape(name)}</b> {escape(message)}</li>"
        for status, name, message in rows
    )
    return f'<h2>Needs attention</h2>\n<ul class="notes">\n{items}\n</ul>'


def _charts(report: Report) -> str:
    times, memory = [], []
    for check in report.checks:
        if check.import_seconds is not None:
            parts = (check.import_seconds, check.run_seconds or 0.0)
            took = sum(parts)
            times.append(Bar(check.name, parts, f"{took:.2f}" if took < 100 else f"{took:.0f}"))
        if check.peak_mb is not None:
            memory.append(Bar(check.name, (check.peak_mb,), f"{check.peak_mb:.0f}"))
    figures = []
    if times:
        drawn = bars("times", "Seconds of every check", times, ("import", "computation"))
        figures.append(f"<figure><figcaption>Seconds</figcaption>\n{drawn}</figure>")
    if memory:
        drawn = bars("memory", "Peak memory of every check in MB", memory)
        figures.append(f"<figure><figcaption>Peak memory, MB</figcaption>\n{drawn}</figure>")
    return f'<div class="charts">\n{"".join(figures)}\n</div>' if figures else "<p>None ran.</p>"
