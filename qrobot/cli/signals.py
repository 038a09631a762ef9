"""Ctrl-C, a polite kill and a lost connection end the search, not the program."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from qrobot.backends import Stop

__all__ = ["stop_on_signals", "terminate_as_interrupt"]

HANGUP = getattr(signal, "SIGHUP", None)
"""Comes when the terminal or the SSH connection is gone; Windows has none."""


def _usual() -> dict[int, Any]:
    """Return the handlers of the signals that end a search.

    ``nohup`` ignores the hangup, and that stays. A shell's background jobs start with Ctrl-C
    ignored; `kill -INT` must still reach them.
    """
    found: dict[int, Any] = {
        number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)
    }
    if HANGUP is not None and (handler := signal.getsignal(HANGUP)) != signal.SIG_IGN:
        found[HANGUP] = handler
    return found


@contextmanager
def _handled(
    usual: dict[int, Any], handler: Callable[[int, FrameType | None], None]
) -> Iterator[None]:
    for number in usual:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, before in usual.items():
            signal.signal(number, before)


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Give a stop that the first SIGINT, SIGTERM or SIGHUP requests; a second one kills as usual.

    Except the hangup: the kernel, the shell and systemd each send one for the same lost
    connection.
    """
    stop = Stop()
    usual = _usual()

    def request(number: int, _frame: FrameType | None) -> None:
        if number != HANGUP:
            signal.signal(number, usual[number])
        stop.request()

    with _handled(usual, request):
        yield stop


@contextmanager
def terminate_as_interrupt() -> Iterator[Callable[[], bool]]:
    """Let a polite kill or a hangup raise `KeyboardInterrupt`, and Ctrl-C where it was ignored.

    Gives a function that says whether a signal came: Python swallows what is raised inside a
    weak reference's callback, so loops ask it between their rounds.
    """
    came = False

    def interrupt(number: int, _frame: FrameType | None) -> None:
        nonlocal came
        again, came = came, True
        if not (again and number == HANGUP):  # which comes more than once
            raise KeyboardInterrupt

    with _handled(_usual(), interrupt):
        yield lambda: came
