"""Runs the notebooks of `healthchecks/`, each in a kernel of its own, and keeps what they showed.

The sources are jupytext's percent scripts; the last cell of each is the check's verdict. A
kernel is watched: it has a limit of time and of memory.
"""

from __future__ import annotations

import asyncio
import importlib
import os
import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from qrobot._extras import is_installed, missing
from qrobot._files import StrPath, takes_files, write_text_atomic
from qrobot._processes import end_family, end_group, name_signal, resident_memory
from qrobot.errors import InputError
from qrobot.health.check import Check, difference
from qrobot.health.lesson import VERDICT
from qrobot.health.model import CheckResult, Status
from qrobot.health.process import MARK, ROOT, Limits, environment, own_folder
from qrobot.health.runner import result_of, run

__all__ = ["TOOLS", "prepare", "run_notebooks"]

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
        takes_files(folder)
    except OSError as error:
        raise InputError(
            f"{folder} cannot be written ({error.strerror or type(error).__name__})",
            field="--notebooks",
            advice="name a folder of your own",
        ) from None


def run_notebooks(
    checks: Sequence[Check],
    folder: StrPath,
    limits: Limits | None = None,
    *,
    progress: Callable[[Check], object] | None = None,
) -> tuple[list[CheckResult], list[InputError]]:
    """Run the notebooks of checks, one by one; whatever they do, the results say so.

    The executed copies are kept as ``FOLDER/NAME.ipynb``, with the error in it when a cell failed.
    The notebook of a stack that is not installed is not run.

    Parameters
    ----------
    checks
        Whose notebooks to run.
    folder
        Where to keep the executed copies; it is made when it is not there.
    limits
        Of time and memory; by default 300 s and 2 GiB, for each notebook.
    progress
        Called with each check as its notebook begins.

    Returns
    -------
    results
        One a check, in their sequence: also of those whose copy could not be written. The times
        are those of the check inside the notebook; `import_seconds` is None, for the cells before
        have imported the stack.
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
    verdict = _verdict(check, notebook)
    numbers = {key: list(map(float, verdict.get(key, ()))) for key in ("answer", "expected")}
    wrong = difference(numbers["answer"], numbers["expected"], check.tolerance)
    status: Status = "pass"
    message = check.source
    if verdict and wrong:
        status, message = "fail", f"{wrong}{see}"
    elif session.problem or not verdict:
        status, message = "error", f"{session.problem or 'it gave no verdict'}{see}"
    found = {"peak_mb": session.peak or None}
    return result_of(check, status, message, found | verdict | numbers if verdict else found)


def _verdict(check: Check, notebook: Any) -> dict[str, Any]:
    """Return the numbers of the last verdict on this check, or nothing."""
    found: dict[str, Any] = {}
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            data = output.get("data", {}).get(VERDICT)
            if data and data.get("check") == check.name:
                found = dict(data)
    return found


POLL = 0.05
"""Seconds between two looks at a kernel."""

SOCKET_PATH = 90
"""Longest path of a folder of sockets, in bytes: with the socket's name Linux allows 107."""


