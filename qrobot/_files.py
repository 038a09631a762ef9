"""Files in and out: whole texts read with clear refusals, whole files written or none.

A robot may lose power at any moment, so every file that qRobot writes is written aside,
flushed to the disk and renamed into place: readers see the old file or the new one, never
a half. Every `OSError` becomes an `InputError` that names the file and the advice.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from qrobot.errors import InputError

__all__ = [
    "MAX_BYTES",
    "NO_PERMISSION",
    "StrPath",
    "can_take_files",
    "check_outputs",
    "path_text",
    "read_bytes",
    "read_text",
    "refusal",
    "replace_file",
    "takes_files",
    "write_bytes_atomic",
    "write_text_atomic",
]

StrPath = str | os.PathLike[str]

MAX_BYTES = 200_000_000
"""Larger input files are refused: parsing one would exhaust the memory of a robot."""

NO_PERMISSION = (
    "run the container as yourself: docker run --user $(id -u):$(id -g) ..."
    if os.environ.get("QROBOT_CONTAINER")  # our images set it
    else "check the permissions, or choose another place"
)
"""What helps where a file or folder belongs to somebody else."""

_ADVICE = {
    errno.ENOENT: "check the path",
    errno.EACCES: NO_PERMISSION,
    errno.EPERM: NO_PERMISSION,
    errno.EROFS: "choose another place",
    errno.ENOSPC: "free some space, or choose another place",
    errno.EDQUOT: "free some space, or choose another place",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ENOTDIR: "check the path",
    errno.EISDIR: "give the path of a file",
}


def path_text(path: StrPath) -> str:
    """Return a path as text.

    Raises
    ------
    InputError
        When it is not the path of anything.
    """
    given: Any = path  # whatever the annotation says
    text = os.fspath(given) if isinstance(given, os.PathLike) else given
    if not isinstance(text, str):
        raise InputError(
            f"an object of class {type(path).__name__} is not a path",
            advice="give the path of a file as text",
        )
    if not text:
        raise InputError("the path is empty", advice="give the path of a file")
    return text


def read_text(path: StrPath, *, fallback: str | None = None) -> str:
    """Return the text of a file.

    Parameters
    ----------
    path
        A regular file of UTF-8 text, with or without a byte order mark.
    fallback
        Encoding for files that are not UTF-8, such as ``latin-1`` for old benchmark files.

    Raises
    ------
    InputError
        When the file is missing, unreadable, empty, binary, in another encoding or huge.
    """
    return _decoded(read_bytes(path), path_text(path), fallback)


def read_bytes(path: StrPath) -> bytes:
    """Return the content of a regular file.

    Raises
    ------
    InputError
        When the file is missing, unreadable or huge.
    """
    source = path_text(path)
    try:
        # Not blocking: opening a pipe that nobody writes to would wait for ever.
        descriptor = os.open(source, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            if stat.S_ISDIR(status.st_mode):
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            if not stat.S_ISREG(status.st_mode):
                raise InputError("is not a regular file", source=source, advice="copy it to one")
            if status.st_size > MAX_BYTES:
                raise InputError(
                    f"{status.st_size / 1e6:.0f} MB are more than the {MAX_BYTES / 1e6:.0f} MB"
                    " that are read",
                    source=source,
                    advice="plan in waves, with one file each",
                )
            return file.read()
    except (OSError, ValueError) as error:  # ValueError: a NUL character in the path
        if isinstance(error, InputError):
            raise
        raise refusal("read", source, error) from None


def _decoded(data: bytes, source: str, fallback: str | None) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError("is UTF-16 text", source=source, advice="save it as UTF-8")
    if b"\0" in data:
        raise InputError("is binary, not text", source=source, advice="give a UTF-8 text file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if fallback is None:
            line = data.count(b"\n", 0, error.start) + 1
            raise InputError(
                f"is not UTF-8 text (byte {error.start}, line {line})",
                source=source,
                advice="save it as UTF-8",
            ) from None
        text = data.decode(fallback)
    # DOS ended its texts with ^Z, and some programs still do.
    text = text.rstrip("\x1a") if text.endswith("\x1a") else text
    if not text.strip():
        raise InputError("is empty", source=source, advice="give a file with content")
    return text


def write_text_atomic(path: StrPath, text: str) -> None:
    """Write a whole UTF-8 text file, or nothing, as `write_bytes_atomic` does."""
    write_bytes_atomic(path, text.encode("utf-8", errors="backslashreplace"))


def write_bytes_atomic(path: StrPath, data: bytes) -> None:
    """Write a whole file, or nothing.

    The file is written aside in the same folder, flushed to the disk and renamed. A link
    keeps pointing to the file that is replaced; a file that stood there keeps its mode,
    a new one gets that of the umask. Devices and pipes, such as ``/dev/stdout``, are
    written to directly.

    Raises
    ------
    InputError
        When the file cannot be written; what stood there before is untouched.
    """
    source = path_text(path)
    try:
        replace_file(Path(source), data)
    except (OSError, RuntimeError, ValueError) as error:
        raise refusal("write", source, error) from None


def replace_file(path: Path, data: bytes) -> None:
    """Do what `write_bytes_atomic` says, for callers that tell errors themselves.

    Raises
    ------
    OSError
        When the file cannot be written; what stood there before is untouched.
    """
    mode = None
    if path.exists():
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(mode):
            with path.open("wb") as device:
                device.write(data)
            return
        if not os.access(path, os.W_OK):  # a rename would not mind, its owner would
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    target = path.resolve()
    aside = target.parent / f".qrobot-{os.urandom(6).hex()}.tmp"
    # 0o666 is what the umask is made for: unlike tempfile, this gives the usual mode.
    descriptor = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            if mode is not None:
                aside.chmod(stat.S_IMODE(mode))
            os.fsync(file.fileno())
        aside.replace(target)
    except BaseException:  # Ctrl-C too must leave nothing behind
        with contextlib.suppress(OSError):
            aside.unlink()
        raise
    _flush_folder(target.parent)


def _flush_folder(folder: Path) -> None:
    """Make the rename itself durable, where the file system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def check_outputs(outputs: Sequence[StrPath], inputs: Sequence[StrPath] = ()) -> None:
    """Refuse outputs that cannot be written, overwrite an input, or share a name.

    Raises
    ------
    InputError
        With the path and the advice.
    """
    taken = {os.path.realpath(path): "is an input" for path in inputs}
    for path in outputs:
        _check_writable(path)
        real = os.path.realpath(path)
        if real in taken and not real.startswith("/dev/"):
            raise InputError(taken[real], source=os.fspath(path), advice="give another name")
        taken[real] = "is written twice"


