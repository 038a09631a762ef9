"""The process of one check: ``python -m qrobot.health.worker MODULE PIPE``.

Only ever started by `runner.run`. It writes lines of JSON to the pipe as it gets on, so that the
runner knows how far a process came that has ended.
"""

from __future__ import annotations

import importlib
import os
import platform
import resource
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from qrobot._json import json_text
from qrobot._machine import peak_memory
from qrobot._processes import end_with_parent


def main() -> None:
    """Import the stack, compute, and report both."""
    module, pipe = sys.argv[1], int(sys.argv[2])

    def report(**data: Any) -> None:
        os.write(pipe, json_text(data).encode() + b"\n")

    _prepare_process()
    try:
        check = importlib.import_module(module).CHECK
        begun = time.perf_counter()
        for name in check.imports:
            importlib.import_module(name)
        report(import_seconds=time.perf_counter() - begun)
        begun = time.perf_counter()
        answer = check.answer()
        report(
            run_seconds=time.perf_counter() - begun,
            answer=list(map(repr, answer)),
            peak_mb=peak_memory() / 2**20,
        )
        report(expected=check.expected())
    except MemoryError:
        report(error="out of memory")
    except Exception as error:
        text = " ".join(str(error).split())
        fault = file_fault(error)
        report(error=f"{type(error).__name__}: {text}"[:2000] + (f" ({fault})" if fault else ""))


def _prepare_process() -> None:
    """Leave no core dump, die with the runner, and be the first that a full machine kills.

    An emulator or a container may know or allow none of it; then the check runs without.
    """
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    end_with_parent()
    with suppress(OSError):  # without it the kernel chooses by size
        Path("/proc/self/oom_score_adj").write_text("1000")


MACHINES = {3: "i686", 40: "armv7l", 62: "x86_64", 183: "aarch64", 243: "riscv64"}
"""Numbers of machines in the ELF header (``elf.h``), by the names that `platform` gives."""


def file_fault(error: BaseException | None) -> str:
    """Say what is wrong with the file of a failed import, or ``""`` when it is not the file.

    The loader's own words hide it: of a library for another machine it says that there is no file.

    Parameters
    ----------
    error
        What was raised; packages wrap it, so the errors that it came from are asked too.
    """
    while error is not None:
        if isinstance(error, ImportError) and error.path and sys.platform == "linux":
            found = _fault_of(Path(error.path))
            if found:
                return found
        error = error.__cause__ or error.__context__
    return ""


def _fault_of(path: Path) -> str:
    if ".so" not in path.suffixes:
        return ""
    try:
        with path.open("rb") as file:
            head = file.read(20)
    except OSError:
        return ""
    if len(head) < 20 or head[:4] != b"\x7fELF":
        return f"{path.name} is damaged: reinstall its package"
    number = int.from_bytes(head[18:20], "little" if head[5] == 1 else "big")
    machine = MACHINES.get(number, f"machine {number}")
    if machine != platform.machine():
        return f"{path.name} is made for {machine}, this is {platform.machine()}: reinstall"
    return ""


if __name__ == "__main__":
    main()
