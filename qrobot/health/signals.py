"""A polite kill ends the checks too, as Ctrl-C does: nothing that they started lives on."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["exit_on_signals"]


@contextmanager
def exit_on_signals() -> Iterator[None]:
    """Let SIGTERM (systemd, docker, timeout) and SIGHUP (a closed ssh) raise `SystemExit`.

    The code is the shell's, 128 and the number. Tidying up takes seconds, so a second signal
    changes nothing until it is done. What was ignored before, as SIGHUP by ``nohup``, stays so.
    """
    usual = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    ours = [number for number, handler in usual.items() if handler != signal.SIG_IGN]

    def leave(number: int, _frame: FrameType | None) -> None:
        for other in ours:
            signal.signal(other, signal.SIG_IGN)
        sys.exit(128 + number)

    for number in ours:
        signal.signal(number, leave)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, usual[number])