def _check_writable(path: StrPath) -> None:
    """Refuse a path that cannot be written, before any work is done for it."""
    if os.fspath(path) == "-":
        raise InputError(
            "names no file",
            source="-",
            advice="use /dev/stdout for the standard output, or ./- for a file of this name",
        )
    target = Path(path)
    folder = target.parent
    if target.is_dir():
        raise InputError("is a folder", source=os.fspath(path), advice="give the path of a file")
    if not folder.is_dir():
        raise InputError(
            f"the folder {os.fspath(folder)!r} does not exist",
            source=os.fspath(path),
            advice="make it, or choose another place",
        )
    if target.exists() and not os.access(target, os.W_OK):
        raise InputError("may not be written", source=os.fspath(path), advice=NO_PERMISSION)
    if target.exists() and not target.is_file():
        return  # a device or pipe: written to directly
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(
            f"the folder {os.fspath(folder)!r} may not be written",
            source=os.fspath(path),
            advice=NO_PERMISSION,
        )


def takes_files(folder: Path) -> None:
    """Make sure that files can be made in a folder: permissions say nothing of it to root.

    Raises
    ------
    OSError
        When none can be made.
    """
    with tempfile.TemporaryFile(dir=folder):
        pass


def can_take_files(folder: Path) -> bool:
    """Return whether files can be made in a folder, or the folder itself can be."""
    try:
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        takes_files(folder)
    except OSError:
        return False
    return True


def refusal(verb: str, source: str, error: Exception) -> InputError:
    """Return what a user is told when a file cannot be read or written, with the advice."""
    code = error.errno if isinstance(error, OSError) else None
    why = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    advice = _ADVICE.get(code or 0, "check the path and the disk")
    if verb == "write" and code == errno.ENOENT:
        advice = f"create the folder {str(Path(source).parent)!r} first"
    return InputError(f"cannot {verb} {source!r}: {why}", advice=advice)
