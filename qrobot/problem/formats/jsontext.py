"""JSON text in and out, with every digit kept.

The standard reader takes ``NaN``, repeated keys and the last of two values without a word,
and turns ``0.1`` into a binary float. This one refuses the former and keeps the digits;
the writer puts one record on a line, so that people can read and compare files. Where a value
stands in a text is looked for when there is an error to tell, not before.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from qrobot.errors import InputError

__all__ = ["dumps", "loads", "located"]

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


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+')
_PART = re.compile(r"\[(\d+)\]|([^.\[\]]+)")

LONGEST = 30_000_000
"""Texts with more letters are not searched: that would take longer than reading them."""

Part = str | int


@dataclass(frozen=True, slots=True)
class _Found:
    """A key or value: the path to it, where it begins, and its text."""

    path: tuple[Part, ...]
    at: int
    text: str
    key: bool = False


def _walk(text: str) -> Iterator[_Found]:
    """Yield every key and every value; of an object or list, its opening bracket."""
    path: list[Part | None] = []  # None: a key of this object is awaited
    for found in _TOKEN.finditer(text):
        word = found[0]
        if word in "}]":
            if path:
                path.pop()
        elif word == ",":
            if path and isinstance(last := path[-1], int):
                path[-1] = last + 1
            elif path:
                path[-1] = None
        elif word == ":":
            continue
        elif path and path[-1] is None and word[0] == '"':
            path[-1] = _unquoted(word)
            yield _Found(_parts(path), found.start(), word, key=True)
        else:
            yield _Found(_parts(path), found.start(), word)
            if word in "{[":
                path.append(None if word == "{" else 0)


def _parts(path: list[Part | None]) -> tuple[Part, ...]:
    return tuple(part for part in path if part is not None)


def _unquoted(word: str) -> str:
    try:
        return str(json.loads(word))
    except ValueError:
        return word


def _place(text: str, at: int) -> str:
    before = text[:at]
    return f"line {before.count(chr(10)) + 1}, column {at - before.rfind(chr(10))}"


@contextmanager
def located(text: str) -> Iterator[None]:
    """Let errors tell line and column of their field in a text."""
    try:
        yield
    except InputError as error:
        ours = error.source is None  # the field may be one of another file
        place = find_path(text, error.field) if error.field and ours else None
        raise error.at(f"{error.field}, {place}") if place else error from None


def find_path(text: str, path: str) -> str | None:
    """Return line and column of a value such as ``items[3].at.slot``, or of the one around it."""
    if len(text) > LONGEST:
        return None
    wanted = tuple(int(i) if i else name for i, name in _PART.findall(path))
    best, at = -1, 0
    for found in _walk(text):
        depth = len(found.path)
        if not found.key and depth > best and found.path == wanted[:depth]:
            best, at = depth, found.at
            if depth == len(wanted):
                break
    return _place(text, at) if best > 0 else None


def find_token(text: str, word: str) -> str:
    """Return line and column of the first number or word, such as ``NaN``, outside of texts."""
    return next((_place(text, f.at) for f in _walk(text) if f.text == word), "")


def find_repeated(text: str, key: str) -> str:
    """Return line and column of the first key of that name that its object has already."""
    seen: dict[tuple[Part, ...], int] = {}
    for found in _walk(text):
        if found.key and found.path[-1] == key:
            if found.path in seen:
                return _place(text, found.at)
            seen[found.path] = found.at
    return ""
