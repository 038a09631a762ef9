"""Ctrl-C while `solve` works: keep the best plan instead of losing it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from qrobot.backends import Stop

__all__ = ["graceful_interrupts"]


@contextmanager
def graceful_interrupts(stop: Stop) -> Iterator[None]:
    """Turn the first Ctrl-C into a request to stop; the second interrupts as usual.

    Only in the main thread, and only where the caller has not set a handler of its own.
    """
    usual = signal.default_int_handler
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not usual
    ):
        yield
        return

    def on_interrupt(_number: int, _frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, usual)
        stop.request()

    signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
