"""Which file formats exist, what each of them can, and which one a file has.

A format of ours is one file that ends in ``FORMAT = builtin(...)``, and one line in `BUILTIN` of
`qrobot/_formats.py`. Third parties add theirs by an entry point in the group ``qrobot.formats``
whose value is a `Format`, or for one process by `register`.
"""

from __future__ import annotations

import codecs
import dataclasses
import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from qrobot._files import StrPath
from qrobot._formats import BUILTIN, plugins
from qrobot.errors import InputError
from qrobot.problem.instance import Instance

__all__ = [
    "Format",
    "ReadOptions",
    "builtin",
    "checked",
    "format_of",
    "formats_of",
    "register",
    "suffixes",
]

_BEGINNING = 4_096
"""Bytes of a file that tell its format."""


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """What `qrobot.read` was asked for beside the path; see there."""

    layout: StrPath | None = None
    robots_follow: bool = False
    """Whether the number of robots is set afterwards, so that the file need not tell it."""
    capacity: Fraction | None = None
    rounding: str | None = None
    ignore_columns: Sequence[str] = ()
    columns: Mapping[str, str | Sequence[str]] = dataclasses.field(default_factory=dict)
    locations: StrPath | None = None
    articles: StrPath | None = None
    sheet: str | None = None
    pool: bool = False
    """Whether the instance may be larger than one plan; see `Instance.pool`."""


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
        Those of `qrobot.read` that mean something for it, of ``layout``, ``locations``,
        ``articles``, ``columns``, ``ignore_columns``, ``sheet`` and ``rounding``; the others are
        refused.
    recognise
        Tells from the first lines of a file whether it has this format. Formats that have it
        may share a suffix; ``None``: the suffix alone tells.
    """

    name: str
    suffix: str
    read: Callable[[Path, ReadOptions], Instance]
    write: Callable[[Instance], str] | None = None
    options: frozenset[str] = frozenset()
    recognise: Callable[[str], bool] | None = None


def builtin(
    module: str,
    read: Callable[[Path, ReadOptions], Instance],
    write: Callable[[Instance], str] | None = None,
    recognise: Callable[[str], bool] | None = None,
) -> Format:
    """Return the format of one of our modules, as the table `BUILTIN` describes it."""
    ((suffix, known),) = ((s, k) for s, all_ in BUILTIN.items() for k in all_ if k.module == module)
    return Format(known.name, suffix, read, write, frozenset(known.options), recognise)


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


def suffixes() -> list[str]:
    """Return the suffixes of all files that can be read, ours first."""
    return list(dict.fromkeys([*BUILTIN, *_registered, *sorted(plugins())]))


def formats_of(suffix: str) -> list[Format]:
    """Return the formats that files with a suffix (lower case) may have."""
    if suffix in BUILTIN:
        return [importlib.import_module(known.module).FORMAT for known in BUILTIN[suffix]]
    if suffix in _registered:
        return [_registered[suffix]]
    plugin = plugins().get(suffix)
    return [] if plugin is None else [plugin.load()]


def format_of(path: Path) -> Format | None:
    """Return the format of a file, by its suffix and its first lines; ``None`` for no known one.

    Raises
    ------
    InputError
        When the first lines are those of a format with another suffix.
    """
    suffix, start = path.suffix.lower(), _beginning(path)
    named = formats_of(suffix)
    for format_ in named:
        if format_.recognise is not None and format_.recognise(start):
            return format_
    for other in [s for s in (*BUILTIN, *_registered) if s != suffix and start]:
        for format_ in formats_of(other):
            if format_.recognise is not None and format_.recognise(start):
                raise InputError(
                    f"holds the format {format_.name}, which {suffix or 'no suffix'} does not say",
                    advice=f"name it {path.stem}{other}",
                )
    return next((format_ for format_ in named if format_.recognise is None), None)


def _beginning(path: Path) -> str:
    """Return the first lines of a file, empty where there are none to be read."""
    try:
        if not path.is_file():  # opening a pipe would wait
            return ""
        with path.open("rb") as file:
            return file.read(_BEGINNING).removeprefix(codecs.BOM_UTF8).decode("latin-1")
    except (OSError, ValueError):
        return ""  # reading it will tell why


def checked(make: Callable[[], Instance], where: Callable[[str], str]) -> Instance:
    """Return what `make` makes, with all that can be wrong with it found out and told by place."""
    try:
        instance = make()
        _ = instance.unit
        if not instance.pool:
            _ = instance.place_distances
    except InputError as error:
        raise error.at(where(error.field) if error.field else None) from None
    return instance
