"""Readers and writers, one file a format; `registry` knows them by the suffix of their files."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from qrobot._files import StrPath, path_text, write_text_atomic
from qrobot._formats import is_beside
from qrobot.errors import InputError
from qrobot.problem.fleets import with_trips
from qrobot.problem.formats.registry import (
    Format,
    ReadOptions,
    format_of,
    formats_of,
    register,
    suffixes,
)
from qrobot.problem.instance import Instance
from qrobot.problem.units import Quantity, exact

__all__ = ["Format", "ReadOptions", "instance_of", "read", "register", "suffixes", "write"]


_EXAMPLES = (
    Path(__file__).resolve().parents[2] / "examples",  # in an installed package
    Path(__file__).resolve().parents[3] / "examples",  # in a checkout
)

_FOREIGN = {
    # option: (field, problem, advice), where a file's format does not know it
    "layout": (None, "a layout belongs to CSV orders", "leave it out, or give a .csv"),
    "ignore_columns": ("ignore_columns", "columns belong to CSV orders", "leave it out"),
    "columns": ("columns", "columns belong to CSV orders", "leave it out"),
    "locations": (None, "a location table belongs to CSV orders", "leave it out, or give a .csv"),
    "articles": (None, "an article master belongs to CSV orders", "leave it out, or give a .csv"),
    "sheet": ("sheet", "sheets belong to workbooks", "leave it out, or give an .xlsx"),
    "rounding": (
        "rounding",
        "rounding belongs to .vrp files",
        "leave it out (a floor in native JSON has a field for it)",
    ),
}


def read(
    path: StrPath,
    *,
    layout: StrPath | None = None,
    robots: int | str | None = None,
    capacity: Quantity | None = None,
    trips: int | str | None = None,
    split_orders: bool = False,
    rounding: str | None = None,
    ignore_columns: Sequence[str] = (),
    columns: Mapping[str, str | Sequence[str]] | None = None,
    locations: StrPath | None = None,
    articles: StrPath | None = None,
    sheet: str | None = None,
    pool: bool = False,
) -> Instance:
    """Return the instance of a file, whatever its format.

    Parameters
    ----------
    path
        A file whose suffix tells its format, one of `suffixes`, or ``example``
        (``example:NAME``) for one that comes with qRobot.
    layout
        The layout of CSV orders; by default ``<stem>.layout.json`` or ``layout.json``
        beside them.
    robots
        Another number of robots (see `Instance.with_robots`), or ``"free"`` for no limit.
    capacity
        Another capacity of every robot.
    trips
        The most trips of every robot in the place of the file's, or ``"free"`` for no limit.
    split_orders
        Let each item stand alone, as in the paper's formulas.
    rounding
        Of the distances of a ``.vrp`` file: ``none``, ``nearest``, ``up`` or ``down`` in the
        place of what its EDGE_WEIGHT_TYPE demands.
    ignore_columns
        Columns of CSV orders that are not ours, such as notes; ``*``: all that are not known.
    columns
        What a table calls our columns, such as ``{"order": "OrderNo"}``, in all its files.
    locations, articles
        The location table and the article master of CSV orders; by default
        ``<stem>.locations.csv`` or ``locations.csv`` (or ``.xlsx``) beside them, or the sheet of
        that name in their workbook.
    sheet
        The sheet of a workbook that has the orders, where there are several.
    pool
        Orders for `qrobot.planning.waves`: native JSON and CSV may hold more than one plan does,
        and no distances are made.

    Returns
    -------
    Instance
        Checked: every item can be reached, and the weights have a common unit.

    Raises
    ------
    InputError
        One sentence with file, field, value and advice.
    """
    path = example_path(path_text(path)) or path
    try:
        options = ReadOptions(
            layout=layout,
            robots_follow=robots is not None,
            capacity=None if capacity is None else exact(capacity, field="capacity"),
            rounding=rounding,
            ignore_columns=ignore_columns,
            columns=columns or {},
            locations=locations,
            articles=articles,
            sheet=sheet,
            pool=pool,
        )
        instance = _read_file(path, options, robots)
        if trips is not None:
            instance = dataclasses.replace(instance, robots=with_trips(instance.robots, trips))
    except InputError as error:
        raise error.in_file(os.fspath(path)) from None
    return instance.split_orders() if split_orders else instance


def _read_file(path: StrPath, options: ReadOptions, robots: int | str | None) -> Instance:
    size = options.capacity
    if size is not None and size <= 0:
        raise InputError(f"{size} is not positive", field="capacity", advice="give more than 0")
    format_ = format_of(Path(path))
    for name, (field, problem, advice) in _FOREIGN.items():
        if getattr(options, name) and name not in (format_.options if format_ else ()):
            raise InputError(problem, field=field, advice=advice)
    if format_ is None:
        raise _unknown(path)
    instance = format_.read(Path(path), options)
    if size is not None:
        fleet = tuple(dataclasses.replace(r, capacity=size) for r in instance.robots)
        instance = dataclasses.replace(instance, robots=fleet)
    if robots is None:
        return instance
    count = None if robots == "free" else robots
    return instance.with_robots(cast("int | None", count))  # which looks at it


def _unknown(path: StrPath) -> InputError:
    target = Path(path)
    try:
        if target.is_dir():
            return InputError("is a folder", advice="give the path of a file")
        if not target.exists():
            return InputError("does not exist", advice="check the path")
    except (OSError, ValueError) as error:
        return InputError(f"cannot be read ({error})", advice="check the path")
    if found := formats_of(target.suffix.lower()):
        names = " or ".join(format_.name for format_ in found)
        return InputError(f"is not a {names} file", advice="check the path, or correct its header")
    shown = target.suffix or "no extension"
    *others, last = suffixes()
    return InputError(
        f"unsupported format ({shown})", advice=f"give a {', '.join(others)} or {last} file"
    )


def example_path(path: StrPath) -> Path | None:
    """Return the file of ``example`` or ``example:NAME``, None when that is not meant.

    A file that has this name comes first.
    """
    text = os.fspath(path)
    if os.path.lexists(text):
        return None
    if text == "example":
        name = "small-warehouse"
    elif text.startswith("example:"):
        name = text.removeprefix("example:")
    else:
        return None
    found = {
        file.stem: file
        for place in _EXAMPLES
        for file in sorted(place.glob("*"))
        if file.suffix in suffixes() and not is_beside(file.name)
    }
    if name not in found:
        raise InputError(
            "there is no such example",
            source=text,
            advice="use one of " + ", ".join(f"example:{known}" for known in sorted(found)),
        )
    return found[name]


def instance_of(question: Instance | StrPath) -> Instance:
    """Return an instance as it is, or the one of a file.

    Raises
    ------
    InputError
        When it is neither, or the file cannot be read.
    """
    if isinstance(question, Instance):
        return question
    if isinstance(question, str | os.PathLike):
        return read(question)
    raise InputError(
        f"an object of class {type(question).__name__} is not an instance",
        advice="give what qrobot.read returns, or the path of a file that it reads",
    )


def write(instance: Instance | StrPath, path: StrPath) -> None:
    """Write an instance, whole or not at all; native JSON unless the suffix says another format.

    An instance with split orders is written as what it asks: every item its own order.

    Raises
    ------
    InputError
        When files of that suffix are only read, the file cannot be written, or a weight has no
        finite decimal.
    """
    suffix = Path(path_text(path)).suffix.lower()
    named = formats_of(suffix) or formats_of(".json")
    writers = [format_.write for format_ in named if format_.write is not None]
    if not writers:
        raise InputError(
            f"{suffix} files are only read", source=os.fspath(path), advice="give a .json file"
        )
    write_text_atomic(path, writers[0](instance_of(instance)))
