"""Where in a JSON text a value stands: asked for when there is an error to tell, not before."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["find_path", "find_repeated", "find_token"]

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


def find_path(text: str, path: str) -> str | None:
    """Return line and column of a value, or of the innermost one around it.

    Parameters
    ----------
    text
        JSON.
    path
        Such as ``items[3].at.slot``.
    """
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
