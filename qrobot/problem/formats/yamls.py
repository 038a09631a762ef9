"""YAML of other programs: read whole, its fields taken one by one with the place of a fault."""

from __future__ import annotations

import math
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

from qrobot._extras import load
from qrobot._files import read_text
from qrobot.errors import InputError
from qrobot.problem.formats.fields import shown

__all__ = ["listed", "mapping", "number", "read_yaml", "whole"]


def read_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping of a YAML file.

    Raises
    ------
    InputError
        When it is not YAML, or something else than a mapping.
    MissingExtraError
        When no reader of YAML is installed.
    """
    yaml = load("yaml", f"reading {path.name}")
    text = read_text(path)
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = None if mark is None else f"line {mark.line + 1}, column {mark.column + 1}"
        problem = getattr(error, "problem", None) or "cannot be read"
        raise InputError(f"broken YAML ({problem})", field=where, advice="correct it") from None
    except (ValueError, RecursionError) as error:  # a date that is none, lists in lists
        raise InputError(f"broken YAML ({error})", advice="correct it") from None
    return mapping(data, "")


def mapping(data: Any, field: str) -> dict[str, Any]:
    """Return a mapping, its keys as text."""
    if not isinstance(data, Mapping):
        raise InputError(
            f"is {shown(data)}, not a mapping", field=field or None, advice="check the file"
        )
    return {str(key): value for key, value in data.items()}


def listed(data: Any, field: str, least: int = 0) -> list[Any]:
    """Return a list of at least so many entries."""
    if not isinstance(data, list) or len(data) < least:
        wanted = f"a list of at least {least}" if least else "a list"
        raise InputError(f"is not {wanted}", field=field, advice="check the file")
    return data


def number(data: Any, field: str) -> float:
    """Return a finite number; YAML takes some for text, such as ``5e-2``."""
    try:
        if isinstance(data, bool) or not isinstance(data, int | float | Decimal | str):
            raise ValueError
        value = float(data)
        if not math.isfinite(value):
            raise ValueError
    except (ValueError, OverflowError):
        raise InputError(
            f"{shown(data)} is not a number", field=field, advice="give a plain number"
        ) from None
    return value


def whole(data: Any, field: str) -> int:
    """Return a whole number from 0."""
    value = number(data, field)
    if value != int(value) or value < 0:
        raise InputError(f"{shown(data)} is not a whole number", field=field, advice="count from 0")
    return int(value)
