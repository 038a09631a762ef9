"""Runs the notebooks of `healthchecks/`, each in a kernel of its own, and keeps what they showed.

The sources are jupytext's percent scripts; the last cell of each is the check's verdict.
"""

from __future__ import annotations

import importlib
import importlib.util
import tempfile
from pathlib import Path
from typing import Any

from qrobot._files import StrPath, write_text_atomic
from qrobot.errors import InputError, MissingExtraError
from qrobot.health.check import Check, difference
from qrobot.health.lesson import VERDICT
from qrobot.health.model import CheckResult, Status
from qrobot.health.runner import ROOT, Limits, run

__all__ = ["FOLDERS", "TOOLS", "prepare", "run_notebook", "source_of"]

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
        mend="run it in a checkout, or install the wheel again",
    )


def prepare(folder: StrPath) -> None:
    """Make sure that notebooks can be run and kept, before the first of them takes its time.

    Raises
    ------
    MissingExtraError
        When the notebook tools are not installed.
    InputError
        When the folder cannot be made, or nothing can be written into it.
    """
    if not all(importlib.util.find_spec(tool) for tool in TOOLS):
        raise MissingExtraError("--notebooks", "lab")
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{folder} cannot be written ({error.strerror or type(error).__name__})",
            field="--notebooks",
            mend="name a folder of your own",
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
    source = source_of(check)
    prepare(folder)
    if set(check.distributions) - set(check.versions()):
        return run(check)  # which sees the same and says how to install it
    from qrobot.health.kernel import Session

    notebook: Any = importlib.import_module("jupytext").read(source, fmt="py:percent")
    session = Session(notebook, limits or Limits())
    session.run()
    target = Path(folder) / f"{check.name}.ipynb"
    write_text_atomic(target, importlib.import_module("nbformat").writes(notebook) + "\n")
    return _judge(check, notebook, session.problem, session.peak, target)


def _judge(check: Check, notebook: Any, problem: str, peak: float, target: Path) -> CheckResult:
    from qrobot.remote.redaction import redact

    told = _verdict(check, notebook)
    answer, expected = (tuple(map(float, told.get(key, ()))) for key in ("answer", "expected"))
    wrong = difference(answer, expected, check.tolerance)
    status: Status = "pass"
    message = check.source
    if told and wrong:
        status, message = "fail", f"{wrong}; see {target}"
    elif problem or not told:
        status, message = "error", f"{problem or 'it gave no verdict'}; see {target}"
    return CheckResult(
        name=check.name,
        title=check.title,
        group=check.group,
        status=status,
        versions=check.versions(),
        import_seconds=None,
        run_seconds=told.get("run_seconds"),
        peak_mb=peak or None,
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
