"""Ctrl-C while `solve` works: keep the best plan instead of losing it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from qrobot._processes import catch_signals
from qrobot.backends import Stop

__all__ = ["graceful_interrupts"]


@contextmanager
def graceful_interrupts(stop: Stop) -> Iterator[None]:
    """Turn the first Ctrl-C into a request to stop; the second interrupts as usual.

    Only in the main thread, and only where the caller has not set a handler of its own.
    """
    if (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ):
        with catch_signals(lambda _: stop.request(), "SIGINT", second="restore"):
            yield
    else:
        yield
