"""Ctrl-C and a polite kill end the search, not the program."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from qrobot.backends import Stop

__all__ = ["stop_on_signals", "terminate_as_interrupt"]


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Give a stop that the first SIGINT or SIGTERM requests; a second one kills as usual."""
    stop = Stop()
    usual = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def request(number: int, _frame: FrameType | None) -> None:
        signal.signal(number, usual[signal.Signals(number)])
        stop.request()

    for number in usual:
        signal.signal(number, request)
    try:
        yield stop
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)


@contextmanager
def terminate_as_interrupt() -> Iterator[Callable[[], bool]]:
    """Let a polite kill raise `KeyboardInterrupt`, and Ctrl-C where it was ignored too.

    Gives a function that says whether a signal came: Python swallows what is raised inside a
    weak reference's callback, so loops ask it between their rounds.
    """
    came = False

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        nonlocal came
        came = True
        raise KeyboardInterrupt

    # A shell's background jobs start with Ctrl-C ignored; `kill -INT` must still reach them.
    usual = {n: signal.signal(n, interrupt) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: came
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
