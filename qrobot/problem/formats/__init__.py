"""Readers and writers, one file a format.

`read` tells the format by the file's extension: ``.json`` native, ``.csv`` orders with a
layout beside them, ``.vrp`` CVRPLIB and QOBLIB. `write` writes native JSON.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from pathlib import Path

from qrobot._files import StrPath, path_text, write_text_atomic
from qrobot.errors import InputError
from qrobot.problem.instance import Instance
from qrobot.problem.shipped import example_path
from qrobot.problem.units import Quantity, exact

__all__ = ["instance_of", "read", "write"]


def read(
    path: StrPath,
    *,
    layout: StrPath | None = None,
    robots: int | str | None = None,
    capacity: Quantity | None = None,
    split_orders: bool = False,
    rounding: str | None = None,
    ignore_columns: Sequence[str] = (),
) -> Instance:
    """Return the instance of a file, whatever its format.

    Parameters
    ----------
    path
        A ``.json``, ``.csv`` or ``.vrp`` file, or ``example`` (``example:NAME``) for one that
        comes with qRobot.
    layout
        The layout of CSV orders; by default ``<stem>.layout.json`` or ``layout.json``
        beside them.
    robots
        Another number of robots (see `Instance.with_robots`), or ``"free"`` for no limit.
    capacity
        Another capacity of every robot.
    split_orders
        Let each item stand alone, as in the paper's formulas.
    rounding
        Of the distances of a ``.vrp`` file: ``none``, ``nearest``, ``up`` or ``down`` in the
        place of what its EDGE_WEIGHT_TYPE demands.
    ignore_columns
        Columns of CSV orders that are not ours, such as notes.

    Returns
    -------
    Instance
        Checked: every item can be reached, and the weights have a common unit.

    Raises
    ------
    InputError
        One sentence with file, field, value and mend.
    """
    path = example_path(path_text(path)) or path
    try:
        instance = _read_file(path, layout, robots, capacity, rounding, ignore_columns)
    except InputError as error:
        raise error.in_file(os.fspath(path)) from None
    return instance.split_orders() if split_orders else instance


def _read_file(
    path: StrPath,
    layout: StrPath | None,
    robots: int | str | None,
    capacity: Quantity | None,
    rounding: str | None,
    ignore_columns: Sequence[str],
) -> Instance:
    count = _count(robots)
    size = None if capacity is None else exact(capacity, field="capacity")
    if size is not None and size <= 0:
        raise InputError(f"{capacity} is not positive", field="capacity", mend="give more than 0")
    suffix = Path(path).suffix.lower()
    if layout is not None and suffix != ".csv":
        raise InputError("a layout belongs to CSV orders", mend="leave it out, or give a .csv")
    if ignore_columns and suffix != ".csv":
        raise InputError(
            "columns belong to CSV orders", field="ignore_columns", mend="leave it out"
        )
    _check_rounding(rounding, suffix)
    if suffix == ".json":
        from qrobot.problem.formats.native import read_native

        instance = read_native(path)
    elif suffix == ".csv":
        from qrobot.problem.formats.csvs import read_csv

        instance = read_csv(path, layout, ignore_columns)
    elif suffix == ".vrp":
        from qrobot.problem.formats.vrp import read_vrp

        instance = read_vrp(
            path, robots_follow=robots is not None, capacity=size, rounding=rounding
        )
    else:
        raise _unknown(path)
    if size is not None:
        fleet = tuple(dataclasses.replace(r, capacity=size) for r in instance.robots)
        instance = dataclasses.replace(instance, robots=fleet)
    return instance if robots is None else instance.with_robots(count)


def _check_rounding(rounding: str | None, suffix: str) -> None:
    if rounding is None:
        return
    if suffix != ".vrp":
        raise InputError(
            "rounding belongs to .vrp files",
            field="rounding",
            mend="leave it out (a floor in native JSON has a field for it)",
        )
    from qrobot.problem.formats.weights import ROUNDINGS

    if rounding not in ROUNDINGS:
        raise InputError(
            f"{rounding!r:.40} is not a rounding",
            field="rounding",
            mend=f"use one of {', '.join(ROUNDINGS)}",
        )


def _count(robots: int | str | None) -> int | None:
    if robots is None or robots == "free":
        return None
    if isinstance(robots, bool) or not isinstance(robots, int):
        raise InputError(
            f"{robots!r} is not a number of robots",
            field="robots",
            mend="give a whole number above 0, or 'free'",
        )
    return robots


def _unknown(path: StrPath) -> InputError:
    target = Path(path)
    try:
        if target.is_dir():
            return InputError("is a folder", mend="give the path of a file")
        if not target.exists():
            return InputError("does not exist", mend="check the path")
    except (OSError, ValueError) as error:
        return InputError(f"cannot be read ({error})", mend="check the path")
    shown = target.suffix or "no extension"
    return InputError(f"unsupported format ({shown})", mend="give a .json, .csv or .vrp file")


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
        mend="give what qrobot.read returns, or the path of a file that it reads",
    )


def write(instance: Instance | StrPath, path: StrPath) -> None:
    """Write an instance as native JSON, whole or not at all.

    An instance with split orders is written as what it asks: every item its own order.

    Raises
    ------
    InputError
        When the file cannot be written, or a weight has no finite decimal.
    """
    from qrobot.problem.formats.native_writer import to_text

    write_text_atomic(path, to_text(instance_of(instance)))
