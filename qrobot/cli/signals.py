"""Ctrl-C, a polite kill and a lost connection end the work, not the program."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from qrobot._processes import catch_signals

if TYPE_CHECKING:
    from qrobot.backends import Stop

__all__ = ["exit_on_signals", "stop_on_signals", "terminate_as_interrupt"]


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Give a stop that the first SIGINT, SIGTERM or SIGHUP requests; the next kills as usual."""
    from qrobot.backends import Stop

    stop = Stop()
    with catch_signals(lambda _: stop.request(), "SIGINT", "SIGTERM", "SIGHUP", second="restore"):
        yield stop


@contextmanager
def terminate_as_interrupt() -> Iterator[Callable[[], bool]]:
    """Let a polite kill or a hangup raise `KeyboardInterrupt`, and Ctrl-C where it was ignored.

    Gives a function that says whether a signal came: Python swallows what is raised inside a
    weak reference's callback, so loops ask it between their rounds.
    """
    came = False

    def interrupt(number: int) -> None:
        nonlocal came
        again, came = came, True
        if not (again and number == signal.SIGHUP):  # which comes more than once
            raise KeyboardInterrupt

    with catch_signals(interrupt, "SIGINT", "SIGTERM", "SIGHUP"):
        yield lambda: came


@contextmanager
def exit_on_signals() -> Iterator[None]:
    """Let SIGTERM (systemd, docker, timeout) and SIGHUP (a closed ssh) raise `SystemExit`.

    The code is the shell's, 128 and the number. Tidying up takes seconds, so a second signal
    changes nothing until it is done.
    """

    def leave(number: int) -> None:
        sys.exit(128 + number)

    with catch_signals(leave, "SIGTERM", "SIGHUP", second="ignore"):
        yield
