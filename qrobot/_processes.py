"""Processes that qRobot starts, how they end, and what a signal does.

A Python of ours finds the same modules as this one. It is started with ``-P``: a file
``numpy.py`` in the current folder, which may be a mounted one, is not numpy.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import psutil

__all__ = [
    "catch_signals",
    "child_environment",
    "end_family",
    "end_group",
    "end_with_parent",
    "name_signal",
    "python_command",
    "resident_memory",
]

PARENT = "QROBOT_PARENT"
"""The variable that tells a process of ours who started it."""

PR_SET_PDEATHSIG = 1
"""From linux/prctl.h."""

HANGUP = getattr(signal, "SIGHUP", None)
"""Comes when the terminal or the SSH connection is gone; Windows has none."""


def python_command(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module in a Python like this one."""
    return [sys.executable, "-P", "-m", module, *arguments]


def child_environment(seen: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the variables for a Python of ours: it imports what we can, and speaks UTF-8.

    The current folder is not in its path, unless it was named.
    """
    paths = [os.path.abspath(path) for path in sys.path if path]
    return {
        **seen,
        "PYTHONPATH": os.pathsep.join([*paths, str(Path(__file__).resolve().parents[1])]),
        "PYTHONIOENCODING": "utf-8",
        PARENT: str(os.getpid()),
    }


def end_with_parent() -> None:
    """Let this process be killed when the one that started it is gone, however that went.

    Linux kills it when the starting *thread* ends, so that thread must wait for it. Where the
    kernel cannot, as under some emulators, the parent is looked at twice a second.
    """
    parent = int(os.environ.get(PARENT) or os.getppid())
    asked = False
    with suppress(ImportError, OSError, AttributeError):
        import ctypes

        if sys.platform == "linux":
            asked = ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL) == 0
    if os.getppid() != parent:  # it ended before it could be asked for
        os._exit(1)
    if not asked:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def end_group(leader: int | None) -> None:
    """Kill a process that leads a session, and all in its group; None is nobody."""
    if leader is not None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, signal.SIGKILL)


def end_family(leader: int | None, variable: str, value: str) -> None:
    """Kill a session, and what it started and sent into sessions of their own.

    Parameters
    ----------
    leader
        Its first process, a child of ours that is waited for elsewhere; None when there is none.
    variable, value
        What the environment of all of them has.
    """
    import psutil

    end_group(leader)
    for _ in range(3):  # what is born while we look is found by looking again
        left = [
            process
            for process in psutil.process_iter()
            if process.pid != leader and _variables(process).get(variable) == value
        ]
        for process in left:
            with suppress(psutil.Error, OSError):
                process.kill()
        psutil.wait_procs(left, timeout=1)
        if not left:
            break


def _variables(process: psutil.Process) -> dict[str, str]:
    import psutil

    with suppress(psutil.Error, OSError):  # it is gone, foreign, or oddly emulated
        return process.environ()
    return {}


def resident_memory(leader: int | None) -> float:
    """Return the resident memory of a process and its children in MiB, 0 where there is none."""
    import psutil

    total = 0
    with suppress(psutil.Error, OSError):
        family = [] if leader is None else [psutil.Process(leader)]
        family += [child for process in family for child in process.children(recursive=True)]
        for member in family:
            with suppress(psutil.Error, OSError):
                total += member.memory_info().rss
    return total / 2**20


def name_signal(number: int) -> str:
    """Return ``SIGKILL`` for 9, and ``signal 35`` for one without a name."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


@contextmanager
def catch_signals(
    handle: Callable[[int], None],
    *names: str,
    second: Literal["handle", "restore", "ignore"] = "handle",
) -> Iterator[None]:
    """Call a function with the number of each signal that comes; then all is as it was.

    A signal that was ignored stays ignored, as a hangup by ``nohup``. Ctrl-C does not: a shell
    starts its background jobs with it ignored, and ``kill -INT`` must still reach them.

    Parameters
    ----------
    handle
        Called in the main thread, between two steps of the interpreter.
    names
        Such as ``SIGTERM``; one that the system does not have is left out.
    second
        What the same signal does when it comes again: it is handled again, it does what it did
        before, or it and all others are ignored. A hangup is never restored: the kernel, the
        shell and systemd each send one for the same lost connection.
    """
    usual: dict[int, Any] = {}
    for number in (getattr(signal, name) for name in names if hasattr(signal, name)):
        before = signal.getsignal(number)
        if before != signal.SIG_IGN or number == signal.SIGINT:
            usual[number] = before

    def come(number: int, _frame: FrameType | None) -> None:
        if second == "ignore":
            for other in usual:
                signal.signal(other, signal.SIG_IGN)
        elif second == "restore" and number != HANGUP:
            signal.signal(number, usual[number])
        handle(number)

    for number in usual:
        signal.signal(number, come)
    try:
        yield
    finally:
        for number, before in usual.items():
            signal.signal(number, before)
