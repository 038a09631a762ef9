"""Which file formats exist, and what each of them can.

A format of ours is one file that ends in ``FORMAT = Format(...)``, and one line in `BUILTIN`.
Third parties add theirs by an entry point in the group ``qrobot.formats`` whose value is a
`Format`, or for one process by `register`.
"""

from __future__ import annotations

import importlib
import importlib.metadata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath
from qrobot.errors import InputError
from qrobot.problem.instance import Instance

__all__ = ["BUILTIN", "GROUP", "Format", "ReadOptions", "format_of", "register", "suffixes"]

GROUP = "qrobot.formats"

BUILTIN = {
    ".json": "qrobot.problem.formats.native",
    ".csv": "qrobot.problem.formats.csvs",
    ".vrp": "qrobot.problem.formats.vrp",
}
"""The modules of our formats, by suffix: a file is imported when a file of its kind is met."""


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """What `qrobot.read` was asked for beside the path; see there."""

    layout: StrPath | None = None
    robots_follow: bool = False
    """Whether the number of robots is set afterwards, so that the file need not tell it."""
    capacity: Fraction | None = None
    rounding: str | None = None
    ignore_columns: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class Format:
    """A kind of file that holds an instance.

    Parameters
    ----------
    name
        For people.
    suffix
        Of its files, lower case, with the dot.
    read
        Returns the instance of a file, or raises `InputError` with the place of the fault.
    write
        Returns the text of an instance; ``None`` when such files are only read.
    options
        Those of `qrobot.read` that mean something for it, of ``layout``, ``ignore_columns`` and
        ``rounding``; the others are refused.
    """

    name: str
    suffix: str
    read: Callable[[Path, ReadOptions], Instance]
    write: Callable[[Instance], str] | None = None
    options: frozenset[str] = frozenset()


_registered: dict[str, Format] = {}


def register(format_: Format) -> None:
    """Add a format to this process.

    Raises
    ------
    InputError
        When its suffix cannot be one, or is taken.
    """
    suffix = format_.suffix
    if not suffix.startswith(".") or suffix != suffix.lower() or len(suffix) < 2:
        raise InputError(
            f"{suffix!r} is not a suffix", field="suffix", advice="give it as '.xml', lower case"
        )
    if suffix in suffixes():
        raise InputError(
            f"{suffix} files have a format already", field="suffix", advice="use another suffix"
        )
    _registered[suffix] = format_


def _plugins() -> dict[str, importlib.metadata.EntryPoint]:
    return {f".{entry.name}": entry for entry in importlib.metadata.entry_points(group=GROUP)}


def suffixes() -> list[str]:
    """Return the suffixes of all files that can be read, ours first."""
    return list(dict.fromkeys([*BUILTIN, *_registered, *sorted(_plugins())]))


def format_of(suffix: str) -> Format | None:
    """Return the format of files with a suffix (lower case), or ``None``."""
    if suffix in BUILTIN:
        found: Format = importlib.import_module(BUILTIN[suffix]).FORMAT
        return found
    if suffix in _registered:
        return _registered[suffix]
    plugin = _plugins().get(suffix)
    return None if plugin is None else plugin.load()
