"""Files below a folder that a user owns, handled as that user and without following a link.

Root that follows a link in a user's folder gives away what the link leads to. So a process of its
own becomes the owner of the folder, for good, before it looks at anything below it; and each
component of a path is opened by itself, so that a link is refused also where the owner could
follow it. A link that is put there meanwhile finds a process that may no more than its owner.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import pwd
import stat
from collections.abc import Callable
from pathlib import PurePosixPath
from typing import Any

FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
# Without O_NONBLOCK a named pipe would hold the process for ever.
FILE = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


class OwnedError(Exception):
    """What was asked cannot be done; the text is one sentence with the advice."""


class NotOwnedError(OwnedError):
    """The folder is not there, or somebody else owns it."""


def as_owner(path: str, owner: str, work: Callable[[OwnedFolder], Any]) -> Any:
    """Do something below a folder as the user who owns it.

    Parameters
    ----------
    path
        The folder. Its own path may have links: only root changes the folders that it lies in.
    owner
        Name of the user who must own it; empty takes whoever does.
    work
        Called with the folder, in a process of its own; its answer must be one that JSON knows.

    Raises
    ------
    NotOwnedError
        When the folder is not there, or is somebody else's.
    OwnedError
        When the work cannot be done.
    """
    try:
        handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        raise NotOwnedError(f"{path}: {error.strerror}: provision again") from None
    try:
        found = os.fstat(handle)
        if owner and _name(found.st_uid) != owner:
            raise NotOwnedError(
                f"{path} belongs to {_name(found.st_uid)} and not to {owner}: provision again"
            )
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                _answer(writer, OwnedFolder(path, handle), work)
            finally:
                os._exit(0)  # whatever befell it, the child does not go on as the module
        os.close(writer)
        with os.fdopen(reader, "rb") as stream:
            said = stream.read()
        os.waitpid(child, 0)
    finally:
        os.close(handle)
    if not said:
        raise OwnedError(f"{path}: the work below it ended without an answer: run it again")
    answer = json.loads(said)
    if "refused" in answer:
        raise OwnedError(answer["refused"])
    return answer["done"]


def _answer(writer: int, folder: OwnedFolder, work: Callable[[OwnedFolder], Any]) -> None:
    """Run the work as the owner, in the child, and tell its parent."""
    try:
        _become(os.fstat(folder.handle))
        answer = {"done": work(folder)}
    except OwnedError as error:
        answer = {"refused": str(error)}
    except OSError as error:
        answer = {"refused": f"{folder.path}: {error.strerror or error}"}
    with os.fdopen(writer, "wb") as stream:
        stream.write(json.dumps(answer).encode())


class OwnedFolder:
    """A folder of a user, in a process that is that user.

    Parameters
    ----------
    path
        Its path, for what is said.
    handle
        The open folder.
    """

    def __init__(self, path: str, handle: int) -> None:
        self.path = path
        self.handle = handle

    def folder(self, name: str, make: bool = False) -> int | None:
        """Open a folder below this one; None where it is not there.

        Parameters
        ----------
        name
            Its path from here.
        make
            Make what is missing, for the owner alone.
        """
        handle, reached = os.dup(self.handle), ""
        for part in parts(name):
            reached = f"{reached}/{part}"
            try:
                inner = self._enter(handle, part, make)
            except OSError as error:
                raise self._refused(handle, reached, error) from None
            finally:
                os.close(handle)
            if inner is None:
                return None
            handle = inner
        return handle

    def file(self, name: str) -> int | None:
        """Open a file below this one for reading; None where it is not there."""
        folder, last = split(name)
        handle = self.folder(folder)
        if handle is None:
            return None
        try:
            opened = os.open(last, FILE, dir_fd=handle)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._refused(handle, f"/{name}", error) from None
        finally:
            os.close(handle)
        if not stat.S_ISREG(os.fstat(opened).st_mode):
            os.close(opened)
            raise OwnedError(f"{self.path}/{name} is not a plain file: remove it and run again")
        return opened

    def kind(self, name: str) -> str:
        """Tell what a name is: absent, link, folder, file or other."""
        folder, last = split(name)
        handle = self.folder(folder)
        if handle is None:
            return "absent"
        try:
            return _kind(handle, last)
        finally:
            os.close(handle)

    def _enter(self, handle: int, part: str, make: bool) -> int | None:
        try:
            return os.open(part, FOLDER, dir_fd=handle)
        except FileNotFoundError:
            if not make:
                return None
        os.mkdir(part, 0o700, dir_fd=handle)
        os.fsync(handle)
        return os.open(part, FOLDER, dir_fd=handle)

    def _refused(self, handle: int, name: str, error: OSError) -> OwnedError:
        """Say why the last component of a path, in an open folder, cannot be opened."""
        reached = f"{self.path}{name}"
        if _kind(handle, name.rpartition("/")[2]) == "link":
            return OwnedError(
                f"{reached} is a link, and qRobot follows none below {self.path}: replace it by a "
                "folder or a file of its own, or remove it, and run again"
            )
        if error.errno == errno.ENOTDIR:
            return OwnedError(f"{reached} is not a folder: remove it and run again")
        if error.errno in (errno.EACCES, errno.EPERM):
            owner = _name(os.fstat(self.handle).st_uid)
            return OwnedError(
                f"{reached} is closed to {owner}, who owns {self.path}: give it back with "
                f"chown {owner}, or remove it, and run again"
            )
        return OwnedError(f"{reached}: {error.strerror}")


def parts(name: str) -> tuple[str, ...]:
    """Components of a path below a folder; one that could leave the folder is refused."""
    found = PurePosixPath(name).parts
    if name.startswith("/") or ".." in found:
        raise OwnedError(f"{name!r} leaves the folder: give a path below it")
    return found


def split(name: str) -> tuple[str, str]:
    """Folder and last component of a path below a folder."""
    *folder, last = parts(name) or ("",)
    if not last:
        raise OwnedError("a path is empty: give a path below the folder")
    return "/".join(folder), last


def _kind(handle: int, name: str) -> str:
    try:
        mode = os.stat(name, dir_fd=handle, follow_symlinks=False).st_mode
    except FileNotFoundError:
        return "absent"
    kinds = {stat.S_IFLNK: "link", stat.S_IFDIR: "folder", stat.S_IFREG: "file"}
    return kinds.get(stat.S_IFMT(mode), "other")


def _become(folder: os.stat_result) -> None:
    """Become the owner of a folder for good, when this process is root."""
    os.umask(0o077)
    uid, gid = folder.st_uid, folder.st_gid
    if os.geteuid() != 0 or uid == 0:
        return
    with contextlib.suppress(KeyError):
        gid = pwd.getpwuid(uid).pw_gid
    os.setgroups([])
    os.setresgid(gid, gid, gid)
    os.setresuid(uid, uid, uid)


def _name(uid: int) -> str:
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return f"the user {uid}"
