"""Drift as a table for the terminal and as one page that needs nothing but itself."""

from __future__ import annotations

from html import escape
from typing import Any

from qrobot.health.reports import Table
from qrobot.health.reports.page import frame, html_table
from qrobot.health.reports.table import count

__all__ = ["page", "table"]

HEADS = ("robot", "state", "profile", "release in use", "packages", "differs", "notes")
# Words that the pages of this house colour.
BADGE = {"same": "good", "drift": "fault", "unreachable": "absent"}


def page(document: dict[str, Any]) -> str:
    """Return the page: what is the matter, a table of the robots, then all of it."""
    parts = [
        "<h1>Drift of the fleet</h1>",
        f'<p class="soft"><time datetime="{escape(document["made"])}">{_when(document)} UTC</time>'
        f", held against qRobot {escape(document['version'])}</p>",
        f'<p class="verdict">{escape(headline(document))}</p>',
    ]
    lines = [(robot["name"], line) for robot in document["robots"] for line in sentences(robot)]
    if lines:
        items = "\n".join(f"<li><b>{escape(name)}</b> {escape(line)}</li>" for name, line in lines)
        parts.append(f'<h2>What is the matter</h2>\n<ul class="notes">\n{items}\n</ul>')
    rows = tuple((row[0], BADGE[row[1]], *row[2:]) for row in _rows(document))
    robots = Table("Robots", HEADS, rows, frozenset({4, 5, 6}), 1)
    parts += ["<h2>Robots</h2>", html_table(robots)]
    if document["differences"]:
        parts += ["<h2>Not the same everywhere</h2>", html_table(_differences(document))]
    for robot in document["robots"]:
        if rows := _packages(robot):
            head = ("package", "", "on the robot", "in the lock")
            parts.append(f"<h2>Packages of {escape(robot['name'])}</h2>")
            parts.append(html_table(Table(f"Packages of {robot['name']}", head, rows)))
    return frame("Drift of the fleet", "\n".join(parts))


def table(document: dict[str, Any]) -> str:
    """Return the same for a terminal; the last line is the summary."""
    rows = [HEADS, *_rows(document)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
    for robot in document["robots"]:
        lines += [f"{robot['name']}: {line}" for line in sentences(robot)]
    return "\n".join([*lines, headline(document)])


def headline(document: dict[str, Any]) -> str:
    totals = document["totals"]
    words = {"same": "without drift", "drift": "with drift", "unreachable": "did not answer"}
    told = ", ".join(f"{totals[state]} {word}" for state, word in words.items() if totals[state])
    return f"{count(len(document['robots']), 'robot')}: {told or 'none'}"


def sentences(robot: dict[str, Any]) -> list[str]:
    """Return what is the matter with a robot, drift first, one sentence each."""
    if robot["state"] == "unreachable":
        return [f"did not answer: {robot['why'] or 'no reason was given'}"]
    lines = list(robot["drift"])
    for odd in robot["differs"]:
        who = "of the fleet" if odd["among"] == "all" else f"of the profile {odd['among']}"
        most = f"most {who} have {odd['majority']}" if odd["majority"] else f"no majority {who}"
        lines.append(f"{odd['kind']} {odd['name']}: {odd['has']}, {most}")
    return lines + robot["notes"]


def _when(document: dict[str, Any]) -> str:
    return str(document["made"])[:16].replace("T", " ")


def _rows(document: dict[str, Any]) -> list[tuple[str, ...]]:
    rows = []
    for robot in document["robots"]:
        answered = robot["state"] != "unreachable"
        counts = (sum(map(len, robot["packages"].values())), len(robot["differs"]))
        numbers = [str(number) if answered else "-" for number in (*counts, len(robot["notes"]))]
        release = robot["release"]["in_use"] or "-"
        rows.append((robot["name"], robot["state"], robot["profile"] or "-", release, *numbers))
    return rows


def _differences(document: dict[str, Any]) -> Table:
    rows = []
    for one in document["differences"]:
        others = "; ".join(f"{value} on {', '.join(on)}" for value, on in one["different"].items())
        rows.append(
            (one["name"], one["kind"], one["among"], one["majority"] or "no majority", others)
        )
    return Table(
        "Not the same everywhere", ("what", "kind", "among", "most have", "others"), tuple(rows)
    )


def _packages(robot: dict[str, Any]) -> tuple[tuple[str, ...], ...]:
    found = robot["packages"]
    rows = [(name, "missing", "-", version) for name, version in found["missing"].items()]
    rows += [(name, "extra", version, "-") for name, version in found["extra"].items()]
    rows += [(n, "other version", both["has"], both["lock"]) for n, both in found["other"].items()]
    return tuple(sorted(rows))