class Session:
    """One execution of a notebook in a Jupyter kernel under watch; its outputs are put into it.

    The kernel is this Python with what we can import, whatever kernels are installed beside. We
    talk with it through sockets that are files in a folder which no other user can enter. ipykernel
    itself opens one port more, on 127.0.0.1, by which a kernel's children print.

    Parameters
    ----------
    notebook
        As nbformat has it.
    limits
        Of time and memory, for the kernel and all it starts.

    Attributes
    ----------
    problem
        Why the notebook was not executed to its end, ``""`` when it was.
    peak
        Largest resident memory that was seen, in MiB.
    """

    def __init__(self, notebook: Any, limits: Limits) -> None:
        self.notebook = notebook
        self.limits = limits
        self.problem = ""
        self.peak = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._cell = 0
        self._failure: BaseException | None = None

    def run(self) -> None:
        """Execute all cells; nothing that they do is raised, and nothing of it is left behind."""
        overrun = ""
        with own_folder() as folder:
            # In a thread: nbclient takes Ctrl-C for itself when it is in the first one.
            thread = threading.Thread(target=self._guarded, args=[folder], daemon=True)
            begun = time.monotonic()
            thread.start()
            try:
                while thread.is_alive():
                    thread.join(POLL)
                    self.peak = max(self.peak, resident_memory(self._pid))
                    overrun = overrun or self.limits.broken(time.monotonic() - begun, self.peak)
                    if overrun:
                        end_group(self._pid)
            finally:
                while thread.is_alive():
                    end_group(self._pid)
                    thread.join(POLL)
                end_family(self._pid, MARK, folder.name)  # what it sent into other sessions, too
            self.problem = self._why(overrun, folder / "stderr")

    def _guarded(self, folder: Path) -> None:
        try:
            asyncio.run(self._execute(folder))
        except BaseException as error:  # whatever it is, the other thread tells it
            self._failure = error

    async def _execute(self, folder: Path) -> None:
        jupyter: Any = importlib.import_module("jupyter_client")
        nbclient: Any = importlib.import_module("nbclient")
        ipc = len(os.fsencode(folder)) < SOCKET_PATH
        manager = jupyter.AsyncKernelManager(
            kernel_name="python3",
            # Without folders to look in it only knows the kernel of this Python.
            kernel_spec_manager=jupyter.kernelspec.KernelSpecManager(kernel_dirs=[]),
            connection_file=str(folder / "kernel.json"),
            **({"transport": "ipc", "ip": str(folder / "socket")} if ipc else {}),
        )
        with (folder / "stderr").open("wb") as noise:
            await manager.start_kernel(
                cwd=str(folder), env=_environment(folder), stdout=subprocess.DEVNULL, stderr=noise
            )
        self._process = manager.provisioner.process
        channels = manager.client()
        channels.start_channels()
        channels.allow_stdin = False
        try:
            await channels.wait_for_ready(timeout=self.limits.seconds)
            client = nbclient.NotebookClient(
                self.notebook, km=manager, timeout=None, on_cell_execute=self._note
            )
            client.kc = channels
            await client.async_execute()
        finally:
            channels.stop_channels()
            await manager.shutdown_kernel(now=True)

    def _note(self, cell: object, cell_index: int) -> None:  # noqa: ARG002 - as nbclient calls it
        self._cell = cell_index

    def _why(self, overrun: str, noise: Path) -> str:
        """Say why the notebook did not come to its end, and put it where it happened."""
        error: Any = self._failure
        if error is None:
            return ""
        where = f"cell {self._cell + 1}"
        if type(error).__name__ == "CellExecutionError":  # it has its error in its outputs
            return f"{where} failed: {error.ename}: {' '.join(error.evalue.split())}"[:500]
        code = self._process.returncode if self._process else None
        if overrun:
            problem = f"{where} {overrun} and was stopped"
        elif type(error).__name__ == "DeadKernelError" and code is not None:
            manner = f"with code {code}" if code >= 0 else f"by {name_signal(-code)}"
            problem = f"{where} ended the kernel {manner}"
        else:
            problem = (
                f"the kernel did not start: {_last_line(noise) or ' '.join(str(error).split())}"
            )
        cell = self.notebook.cells[self._cell]
        if cell.cell_type == "code":
            cell.outputs.append(
                importlib.import_module("nbformat.v4").new_output(
                    "error", ename="KernelError", evalue=problem, traceback=[problem]
                )
            )
        return problem[:500]

    @property
    def _pid(self) -> int | None:
        return self._process.pid if self._process else None


def _environment(folder: Path) -> dict[str, str]:
    return environment(folder) | {
        MARK: folder.name,
        "PYTHONSAFEPATH": "1",
        "IPYTHONDIR": str(folder),  # no profile of the user, though it may be named
    }


def _last_line(path: Path) -> str:
    with suppress(OSError):
        lines = path.read_text(errors="replace").strip().splitlines()
        return lines[-1].strip() if lines else ""
    return ""
