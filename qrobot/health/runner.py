"""Runs a check in a process of its own, with a limit of time and of memory."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

from qrobot.health.check import Check, difference
from qrobot.health.model import CheckResult, Status

__all__ = ["Limits", "run"]

ROOT = Path(__file__).resolve().parents[2]
"""The folder that holds qRobot."""

POLL = 0.02
"""Seconds between two looks at the process."""

SECRET = ("AWS_", "DWAVE_", "QISKIT_IBM")
"""Beginnings of variables that a check has no business to know: none of them asks a cloud."""


@dataclass(frozen=True)
class Limits:
    """What one check may take: wall-clock seconds, and MiB of resident memory.

    The memory is watched, not limited by the kernel: an address space limit would refuse the
    large reservations that numba, OpenBLAS and Rust make and never use.
    """

    seconds: float = 300.0
    megabytes: float = 2048.0


class _Process:
    """A process under watch, and what it told before its end."""

    def __init__(self, check: Check, limits: Limits) -> None:
        self.limits = limits
        self.told: dict[str, Any] = {}
        self.peak = 0.0
        self.overrun = ""
        self._noise = self._lines = b""
        reader, writer = os.pipe()
        environment = {k: v for k, v in os.environ.items() if not k.startswith(SECRET)}
        # All that we can import, and ourselves, but not the current folder.
        environment["PYTHONPATH"] = os.pathsep.join([*filter(None, sys.path), str(ROOT)])
        # -P: a file numpy.py in the folder that somebody happens to be in is not numpy.
        command = [sys.executable, "-P", "-W", "ignore", "-m", "qrobot.health.worker"]
        try:
            self.process = subprocess.Popen(
                [*command, check.module, str(writer)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                pass_fds=[writer],
                env=environment,
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

    def wait(self) -> int:
        """Watch until the end, return the exit code; nothing of the process is left behind."""
        begun = time.monotonic()
        try:
            while self.process.poll() is None:
                self._drain()
                self._listen()
                self.peak = max(self.peak, self._memory())
                if self.peak > self.limits.megabytes:
                    self.overrun = f"took more than {self.limits.megabytes:g} MB of memory"
                elif time.monotonic() - begun > self.limits.seconds:
                    self.overrun = f"took longer than {self.limits.seconds:g} s"
                if self.overrun:
                    break
                time.sleep(POLL)
        finally:
            # The whole session: a check may have started processes, which outlive it.
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, signal.SIGKILL)
            code = self.process.wait()
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

    def _memory(self) -> float:
        total = 0
        with suppress(psutil.Error):
            family = psutil.Process(self.process.pid)
            for member in [family, *family.children(recursive=True)]:
                with suppress(psutil.Error):
                    total += member.memory_info().rss
        return total / 2**20

    def _drain(self) -> None:
        with suppress(BlockingIOError):
            while chunk := os.read(self._stderr, 65536):
                self._noise = (self._noise + chunk)[-4096:]

    def _listen(self) -> None:
        with suppress(BlockingIOError):
            while chunk := os.read(self._reader, 65536):
                self._lines += chunk
        *whole, self._lines = self._lines.split(b"\n")
        for line in whole:
            with suppress(ValueError):
                self.told |= json.loads(line)


def run(check: Check, limits: Limits | None = None) -> CheckResult:
    """Run one check; whatever it does, the result says so and the caller lives on.

    Parameters
    ----------
    check
        What to run; its `module` is imported anew in the other process.
    limits
        Of time and memory; by default 300 s and 2 GiB.
    """
    versions = check.versions()
    missing = [name for name in check.distributions if name not in versions]
    if missing:
        return _result(check, versions, "absent", _mend(check, missing))
    process = _Process(check, limits or Limits())
    code = process.wait()
    told = process.told
    told["peak_mb"] = max(process.peak, told.get("peak_mb", 0.0)) or None
    if "expected" in told and code == 0:
        wrong = difference(told["answer"], told["expected"], check.tolerance)
        return _result(check, versions, "fail" if wrong else "pass", wrong or check.source, told)
    return _result(check, versions, "error", _why(process, code), told)


def _why(process: _Process, code: int) -> str:
    """Say why there is no answer."""
    told = process.told
    steps = {"expected": "its end", "import_seconds": "its computation"}
    phase = next((name for key, name in steps.items() if key in told), "its import")
    if process.overrun:
        return f"{phase} {process.overrun} and was stopped"
    if "error" in told:
        return f"{phase} failed: {told['error']}"
    if code < 0:
        return f"{phase} was ended by {_signal(-code)}"
    words = process.last_words()
    return f"{phase} ended the process with code {code}{f': {words}' if words else ''}"


def _signal(number: int) -> str:
    try:
        name = signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
    hints = {"SIGKILL": " (perhaps the machine is out of memory)"}
    return name + hints.get(name, "")


def _mend(check: Check, missing: Sequence[str]) -> str:
    what = f"{', '.join(missing)} not installed"
    return f"{what}: pip install 'qrobot[{check.extra}]'" if check.extra else what


def _result(
    check: Check,
    versions: dict[str, str],
    status: Status,
    message: str,
    told: dict[str, Any] | None = None,
) -> CheckResult:
    from qrobot.remote.redaction import redact  # here: the processes of the checks need it not

    told = told or {}
    answer, expected = told.get("answer"), told.get("expected")
    return CheckResult(
        name=check.name,
        title=check.title,
        group=check.group,
        status=status,
        versions=versions,
        import_seconds=told.get("import_seconds"),
        run_seconds=told.get("run_seconds"),
        peak_mb=told.get("peak_mb"),
        answer=None if answer is None else tuple(answer),
        expected=None if expected is None else tuple(expected),
        tolerance=check.tolerance,
        message=redact(message),
    )
