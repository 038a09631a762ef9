"""A Jupyter kernel under watch: it executes one notebook, with a limit of time and of memory.

It is this Python with what we can import, whatever kernels are installed beside. We talk with it
through sockets that are files in a folder which no other user can enter. ipykernel itself opens one
port more, on 127.0.0.1, by which a kernel's children print.
"""

from __future__ import annotations

import asyncio
import importlib
import os
import subprocess
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from qrobot._processes import end_family, end_group, name_signal, resident_memory
from qrobot.health.process import MARK, Limits, environment, own_folder

__all__ = ["Session"]

POLL = 0.05
"""Seconds between two looks at the kernel."""

SOCKET_PATH = 90
"""Longest path of a folder of sockets, in bytes: with the socket's name Linux allows 107."""


class Session:
    """One execution of a notebook, whose outputs are put into it.

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
                    if self.peak > self.limits.megabytes:
                        overrun = f"took more than {self.limits.megabytes:g} MB of memory"
                    elif time.monotonic() - begun > self.limits.seconds:
                        overrun = overrun or f"took longer than {self.limits.seconds:g} s"
                    if overrun:
                        self._kill()
            finally:
                while thread.is_alive():
                    self._kill()
                    thread.join(POLL)
                end_family(self._pid, MARK, folder.name)
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
            told = f"{where} {overrun} and was stopped"
        elif type(error).__name__ == "DeadKernelError" and code is not None:
            manner = f"with code {code}" if code >= 0 else f"by {name_signal(-code)}"
            told = f"{where} ended the kernel {manner}"
        else:
            told = f"the kernel did not start: {_last_line(noise) or ' '.join(str(error).split())}"
        cell = self.notebook.cells[self._cell]
        if cell.cell_type == "code":
            cell.outputs.append(
                importlib.import_module("nbformat.v4").new_output(
                    "error", ename="KernelError", evalue=told, traceback=[told]
                )
            )
        return told[:500]

    @property
    def _pid(self) -> int | None:
        return self._process.pid if self._process else None

    def _kill(self) -> None:
        """End the kernel's session; what it sent into other sessions is found at the end."""
        end_group(self._pid)


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
