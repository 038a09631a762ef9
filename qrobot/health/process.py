"""A check's process: the folder and the environment that it runs in, its limits, and its end.

A check must run in a container whose file system is read-only and whose user has no home, must
not be led astray by somebody's matplotlibrc or IPython start-up files, and leaves nothing
behind. Caches that outlive it (numba's machine code) are left where they are, if that place
takes files.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Any

from qrobot._files import can_take_files
from qrobot._processes import child_environment, end_family, python_command, resident_memory
from qrobot.errors import InputError
from qrobot.health.check import Check

__all__ = ["MARK", "ROOT", "Limits", "Process", "environment", "own_folder"]

ROOT = Path(__file__).resolve().parents[2]
"""The folder that holds qRobot."""

CLOUDS = ("AWS_", "DWAVE_", "QISKIT_IBM")
"""Beginnings of variables that a check has no business to know: none of them asks a cloud."""

OWN = (
    "IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR",
)  # fmt: skip
"""Variables that name folders of settings and sockets."""

CACHES = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
"""Variables that name folders that are worth keeping."""


@contextmanager
def own_folder() -> Iterator[Path]:
    """Give a temporary folder, and delete it with all that is in it.

    Raises
    ------
    OSError
        When no folder can be made.
    """
    folder = Path(tempfile.mkdtemp(prefix="qrobot-health-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def environment(folder: Path, seen: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the variables for a check that runs in a folder.

    Parameters
    ----------
    folder
        Its own; what the user did not choose otherwise points into it.
    seen
        The variables to begin with.
    """
    found = child_environment({n: value for n, value in seen.items() if not _is_secret(n)})
    found["TMPDIR"] = str(folder)  # which is in the user's own
    found["PYTHONWARNINGS"] = "ignore"  # what an SDK thinks of its own parts
    caches = Path(found.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    for name in OWN if can_take_files(caches) else (*OWN, *CACHES):
        found.setdefault(name, str(folder / name.lower()))
    return found


def _is_secret(variable: str) -> bool:
    """Return whether a variable may hold a credential; a proxy's address may have a password."""
    from qrobot.jobs.redaction import SECRET_VARIABLE  # here: the other processes need it not

    name = variable.upper()
    return name.startswith(CLOUDS) or name.endswith("_PROXY") or bool(SECRET_VARIABLE.search(name))


POLL = 0.02
"""Seconds between two looks at what the process writes."""

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
                    f"{value} is not a limit", field=field, advice="give a finite number above 0"
                )

    def broken(self, seconds: float, megabytes: float) -> str:
        """Return which limit a process broke, as a clause, or ``""``."""
        if megabytes > self.megabytes:
            return f"took more than {self.megabytes:g} MB of memory"
        return f"took longer than {self.seconds:g} s" if seconds > self.seconds else ""


class Process:
    """A process under watch, and how far it came.

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
    progress
        What it has written to its pipe so far: times, answer, error.
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
        self.progress: dict[str, Any] = {}
        self.peak = 0.0
        self.overrun = ""
        self.starved = False
        self._errors = self._lines = b""
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
                self._read_errors()
                self._read_progress()
                if (look := time.monotonic()) >= due:
                    self.peak = max(self.peak, resident_memory(self.process.pid))
                    now = time.monotonic()
                    due = now + min(SHARE * (now - look), PAUSE)
                self.overrun = self.limits.broken(time.monotonic() - begun, self.peak)
                if self.overrun:
                    break
                time.sleep(POLL)
        finally:
            end_family(self.process.pid, MARK, self._mark)
            code = self.process.wait()
            self.starved = _out_of_memory_kills() > self._kills
            self._read_errors()
            self._read_progress()
            assert self.process.stderr is not None
            self.process.stderr.close()
            os.close(self._reader)
        return code

    def last_error_line(self) -> str:
        """Return the last line of the standard error stream."""
        lines = self._errors.decode(errors="replace").strip().splitlines()
        return lines[-1].strip()[:500] if lines else ""

    def _read_errors(self) -> None:
        for chunk in _waiting(self._stderr):
            self._errors = (self._errors + chunk)[-4096:]

    def _read_progress(self) -> None:
        self._lines += b"".join(_waiting(self._reader))
        *lines, self._lines = self._lines.split(b"\n")
        for line in lines:
            with suppress(ValueError):
                step = json.loads(line)
                if "answer" in step:  # as texts: JSON has no word for a number that is not one
                    step["answer"] = [float(number) for number in step["answer"]]
                self.progress |= step


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
