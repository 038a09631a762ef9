"""numba, found late and with a place for its cache.

numba keeps machine code beside the source file, or in the user's cache folder. Where both are
read-only (a container, a service without a home) it raises ``no locator available``; then the
code goes into a folder of our own below the system's temporary folder. Compiled code is loaded
by unpickling, so that folder must belong to this user and be closed to others; otherwise
nothing is cached. A folder named by NUMBA_CACHE_DIR is taken as it is.

numba takes machine code from its cache as long as the function's own file is the same. Kernels
contain others, from other files, so their names in the cache have a hash of all of these.

Images and releases bring machine code along, beside the package, where their users cannot write
and numba therefore does not look. From there it is copied to where numba does: 2 MB, once. A new
release takes over in the same way what an older one has of unchanged searches.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import importlib
import inspect
import os
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, cast

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

older: Path | None = None
"""Package folder of another installation, whose machine code is taken where it is the same."""


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
    function.__qualname__ = _name_of(Path(inspect.getfile(function)), function.__name__)
    if not caching:
        return _jit(numba, function, sums, inline, cache=False)
    if not numba.config.CACHE_DIR:
        try:
            return _brought(_jit(numba, function, sums, inline, cache=True), function)
        except RuntimeError:  # no locator available
            folder = private_folder()
            if folder is None:
                return _jit(numba, function, sums, inline, cache=False)
            numba.config.CACHE_DIR = str(folder)
    try:
        return _brought(_jit(numba, function, sums, inline, cache=True), function)
    except RuntimeError:
        return _jit(numba, function, sums, inline, cache=False)


def _jit(
    numba: Any, function: Callable[..., Any], sums: bool, inline: bool, *, cache: bool, **more: Any
) -> Callable[..., Any]:
    flags = {"contract", "reassoc", "nsz"} if sums else {"contract"}
    made: Callable[..., Any] = numba.njit(
        cache=cache, fastmath=flags, inline="always" if inline else "never", **OPTIONS, **more
    )(function)
    return _forgiving(made) if cache else made


def _forgiving(kernel: Any) -> Any:
    """Return a kernel that compiles anew where its file in the cache is damaged.

    numba itself fails then, each time: a machine that lost power may have files without content.
    """
    cached = getattr(kernel, "_cache", None)
    if cached is None:
        return kernel
    load = cached.load_overload

    def load_overload(*asked: Any) -> Any:
        try:
            return load(*asked)
        except Exception:  # what unpickling of anything raises
            with contextlib.suppress(OSError):  # a folder that takes no files: compiled each time
                cached.flush()
            return None

    cached.load_overload = load_overload
    return kernel


def _brought(kernel: Any, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel, with the machine code that came along where numba looks for it."""
    source = Path(inspect.getfile(function))
    folder = Path(kernel.stats.cache_path)
    places = [source.parent]
    package = Path(__file__).parent
    if older and source.is_relative_to(package):
        places.append(older / source.parent.relative_to(package))
    pattern = f"__pycache__/{_index_of(source, function.__name__)}"
    with contextlib.suppress(OSError):  # then it is compiled
        for index in (found for place in places for found in place.glob(pattern)):
            mine = folder / index.name
            if mine == index or _is_fresh(mine, source) or not _is_fresh(index, source):
                continue
            # The index last: what it names is there. Each by one rename, as numba itself does.
            for file in [*index.parent.glob(f"{index.stem}.*.nbc"), index]:
                part = folder / f"{file.name}.{os.getpid()}.part"
                shutil.copyfile(file, part)
                part.replace(folder / file.name)
    return cast("Callable[..., Any]", kernel)


def is_cached(source: Path, name: str) -> bool:
    """Return whether a kernel was compiled by an earlier process, without importing numba.

    Parameters
    ----------
    source
        The file that it stands in.
    name
        Its function.
    """
    pattern = _index_of(source, name)
    named = os.environ.get("NUMBA_CACHE_DIR")
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
    shared = [Path(named)] if named else [home, private_folder()]
    found = [*(source.parent / "__pycache__").glob(pattern)]
    found += [file for folder in shared if folder for file in folder.glob(f"*/{pattern}")]
    return any(_is_fresh(index, source) for index in found)


def _index_of(source: Path, name: str) -> str:
    """Return a pattern of the name that numba gives the index of a kernel."""
    version = f"py{sys.version_info[0]}{sys.version_info[1]}"
    return f"{source.stem}.{_name_of(source, name)}-*.{version}.nbi"


def _name_of(source: Path, name: str) -> str:
    """Return the name of a kernel in the cache: with a hash of all that is compiled into it.

    That is its file, those that it takes kernels from, and what these import from the package:
    constants and types.
    """
    parts: dict[Path, str] = {}
    files = [source]
    while files:
        file = files.pop()
        facts = _facts(file, file.stat().st_mtime_ns)
        parts[file] = facts.digest
        if facts.has_kernels or file == source:
            files += [other for other in facts.imports if other not in parts]
    digest = hashlib.sha256("".join(sorted(parts.values())).encode()).hexdigest()
    return f"{name}_{digest[:12]}"


class _Facts(NamedTuple):
    """Of a source file: its hash, whether it has kernels, and which files it imports."""

    digest: str
    has_kernels: bool
    imports: tuple[Path, ...]


@functools.cache
def _facts(file: Path, changed: int) -> _Facts:  # noqa: ARG001 - changed: the cache's key
    text = file.read_bytes()
    roots = {folder.name: folder.parent for folder in file.parents}
    imports = []
    for module in re.findall(rb"^ *from ([\w.]+) import", text, re.MULTILINE):
        first, *rest = module.decode().split(".")
        if first in roots and rest:
            imports.append(roots[first].joinpath(first, *rest).with_suffix(".py"))
    found = tuple(other for other in imports if other.is_file())
    return _Facts(hashlib.sha256(text).hexdigest(), b"compile_kernel" in text, found)


def _is_fresh(index: Path, source: Path) -> bool:
    """Return whether an index is there and of the source as it is now.

    numba writes the hash of the source into it, and for which processor it has machine code: that
    which NUMBA_CPU_NAME names must be among them. What it finds itself is not asked for here,
    because that takes an import of numba.
    """
    try:
        written, digest = index.read_bytes(), hashlib.sha256(source.read_bytes()).digest()
    except OSError:
        return False
    return digest in written and os.environ.get("NUMBA_CPU_NAME", "").encode() in written


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
