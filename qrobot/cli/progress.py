"""Progress on the standard error stream while something works."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from qrobot._numbers import number
from qrobot.cli.streams import say
from qrobot.planning.run import Progress

__all__ = ["ProgressLine", "progress_line"]

LIVE, PLAIN = 0.2, 2.0
"""Seconds between updates on a terminal, and between lines without one."""


class ProgressLine:
    """The latest progress, shown by a thread of its own."""

    def __init__(self) -> None:
        self.latest: Progress | None = None
        self.begun = time.perf_counter()
        self.live = sys.stderr.isatty()
        self._wake = threading.Event()
        self._ended = False

    def __call__(self, progress: Progress) -> None:
        """Take the latest progress; the first plan is told at once."""
        first = progress.cost is not None and (self.latest is None or self.latest.cost is None)
        self.latest = progress
        if first:
            self._wake.set()

    def text(self) -> str:
        """Return the line to show."""
        clock = time.perf_counter() - self.begun
        if self.latest is None:
            return f"{clock:5.1f} s  starting"
        cost = (
            "no plan yet"
            if self.latest.cost is None
            else f"{self.latest.objective} {number(self.latest.cost)}"
        )
        bound = f", bound {number(self.latest.bound)}" if self.latest.bound > 0 else ""
        return f"{clock:5.1f} s  {self.latest.step}: {cost}{bound}"

    def show(self) -> None:
        """Show progress until `end`; the body of the thread."""
        while True:
            self._wake.wait(LIVE if self.live else PLAIN)
            if self._ended:
                return
            self._wake.clear()
            if self.live:
                say(f"\r\x1b[K{self.text()}", err=True, end="")
            else:
                say(self.text(), err=True)

    def end(self) -> None:
        """Stop showing and clear the line."""
        self._ended = True
        self._wake.set()


@contextmanager
def progress_line(quiet: bool) -> Iterator[ProgressLine | None]:
    """Show progress while the block runs, unless it shall be quiet."""
    if quiet:
        yield None
        return
    line = ProgressLine()
    thread = threading.Thread(target=line.show, daemon=True)
    thread.start()
    try:
        yield line
    finally:
        line.end()
        thread.join()
        if line.live:
            say("\r\x1b[K", err=True, end="")
