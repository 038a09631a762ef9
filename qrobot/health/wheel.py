"""Why a compiled module cannot be loaded: the loader's own words hide the commonest reasons.

Of a library for another machine it says that there is no such file.
"""

from __future__ import annotations

import platform
import sys
from pathlib import Path

__all__ = ["unfit"]

MACHINES = {3: "i686", 40: "armv7l", 62: "x86_64", 183: "aarch64", 243: "riscv64"}
"""Numbers of machines in the ELF header (``elf.h``), by the names that `platform` gives."""


def unfit(error: BaseException | None) -> str:
    """Say what is wrong with the file of a failed import, or ``""`` when it is not the file.

    Parameters
    ----------
    error
        What was raised; packages wrap it, so the errors that it came from are asked too.
    """
    while error is not None:
        if isinstance(error, ImportError) and error.path and sys.platform == "linux":
            found = _look(Path(error.path))
            if found:
                return found
        error = error.__cause__ or error.__context__
    return ""


def _look(path: Path) -> str:
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
