"""No secret in any text that leaves the package.

Three sieves: the values of credentials that this process can see (variables and the SDKs'
own files), the shapes of well-known tokens, and whatever follows a telling name such as
``token=``. Fetching too much is harmless, fetching too little is not.
"""

from __future__ import annotations

import base64
import logging
import os
import re
import urllib.parse
from collections.abc import Iterator
from typing import Any

__all__ = ["MASK", "SECRET_VARIABLE", "mask_logs", "redact", "redact_data", "register_secret"]

MASK = "[redacted]"

SHORTEST = 6
"""Shorter values are not looked for: they would mask ordinary words."""

_NAME = (
    r"(?:token|secret|passw(?:or)?d|api[-_]?key|access[-_]?key(?:[-_]?id)?|credential|signature)"
)

SECRET_VARIABLE = re.compile(rf"(?i){_NAME}|_PAT$|DWAVE_API_(?:HEADERS|PROXY)")
_PLAIN_VARIABLE = re.compile(r"(?i)(?:_FILE|_PATH|_DIR|_URL|_ENDPOINT|_SCHEME)$")

_SHAPES = (
    re.compile(r"\b[A-Za-z]{2,6}-[0-9a-fA-F]{32,}\b"),  # D-Wave Leap
    re.compile(r"\b(?:AKIA|ASIA)[0-9A-Z]{12,}\b"),  # AWS access key
    re.compile(r"\beyJ[\w-]{8,}\.[\w-]{8,}(?:\.[\w-]*)?"),  # JSON web token
    re.compile(r"(?<=://)[^/\s@]+(?=@)"),  # user:password in an address
    re.compile(r"(?i)(?<=bearer )[\w.~+/=-]{6,}"),
)
_NAMED = re.compile(
    rf"(?i)((?:x-auth-token|authorization|x-amz-security-token|[\w-]*{_NAME})"
    r"""["']?(?:\s*[:=]\s*["']?|\s+(?:is\s+)?["']?(?=\S*\d))"""
    r"""(?:(?:apikey|basic|bearer|token|digest)\s+)?)([^\s"',;&)}}\]]{6,})"""
)

_registered: set[str] = set()


def register_secret(value: str | None) -> None:
    """Remember a value that must never be shown."""
    if value and len(value) >= SHORTEST:
        _registered.add(value)


def _known() -> Iterator[str]:
    yield from _registered
    for name, value in os.environ.items():
        if SECRET_VARIABLE.search(name) and not _PLAIN_VARIABLE.search(name):
            yield value
    from qrobot.jobs.credentials import secrets_in_files

    yield from secrets_in_files()


def _spellings(value: str) -> Iterator[str]:
    """Yield the ways in which a value may be written."""
    yield value
    yield urllib.parse.quote(value, safe="")
    yield urllib.parse.quote_plus(value)
    yield repr(value)[1:-1]
    yield base64.b64encode(value.encode()).decode().rstrip("=")


class _Sieve:
    """All that must not pass, gathered once for a text or a whole tree of data."""

    def __init__(self) -> None:
        spellings = {
            spelling
            for value in _known()
            if len(value) >= SHORTEST
            for spelling in _spellings(value)
        }
        self.spellings = sorted(spellings, key=len, reverse=True)

    def values(self, text: str) -> str:
        """Return a text without the values that are known."""
        for spelling in self.spellings:
            text = text.replace(spelling, MASK)
        return text

    def text(self, text: str) -> str:
        """Return a text with every secret masked."""
        text = self.values(text)
        for shape in _SHAPES:
            text = shape.sub(MASK, text)
        return _NAMED.sub(lambda found: found[1] + MASK, text)

    def data(self, data: Any) -> Any:
        """Return plain data with every secret masked in its texts."""
        if isinstance(data, str):
            return self.text(data)
        if isinstance(data, dict):
            return {self.data(key): self.data(value) for key, value in data.items()}
        if isinstance(data, list | tuple):
            return [self.data(value) for value in data]
        return data


def redact(text: object, *, guess: bool = True) -> str:
    """Return a text with every secret masked.

    Parameters
    ----------
    text
        A text, or anything whose ``str()`` is one, such as an exception.
    guess
        Mask what looks like a secret as well; False for ids that must stay as they are, of
        which only the known values of credentials are masked.
    """
    return _Sieve().text(str(text)) if guess else _Sieve().values(str(text))


def redact_data(data: Any) -> Any:
    """Return plain data with every secret masked in its texts; tuples become lists.

    A value under a telling key, such as ``{"token": "..."}``, is found by its value when it
    is a credential of this process.
    """
    return _Sieve().data(data)


class _Masking(logging.Filter):
    """Masks the secrets of a record; it never drops one."""

    def filter(self, record: logging.LogRecord) -> bool:
        record.msg, record.args = redact(record.getMessage()), ()
        return True


_MASKING = _Masking()


def mask_logs(*names: str) -> None:
    """Mask secrets in what loggers of an SDK say, such as the errors that they give up on."""
    for name in names:
        logging.getLogger(name).addFilter(_MASKING)  # once, however often this is called
