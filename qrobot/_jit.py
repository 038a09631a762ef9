"""numba, found late and with a place for its cache.

numba keeps machine code beside the source file, or in the user's cache folder. Where both are
read-only (a container, a service without a home) it raises ``no locator available``; then the
code goes into a folder of our own below the system's temporary folder. Compiled code is loaded
by unpickling, so that folder must belong to this user and be closed to others; otherwise
nothing is cached. A folder named by NUMBA_CACHE_DIR is taken as it is.
"""

from __future__ import annotations

import importlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from qrobot._extras import is_installed

__all__ = ["available", "compile_kernel", "is_cached", "private_folder"]

OPTIONS: dict[str, Any] = {
    "nogil": True,  # kernels run on plain threads
    "boundscheck": False,
    "error_model": "numpy",
}
# Of fast arithmetic only fused multiply-add is taken: the phase kernel rounds by adding and
# subtracting a large number, which reordering would break. Sums alone may be reordered.

caching = True
"""Set to False when the cache's folder turned out not to take files (a full disk)."""


def available() -> bool:
    """Return whether numba is installed, without importing it."""
    return is_installed("numba")


def compile_kernel(
    function: Callable[..., Any], *, sums: bool = False, inline: bool = False, inner: bool = False
) -> Callable[..., Any]:
    """Return a function that numba compiles at its first call and keeps on disk if it can.

    Parameters
    ----------
    function
        Plain Python that numba understands.
    sums
        Whether sums may be reordered, so that they become vector code.
    inline
        Whether its text takes the place of calls from other kernels. Records of many arrays are
        handed over field by field, which takes longer than a short function.
    inner
        Whether only other kernels call it: then no door for Python is compiled, which takes longer
        than the function where it takes records of arrays, and nothing is kept on disk.
    """
    numba: Any = importlib.import_module("numba")
    if inner or inline:
        return _jit(numba, function, sums, inline, cache=False, no_cpython_wrapper=True)
    if not caching:
        return _jit(numba, function, sums, inline, cache=False)
    if not numba.config.CACHE_DIR:
        try:
            return _jit(numba, function, sums, inline, cache=True)
        except RuntimeError:  # no locator available
            folder = private_folder()
            if folder is None:
                return _jit(numba, function, sums, inline, cache=False)
            numba.config.CACHE_DIR = str(folder)
    try:
        return _jit(numba, function, sums, inline, cache=True)
    except RuntimeError:
        return _jit(numba, function, sums, inline, cache=False)


def _jit(
    numba: Any, function: Callable[..., Any], sums: bool, inline: bool, *, cache: bool, **more: Any
) -> Callable[..., Any]:
    flags = {"contract", "reassoc", "nsz"} if sums else {"contract"}
    made: Callable[..., Any] = numba.njit(
        cache=cache, fastmath=flags, inline="always" if inline else "never", **OPTIONS, **more
    )(function)
    return made


def is_cached(source: Path, name: str) -> bool:
    """Return whether a kernel was compiled by an earlier process, without importing numba.

    Parameters
    ----------
    source
        The file that it stands in.
    name
        Its function.
    """
    pattern = f"{source.stem}.{name}-*.py{sys.version_info[0]}{sys.version_info[1]}.nbi"
    named = os.environ.get("NUMBA_CACHE_DIR")
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
    shared = [Path(named)] if named else [home, private_folder()]
    found = [] if named else [*(source.parent / "__pycache__").glob(pattern)]
    found += [file for folder in shared if folder for file in folder.glob(f"*/{pattern}")]
    changed = source.stat().st_mtime
    return any(file.stat().st_mtime >= changed for file in found)


def private_folder() -> Path | None:
    """Return a folder for compiled code that only this user can write, or None."""
    folder = Path(tempfile.gettempdir()) / f"qrobot-numba-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()  # not stat: a link that somebody else put there is refused
    except OSError:
        return None
    mine = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    return folder if mine and not found.st_mode & 0o022 and os.access(folder, os.W_OK) else None
