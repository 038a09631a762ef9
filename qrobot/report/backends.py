"""The list of backends as rows and as a table."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from qrobot._extras import install_command
from qrobot._text import columns
from qrobot.backends import available, get, names, registry
from qrobot.errors import QRobotError

__all__ = ["backend_rows", "backend_table"]


def backend_rows() -> list[dict[str, Any]]:
    """Return what every known backend says about itself; absent ones say how to install."""
    rows: list[dict[str, Any]] = []
    for name in names():
        row: dict[str, Any] = {"name": name, "installed": available(name)}
        try:
            row |= asdict(get(name).capabilities)
            row["extra"] = row["extra"] or registry.extra_for(name)
        except (QRobotError, ImportError) as error:
            row |= {"installed": False, "problem": str(error), "extra": registry.extra_for(name)}
        rows.append(row)
    return rows


def backend_table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as aligned text."""
    heads = ["backend", "kind", "where", "installed", "repeatable", "proves", "whole orders"]
    lines = []
    for row in rows:
        if "kind" not in row:
            how = f": {install_command(row['extra'])}" if row.get("extra") else ""
            lines.append([row["name"], "-", "-", f"no{how}", "-", "-", "-"])
            continue
        lines.append(
            [
                row["name"],
                row["kind"],
                "local" if row["local"] else "remote",
                "yes" if row["installed"] else f"no: {install_command(row['extra'])}",
                "yes" if row["deterministic"] else "no",
                "yes" if row["proves"] else "no",
                "yes" if row["whole_orders"] else "no",
            ]
        )
    return columns(heads, lines)
