"""Runs checks, each in a process of its own, with a limit of time and of memory."""

from __future__ import annotations

import signal
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack
from threading import Event
from typing import Any

from qrobot._extras import install_command
from qrobot._processes import name_signal
from qrobot.errors import InputError
from qrobot.health.check import Check, difference
from qrobot.health.model import CheckResult, Status
from qrobot.health.process import Limits, Process, own_folder

__all__ = ["result_of", "run", "run_all"]


def run(check: Check, limits: Limits | None = None) -> CheckResult:
    """Run one check; whatever it does, the result says so and the caller lives on.

    Parameters
    ----------
    check
        What to run; its `module` is imported anew in the other process.
    limits
        Of time and memory; by default 300 s and 2 GiB.
    """
    return _run(check, limits or Limits(), Event())


def run_all(
    checks: Sequence[Check],
    limits: Limits | None = None,
    *,
    jobs: int = 1,
    progress: Callable[[Check], object] | None = None,
) -> list[CheckResult]:
    """Run checks, several at once; Ctrl-C ends them all and is raised.

    Parameters
    ----------
    checks
        What to run.
    limits
        Of time and memory, for each; by default 300 s and 2 GiB.
    jobs
        How many processes at once. Times are longer when they share a core.
    progress
        Called in this thread with each check as it begins.

    Returns
    -------
    list of CheckResult
        In the sequence of the checks.

    Raises
    ------
    InputError
        When `jobs` is less than one.
    """
    if jobs < 1:
        raise InputError(f"cannot run {jobs} checks at once", field="jobs", advice="use 1 or more")
    stop = Event()
    limits = limits or Limits()
    begun: list[Future[CheckResult]] = []
    # A thread watches its process from birth to end: Linux tells a process of the death of the
    # thread that started it, which must not come early.
    with ThreadPoolExecutor(max_workers=jobs) as pool:
        try:
            for check in checks:
                running = [future for future in begun if not future.done()]
                if len(running) >= jobs:
                    wait(running, return_when=FIRST_COMPLETED)
                if progress is not None:
                    progress(check)
                begun.append(pool.submit(_run, check, limits, stop))
            return [future.result() for future in begun]
        except BaseException:
            stop.set()
            raise


def _run(check: Check, limits: Limits, stop: Event) -> CheckResult:
    missing = [name for name in check.distributions if name not in check.versions()]
    if missing:
        return result_of(check, "absent", _advice(check, missing))
    watched = _watch(check, limits, stop)
    if isinstance(watched, str):
        return result_of(check, "error", watched)
    process, code = watched
    found = process.progress
    found["peak_mb"] = max(process.peak, found.get("peak_mb", 0.0)) or None
    if "expected" in found and code == 0:
        wrong = difference(found["answer"], found["expected"], check.tolerance)
        return result_of(check, "fail" if wrong else "pass", wrong or check.source, found)
    return result_of(check, "error", _why(process, code), found)


def _watch(check: Check, limits: Limits, stop: Event) -> tuple[Process, int] | str:
    """Return the process at its end and its exit code, or why there was none."""
    with ExitStack() as stack:
        try:
            folder = stack.enter_context(own_folder())
        except OSError as error:
            return (
                f"no temporary folder can be made for it ({error.strerror or error}): make room, "
                "or set TMPDIR to a folder that takes files"
            )
        try:
            process = Process(check, limits, folder)
        except OSError as error:
            return f"no process can be started for it: {error.strerror or error}"
        return process, process.wait(stop)


def _why(process: Process, code: int) -> str:
    """Say why there is no answer."""
    steps = {"expected": "its end", "import_seconds": "its computation"}
    phase = next((name for key, name in steps.items() if key in process.progress), "its import")
    if process.overrun:
        return f"{phase} {process.overrun} and was stopped"
    starved = "the machine ran out of memory and killed processes" if process.starved else ""
    if error := process.progress.get("error"):
        return f"{phase} failed: {error}{starved and f'; {starved}'}"
    if code == -signal.SIGKILL:
        reason = starved or "perhaps the machine is out of memory"
        return f"{phase} was ended by SIGKILL ({reason})"
    if code < 0:
        return f"{phase} was ended by {name_signal(-code)}"
    words = process.last_error_line()
    return f"{phase} ended the process with code {code}{f': {words}' if words else ''}"


def _advice(check: Check, missing: Sequence[str]) -> str:
    what = f"{', '.join(missing)} not installed"
    return f"{what}: {install_command(check.extra)}" if check.extra else what


def result_of(
    check: Check, status: Status, message: str, found: Mapping[str, Any] | None = None
) -> CheckResult:
    """Return the result of a check.

    Parameters
    ----------
    check, status, message
        As in the result; secrets in the message are masked.
    found
        Those of the result's times, memory, answer and expected answer that are known.
    """
    from qrobot.jobs.redaction import redact  # here: the processes of the checks need it not

    known: dict[str, Any] = dict(found or {})
    answer, expected = known.get("answer"), known.get("expected")
    return CheckResult(
        name=check.name,
        title=check.title,
        group=check.group,
        status=status,
        versions=check.versions(),
        import_seconds=known.get("import_seconds"),
        run_seconds=known.get("run_seconds"),
        peak_mb=known.get("peak_mb"),
        answer=None if answer is None else tuple(answer),
        expected=None if expected is None else tuple(expected),
        tolerance=check.tolerance,
        message=redact(message),
    )
