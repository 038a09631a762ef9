"""JSON text in and out, with every digit kept.

The standard reader takes ``NaN``, repeated keys and the last of two values without a word,
and turns ``0.1`` into a binary float. This one refuses the former and keeps the digits;
the writer puts one record on a line, so that people can read and compare files.
"""

from __future__ import annotations

import json
import math
from decimal import Decimal
from typing import Any

from qrobot.errors import InputError
from qrobot.problem.formats.positions import find_repeated, find_token

__all__ = ["dumps", "loads"]

_WIDTH = 96
_EXACT_DIGITS = 15
"""A binary float brings back any decimal of so many digits."""


def loads(text: str) -> Any:
    """Return the data of a JSON text; long decimals come as `Decimal`.

    Raises
    ------
    InputError
        When the text is not strict JSON, with line and column.
    """

    def number(token: str) -> float | Decimal:
        if len(token) <= _EXACT_DIGITS and "e" not in token.lower():
            return float(token)
        try:
            return Decimal(token)
        except ArithmeticError:
            raise InputError(
                f"{token:.40} is not a finite number",
                field=find_token(text, token),
                advice="correct it",
            ) from None

    def constant(token: str) -> float:
        raise InputError(
            f"{token} is not a number in JSON",
            field=find_token(text, token),
            advice="use a plain number",
        )

    def fields(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise InputError(
                f"the field {twice!r:.60} is given twice",
                field=find_repeated(text, twice),
                advice="keep one of them",
            )
        return found

    try:
        return json.loads(
            text,
            parse_float=number,
            parse_int=_int,
            parse_constant=constant,
            object_pairs_hook=fields,
        )
    except json.JSONDecodeError as error:
        raise InputError(
            f"broken JSON in line {error.lineno}, column {error.colno} ({error.msg.lower()})",
            advice="correct it there",
        ) from None
    except RecursionError:
        raise InputError("broken JSON (nested too deeply)", advice="flatten it") from None


def _int(text: str) -> int | Decimal:
    return int(text) if len(text) <= 40 else Decimal(text)


def dumps(data: Any) -> str:
    """Return data as JSON text, short records on one line each."""
    return _text(data, 0) + "\n"


def _text(data: Any, indent: int) -> str:
    if not (isinstance(data, dict) or (isinstance(data, list) and _nested(data))):
        return _flat(data)
    if indent and _short(data) and len(flat := _flat(data)) + indent <= _WIDTH:
        return flat
    pad = " " * (indent + 2)
    if isinstance(data, dict):
        lines = [f"{pad}{_flat(k)}: {_text(v, indent + 2)}" for k, v in data.items()]
        return "{\n" + ",\n".join(lines) + f"\n{' ' * indent}}}"
    lines = [pad + _text(v, indent + 2) for v in data]
    return "[\n" + ",\n".join(lines) + f"\n{' ' * indent}]"


def _nested(data: list[Any]) -> bool:
    return any(isinstance(value, dict | list) for value in data)


def _short(data: Any) -> bool:
    """Whether the data may fit on a line; tells a large matrix without writing it."""
    if not isinstance(data, dict | list):
        return True
    values = data.values() if isinstance(data, dict) else data
    return len(data) <= _WIDTH // 3 and all(map(_short, values))


def _flat(data: Any) -> str:
    if isinstance(data, dict):
        return "{" + ", ".join(f"{_flat(k)}: {_flat(v)}" for k, v in data.items()) + "}"
    if isinstance(data, list):
        return "[" + ", ".join(map(_flat, data)) + "]"
    if isinstance(data, Decimal):
        return format(data, "f")
    if isinstance(data, float):
        if not math.isfinite(data):
            raise ValueError(f"{data!r} is not a number of JSON")
        return str(int(data)) if data.is_integer() and abs(data) < 1e15 else repr(data)
    return json.dumps(data, ensure_ascii=False)
