"""Which files hold instances, known without importing what reads them: help is shown at once."""

from __future__ import annotations

import importlib.metadata
from typing import NamedTuple

__all__ = [
    "BUILTIN",
    "MASTERS",
    "MASTER_SUFFIXES",
    "KnownFormat",
    "is_beside",
    "known_formats",
    "plugins",
]

GROUP = "qrobot.formats"


class KnownFormat(NamedTuple):
    """A format of ours: the module that has its ``FORMAT``, and what help says about it."""

    module: str
    name: str
    options: tuple[str, ...] = ()


TABLE = ("layout", "locations", "articles", "columns", "ignore_columns", "sheet")
"""Options of orders in a table."""

MASTERS = ("locations", "articles")
"""Tables that may lie beside orders; see `qrobot.problem.formats.masters`."""

MASTER_SUFFIXES = (".csv", ".xlsx")

BUILTIN = {
    ".json": (KnownFormat("qrobot.problem.formats.native", "native"),),
    ".csv": (
        KnownFormat(
            "qrobot.problem.formats.csvs",
            "orders with a layout beside them",
            TABLE,
        ),
    ),
    ".xlsx": (
        KnownFormat("qrobot.problem.formats.xlsx", "the same as the sheet of a workbook", TABLE),
    ),
    ".vrp": (KnownFormat("qrobot.problem.formats.vrp", "CVRPLIB and QOBLIB", ("rounding",)),),
    ".txt": (
        KnownFormat("qrobot.problem.formats.picking_hi", "HI"),
        KnownFormat("qrobot.problem.formats.picking_briant", "Briant"),
    ),
    ".ord": (KnownFormat("qrobot.problem.formats.picking_lorenci", "Lorenci", ("layout",)),),
}
"""By suffix; a module is imported when a file of its kind is met."""


def is_beside(name: str) -> bool:
    """Return whether a file of that name belongs to the orders beside it, and has none itself."""
    layouts = (
        "layout.json",
        "poses.csv",
        *(f"{kind}{end}" for kind in MASTERS for end in MASTER_SUFFIXES),
    )
    return name in layouts or name.endswith(tuple(f".{layout}" for layout in layouts))


def plugins() -> dict[str, importlib.metadata.EntryPoint]:
    """Return the formats of other packages, by suffix."""
    return {f".{entry.name}": entry for entry in importlib.metadata.entry_points(group=GROUP)}


def known_formats() -> list[tuple[str, str, tuple[str, ...]]]:
    """Return suffix, name and options of every format; of a plugin's its package is known."""
    ours = [(suffix, one.name, one.options) for suffix, known in BUILTIN.items() for one in known]
    theirs = [
        (suffix, f"of {entry.dist.name if entry.dist else entry.value}", ())
        for suffix, entry in sorted(plugins().items())
        if suffix not in BUILTIN
    ]
    return [*ours, *theirs]
