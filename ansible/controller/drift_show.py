"""Drift as a table for the terminal and as one page that needs nothing but itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from qrobot._text import Table, columns, count
from qrobot.pages import render

__all__ = ["page", "table"]

HEADS = ("robot", "state", "profile", "release in use", "packages", "differs", "notes")


def page(document: dict[str, Any]) -> str:
    """Return the page: what is the matter, a table of the robots, then all of it."""
    heads = ("package", "", "on the robot", "in the lock")
    return render(
        Path(__file__).with_name("drift.html"),
        document=document,
        when=str(document["made"])[:16].replace("T", " "),
        headline=headline(document),
        lines=[
            ("", robot["name"], line) for robot in document["robots"] for line in sentences(robot)
        ],
        robots=Table("Robots", HEADS, tuple(_rows(document)), frozenset({4, 5, 6}), 1),
        differences=_differences(document),
        packages=[
            Table(f"Packages of {robot['name']}", heads, rows)
            for robot in document["robots"]
            if (rows := _packages(robot))
        ],
    )


def table(document: dict[str, Any]) -> str:
    """Return the same for a terminal; the last line is the summary."""
    lines = [columns(HEADS, _rows(document), ruled=False)]
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
