"""Processes that tests start: waited for by what they do, never by a clock, and always ended.

A busy machine may take any time for anything. `HANG` only ends what will never come.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, AnyStr

import psutil

__all__ = ["HANG", "await_text", "children", "end", "gone", "until", "with_our_modules"]

HANG = 900.0
"""Seconds after which a thing hangs, however busy the machine is."""

LASTING = (
    "multiprocessing.resource_tracker", "multiprocessing.forkserver", "the process that forks",
)  # fmt: skip
"""Children that Python, or `started`, keeps for its whole life."""


def with_our_modules() -> dict[str, str]:
    """Return the environment of a process that imports these modules by their names."""
    here = Path(__file__).resolve().parent
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(here), str(here.parent)])}


def until(condition: Callable[[], object], what: str, *, patience: float = HANG) -> None:
    """Return as soon as a condition holds."""
    end_of_patience = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end_of_patience, f"it hangs: {what}"
        time.sleep(0.02)


def await_text(stream: IO[AnyStr] | None, text: AnyStr) -> AnyStr:
    """Read lines until one holds the text, and return that one."""
    assert stream is not None
    for line in stream:
        if text in line:
            return line
    raise AssertionError(f"the command ended before it said {text!r}")


def gone(pid: int) -> bool:
    """Return True when a process has ended, also one that nobody collects."""

    def ended() -> bool:
        try:
            return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
        except psutil.NoSuchProcess:
            return True

    until(ended, f"process {pid} goes on")
    return True


def children() -> set[psutil.Process]:
    """Return the living children of this process, but for those that Python itself keeps."""
    me = os.getpid()
    try:
        lists = [path.read_text() for path in Path(f"/proc/{me}/task").glob("*/children")]
    except OSError:  # a thread that ended meanwhile
        return children()
    found = set()
    for pid in map(int, " ".join(lists).split()):
        try:
            process = psutil.Process(pid)
            words = " ".join(process.cmdline())
            if process.status() != psutil.STATUS_ZOMBIE and not any(w in words for w in LASTING):
                found.add(process)
        except psutil.NoSuchProcess:
            continue
    return found


def end(processes: set[psutil.Process]) -> None:
    """Kill processes and all that they started."""
    for process in processes:
        try:
            family = [process, *process.children(recursive=True)]
        except psutil.NoSuchProcess:
            continue
        for member in family:
            try:
                member.kill()
            except psutil.NoSuchProcess:
                continue
    psutil.wait_procs(list(processes), timeout=HANG)
