"""The standard streams as they come: closed, without a reader, full, or of any encoding.

`prepare` makes them safe once, so that no command has to think of it: whatever state they were
left in, a command does its work, writes its files and ends with the code of its work.
"""

from __future__ import annotations

import errno
import io
import os
import stat
import sys
from contextlib import suppress
from typing import Any

__all__ = ["prepare", "say", "say_json", "show"]

GONE = frozenset({errno.EPIPE, errno.ECONNRESET, errno.ESHUTDOWN})
"""Errors of a stream that nobody reads any more."""


def prepare() -> None:
    """Make the standard streams safe to write to, whatever the caller made of them.

    A closed one leads nowhere: its descriptor is taken, or the next file that is opened would
    get it, and whatever a library prints. Characters that an encoding has not are escaped.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # gets the lowest number
    if sys.stdin is None:
        sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115 - as long as the program
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif os.name == "posix" and stream is getattr(sys, f"__{name}__"):
            setattr(sys, name, _steady(stream, name))
        elif isinstance(stream, io.TextIOWrapper):  # of a program that calls us
            stream.reconfigure(errors="backslashreplace")


def say(text: str, *, err: bool = False, end: str = "\n") -> None:
    """Print a text at once, on the standard output or the error stream.

    Raises
    ------
    InputError
        When the standard output cannot take it, as on a full disk. A reader that went away is
        no error, and what the error stream cannot take is lost.
    """
    stream = sys.stderr if err else sys.stdout
    stream.write(text + end)
    stream.flush()


def say_json(data: Any) -> None:
    """Print plain data as JSON, with escapes where the encoding of the output lacks characters."""
    from qrobot._json import json_text

    text = json_text(data, indent=1, ensure_ascii=False)
    try:
        text.encode(sys.stdout.encoding or "ascii")
    except UnicodeEncodeError:
        text = json_text(data, indent=1)
    say(text)


def show(text: str, data: Any, as_json: bool) -> None:
    """Print a text for people, or the same as JSON."""
    if as_json:
        say_json(data)
    else:
        say(text)


class _Descriptor(io.FileIO):
    """A descriptor whose reader may go away; its first other error is reported, and only once.

    What comes after an error leads nowhere: a text that is still buffered must not raise again
    when Python ends, which would change the exit code.
    """

    def __init__(self, number: int, name: str) -> None:
        super().__init__(number, "w", closefd=False)
        self._title = f"standard {'output' if name == 'stdout' else 'error'}"
        self._reported = name == "stderr"  # where errors are reported
        self._dead = False

    def write(self, data: Any, /) -> int:
        """Write bytes, or drop them when nobody gets them."""
        if not self._dead:
            try:
                return super().write(data)
            except OSError as error:
                self._dead = True
                if not (self._reported or self._gone(error)):
                    from qrobot._files import refusal

                    self._reported = True
                    raise refusal("write", self._title, error) from None
        return memoryview(data).nbytes

    def _gone(self, error: OSError) -> bool:
        if error.errno == errno.EIO:  # a terminal that hung up; of a file it is a broken disk
            return stat.S_ISCHR(os.fstat(self.fileno()).st_mode)
        return error.errno in GONE


def _steady(stream: Any, name: str) -> Any:
    """Return a stream like another one of a descriptor, whose errors are tame."""
    try:
        number = stream.fileno()
        raw = _Descriptor(number, name)
        stream.flush()
    except (OSError, ValueError):
        return stream
    with suppress(OSError):  # Node and others leave it so, and a full pipe would be an error
        os.set_blocking(number, True)
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors="backslashreplace",
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
