"""Runs the notebooks of `healthchecks/`, each in a kernel of its own, and keeps what they showed.

The sources are jupytext's percent scripts; the last cell of each is the check's verdict.
"""

from __future__ import annotations

import importlib
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from qrobot._extras import is_installed, missing
from qrobot._files import StrPath, write_text_atomic
from qrobot.errors import InputError
from qrobot.health.check import Check, difference
from qrobot.health.lesson import VERDICT
from qrobot.health.model import CheckResult, Status
from qrobot.health.runner import ROOT, Limits, run

if TYPE_CHECKING:
    from qrobot.health.kernel import Session

__all__ = ["FOLDERS", "TOOLS", "prepare", "run_notebook", "run_notebooks", "source_of"]

FOLDERS = (ROOT / "qrobot" / "healthchecks", ROOT / "healthchecks")
"""Where the sources may be: in an installed wheel, in a checkout."""

TOOLS = ("ipykernel", "jupytext", "nbclient", "nbformat")
"""What converts and executes a notebook; all of it is in the extra ``lab``."""


def source_of(check: Check) -> Path:
    """Return the source of a check's notebook.

    Its name begins with ``check_``: a file ``numpy.py`` would hide numpy from all that is
    started in its folder.

    Raises
    ------
    InputError
        When there is none.
    """
    name = f"check_{check.module.rpartition('.')[2]}.py"
    for folder in FOLDERS:
        if (folder / name).is_file():
            return folder / name
    raise InputError(
        f"there is no notebook {name}",
        field="--notebooks",
        advice="run it in a checkout, or install the wheel again",
    )


def prepare(folder: StrPath, checks: Sequence[Check] = ()) -> None:
    """Make sure that notebooks can be run and kept, before the first of them takes its time.

    Raises
    ------
    MissingExtraError
        When the notebook tools are not installed.
    InputError
        When the folder cannot be made, nothing can be written into it, or one of the checks has
        no notebook.
    """
    if not all(map(is_installed, TOOLS)):
        raise missing("--notebooks", "jupytext")
    for check in checks:
        source_of(check)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{folder} cannot be written ({error.strerror or type(error).__name__})",
            field="--notebooks",
            advice="name a folder of your own",
        ) from None


def run_notebook(check: Check, folder: StrPath, limits: Limits | None = None) -> CheckResult:
    """Run the notebook of one check; whatever it does, the result says so.

    The executed copy is kept as ``FOLDER/NAME.ipynb``, with the error in it when a cell failed.
    The notebook of a stack that is not installed is not run.

    Parameters
    ----------
    check
        Whose notebook to run.
    folder
        Where to keep the executed copy; it is made when it is not there.
    limits
        Of time and memory; by default 300 s and 2 GiB, for the whole notebook.

    Returns
    -------
    CheckResult
        As `run` gives it. The times are those of the check inside the notebook;
        `import_seconds` is None, for the cells before have imported the stack.

    Raises
    ------
    MissingExtraError
        When the notebook tools are not installed.
    InputError
        When there is no such notebook, or its copy cannot be written.
    """
    prepare(folder, [check])
    result, trouble = _run(check, Path(folder), limits or Limits())
    if trouble is not None:
        raise trouble
    return result


def run_notebooks(
    checks: Sequence[Check],
    folder: StrPath,
    limits: Limits | None = None,
    *,
    progress: Callable[[Check], object] | None = None,
) -> tuple[list[CheckResult], list[InputError]]:
    """Run the notebooks of checks, one by one; a copy that cannot be written costs no other.

    Parameters
    ----------
    checks, folder, limits
        As `run_notebook` takes them.
    progress
        Called with each check as its notebook begins.

    Returns
    -------
    results
        One a check, in their sequence: also of those whose copy could not be written.
    troubles
        One for each copy that could not be written.

    Raises
    ------
    MissingExtraError
        When the notebook tools are not installed.
    InputError
        When a notebook is not there, or the folder cannot be written, before any is run.
    """
    prepare(folder, checks)
    results, troubles = [], []
    for check in checks:
        if progress is not None:
            progress(check)
        result, trouble = _run(check, Path(folder), limits or Limits())
        results.append(result)
        if trouble is not None:
            troubles.append(trouble)
    return results, troubles


def _run(check: Check, folder: Path, limits: Limits) -> tuple[CheckResult, InputError | None]:
    """Return what the notebook showed, and why its copy could not be written."""
    if set(check.distributions) - set(check.versions()):
        return run(check), None  # which sees the same and says how to install it
    from qrobot.health.kernel import Session

    notebook: Any = importlib.import_module("jupytext").read(source_of(check), fmt="py:percent")
    session = Session(notebook, limits)
    try:
        session.run()
    except OSError as error:  # no temporary folder, as on a full disk
        session.problem = f"its kernel cannot be started: {error.strerror or error}"
    target = folder / f"{check.name}.ipynb"
    trouble: InputError | None = None
    see = f"; see {target}"
    try:
        write_text_atomic(target, importlib.import_module("nbformat").writes(notebook) + "\n")
    except InputError as error:
        trouble, see = error, ""
    return _judge(check, notebook, session, see), trouble


def _judge(check: Check, notebook: Any, session: Session, see: str) -> CheckResult:
    from qrobot.jobs.redaction import redact

    told = _verdict(check, notebook)
    answer, expected = (tuple(map(float, told.get(key, ()))) for key in ("answer", "expected"))
    wrong = difference(answer, expected, check.tolerance)
    status: Status = "pass"
    message = check.source
    if told and wrong:
        status, message = "fail", f"{wrong}{see}"
    elif session.problem or not told:
        status, message = "error", f"{session.problem or 'it gave no verdict'}{see}"
    return CheckResult(
        name=check.name,
        title=check.title,
        group=check.group,
        status=status,
        versions=check.versions(),
        import_seconds=None,
        run_seconds=told.get("run_seconds"),
        peak_mb=session.peak or None,
        answer=answer if told else None,
        expected=expected if told else None,
        tolerance=check.tolerance,
        message=redact(message),
    )


def _verdict(check: Check, notebook: Any) -> dict[str, Any]:
    """Return the numbers of the last verdict on this check, or nothing."""
    found: dict[str, Any] = {}
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            data = output.get("data", {}).get(VERDICT)
            if data and data.get("check") == check.name:
                found = dict(data)
    return found
