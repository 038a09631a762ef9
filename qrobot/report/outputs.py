"""Files that programs give and take: where to write, and plans read back."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from qrobot._files import NO_PERMISSION, StrPath
from qrobot.errors import InputError
from qrobot.plan import read_plan

__all__ = ["check_outputs", "check_writable", "read_plan"]


def check_writable(path: StrPath) -> None:
    """Refuse a path that cannot be written, before any work is done for it.

    Raises
    ------
    InputError
        When the folder is missing, it or the file may not be written, or the path is a
        folder.
    """
    if os.fspath(path) == "-":
        raise InputError(
            "names no file",
            source="-",
            mend="use /dev/stdout for the standard output, or ./- for a file of this name",
        )
    target = Path(path)
    folder = target.parent
    if target.is_dir():
        raise InputError("is a folder", source=os.fspath(path), mend="give the path of a file")
    if not folder.is_dir():
        raise InputError(
            f"the folder {os.fspath(folder)!r} does not exist",
            source=os.fspath(path),
            mend="make it, or choose another place",
        )
    if target.exists() and not os.access(target, os.W_OK):
        raise InputError(
            "may not be written",
            source=os.fspath(path),
            mend=NO_PERMISSION,
        )
    if target.exists() and not target.is_file():
        return  # a device or pipe: written to directly
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(
            f"the folder {os.fspath(folder)!r} may not be written",
            source=os.fspath(path),
            mend=NO_PERMISSION,
        )


def check_outputs(outputs: Sequence[StrPath], inputs: Sequence[StrPath] = ()) -> None:
    """Refuse outputs that cannot be written, overwrite an input, or share a name.

    Raises
    ------
    InputError
        With the path and the mend.
    """
    taken = {os.path.realpath(path): "is an input" for path in inputs}
    for path in outputs:
        check_writable(path)
        real = os.path.realpath(path)
        if real in taken and not real.startswith("/dev/"):
            raise InputError(taken[real], source=os.fspath(path), mend="give another name")
        taken[real] = "is written twice"
