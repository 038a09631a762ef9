"""A check's process under watch: its time, its memory, what it tells, and its end."""

from __future__ import annotations

import json
import math
import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Any

from qrobot._processes import end_family, python_command, resident_memory
from qrobot.errors import InputError
from qrobot.health.check import Check
from qrobot.health.place import environment

__all__ = ["MARK", "Limits", "Process"]

POLL = 0.02
"""Seconds between two looks at what the process tells."""

SHARE = 20
"""Its memory is looked at so much more seldom than a look takes: it costs a Pi, and more so an
emulated one, and would take the processor from what is looked at."""

PAUSE = 1.0
"""Seconds between two looks at the memory at most: so late is its limit noticed."""

MARK = "QROBOT_HEALTH_CHECK"
"""A variable that a check's children inherit, by which they are found wherever they went."""

VMSTAT = Path("/proc/vmstat")
"""Where Linux counts the processes that it killed for want of memory."""


@dataclass(frozen=True)
class Limits:
    """What one check may take: wall-clock seconds, and MiB of resident memory.

    The memory is watched, not limited by the kernel: an address space limit would refuse the
    large reservations that numba, OpenBLAS and Rust make and never use.
    """

    seconds: float = 300.0
    megabytes: float = 2048.0

    def __post_init__(self) -> None:
        """Refuse what would be no limit: nothing is above ``nan``."""
        for field in ("seconds", "megabytes"):
            if not 0 < (value := getattr(self, field)) < math.inf:
                raise InputError(
                    f"{value} is no limit", field=field, mend="give a finite number above 0"
                )


class Process:
    """A process under watch, and what it told before its end.

    Parameters
    ----------
    check
        What to run; its `module` is imported anew in there.
    limits
        Of time and memory; its children's memory counts.
    folder
        Its own, which it runs in.

    Attributes
    ----------
    told
        What it told so far.
    peak
        Largest resident memory that was seen, in MiB.
    overrun
        The limit that it broke, as a clause, or ``""``.
    starved
        Whether the machine killed processes for want of memory meanwhile.

    Raises
    ------
    OSError
        When it cannot be started.
    """

    def __init__(self, check: Check, limits: Limits, folder: Path) -> None:
        self.limits = limits
        self.told: dict[str, Any] = {}
        self.peak = 0.0
        self.overrun = ""
        self.starved = False
        self._noise = self._lines = b""
        self._mark = folder.name
        self._kills = _out_of_memory_kills()
        reader, writer = os.pipe()
        try:
            self.process = subprocess.Popen(
                python_command("qrobot.health.worker", check.module, str(writer)),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                pass_fds=[writer],
                cwd=folder,
                env=environment(folder) | {MARK: self._mark},
                start_new_session=True,
            )
        except BaseException:
            os.close(reader)
            raise
        finally:
            os.close(writer)
        self._reader = reader
        assert self.process.stderr is not None
        self._stderr = self.process.stderr.fileno()
        os.set_blocking(self._stderr, False)
        os.set_blocking(reader, False)

    def wait(self, stop: Event) -> int:
        """Watch until the end or a stop, return the exit code; nothing of it is left behind."""
        begun = due = time.monotonic()
        try:
            while self.process.poll() is None and not stop.is_set():
                self._drain()
                self._listen()
                if (look := time.monotonic()) >= due:
                    self.peak = max(self.peak, resident_memory(self.process.pid))
                    now = time.monotonic()
                    due = now + min(SHARE * (now - look), PAUSE)
                if self.peak > self.limits.megabytes:
                    self.overrun = f"took more than {self.limits.megabytes:g} MB of memory"
                elif time.monotonic() - begun > self.limits.seconds:
                    self.overrun = f"took longer than {self.limits.seconds:g} s"
                if self.overrun:
                    break
                time.sleep(POLL)
        finally:
            end_family(self.process.pid, MARK, self._mark)
            code = self.process.wait()
            self.starved = _out_of_memory_kills() > self._kills
            self._drain()
            self._listen()
            assert self.process.stderr is not None
            self.process.stderr.close()
            os.close(self._reader)
        return code

    def last_words(self) -> str:
        """Return the last line of the standard error stream."""
        lines = self._noise.decode(errors="replace").strip().splitlines()
        return lines[-1].strip()[:500] if lines else ""

    def _drain(self) -> None:
        for chunk in _waiting(self._stderr):
            self._noise = (self._noise + chunk)[-4096:]

    def _listen(self) -> None:
        self._lines += b"".join(_waiting(self._reader))
        *whole, self._lines = self._lines.split(b"\n")
        for line in whole:
            with suppress(ValueError):
                told = json.loads(line)
                if "answer" in told:  # as texts: JSON has no word for a number that is not one
                    told["answer"] = [float(number) for number in told["answer"]]
                self.told |= told


def _waiting(pipe: int) -> Iterator[bytes]:
    """Give what is in a pipe; not without end, or who writes without end is never stopped."""
    with suppress(BlockingIOError):
        for _ in range(64):
            chunk = os.read(pipe, 65536)
            if not chunk:
                return
            yield chunk


def _out_of_memory_kills() -> int:
    with suppress(OSError, ValueError):
        for line in VMSTAT.read_text().splitlines():
            if line.startswith("oom_kill "):
                return int(line.split()[1])
    return 0
