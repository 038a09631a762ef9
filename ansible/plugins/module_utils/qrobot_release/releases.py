"""What changes releases: install, switch, roll back, prune, remove; one run at a time."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .environment import build, compile_searches
from .files import ReleaseError, remove, survey, sync_folder, write
from .state import MB, State
from .wheels import unneeded

LOGGED = 200  # switches that history.json remembers
LEFTOVERS = (".build", ".history.json.new", "current.new")  # of a run that was cut off
OURS = {".lock", *LEFTOVERS, "bin", "current", "history.json", "releases", "wheels"}


class Releases(State):
    """The releases under one root, such as ``/opt/qrobot``.

    Parameters
    ----------
    root
        Folder that holds ``releases``, ``wheels``, ``current`` and ``history.json``.
    dry
        Answer what would be done, and do nothing.
    """

    def __init__(self, root: Path | str, dry: bool = False) -> None:
        super().__init__(root)
        self.dry = dry
        self._lock: int | None = None

    def install(
        self,
        wanted: str,
        requirements: str,
        wheels: Path | str,
        uv: Path | str,
        python: str,
        note: dict[str, Any] | None = None,
        need_mb: int = 0,
        keep_free_mb: int = 0,
        verify: bool = False,
        compiles: bool = True,
    ) -> tuple[str, bool]:
        """Install a release from wheels on this machine; nothing is fetched, nothing is built.

        Parameters
        ----------
        wanted
            ID of the release.
        requirements
            Text of the lock: each package with its version and hashes.
        wheels
            Folder of the wheels.
        uv
            The installer.
        python
            The interpreter that the environment is made from.
        note
            What to remember in ``release.json``.
        need_mb, keep_free_mb
            Room that the release takes, and that must be free after it.
        verify
            Also build it again when it is there but damaged.
        compiles
            Whether its searches are compiled too.

        Returns
        -------
        tuple of str and bool
            Name of the folder, and whether it was installed now.

        Raises
        ------
        ReleaseError
            When there is no room, or a wheel is missing, broken or not the one of the lock.
        """
        self._check_id(wanted)
        with self._locked():
            there = self.complete_id_for(wanted, verify)
            if there:
                return there, False
            name = self._free_name(wanted)
            target = self.folder / name
            if self.dry:
                spare = survey(target)["bytes"] if target.is_dir() else 0
                self._check_room(need_mb, keep_free_mb, spare)
                return name, True
            if not Path(wheels).is_dir():
                raise ReleaseError(f"the folder of the wheels, {wheels}, is not there", 2)
            scratch = self.root / ".build"
            remove(target)
            remove(scratch)
            self._check_room(need_mb, keep_free_mb)
            self.folder.mkdir(exist_ok=True)
            scratch.mkdir()
            try:
                self._build(target, scratch, requirements, Path(wheels), Path(uv), python)
                uncompiled = self._compile(target, scratch) if compiles else ""
            except (ReleaseError, OSError):
                remove(target)  # its room is needed, and nothing of it can be used
                raise
            finally:
                shutil.rmtree(scratch, ignore_errors=True)
            record = {
                "id": wanted,
                "serial": 1 + max((self._serial(n) for n in self._names()), default=0),
                "installed_at": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
                "note": note or {},
                "uncompiled": uncompiled,
            }
            write(target / "release.json", record)
            os.sync()  # what the manifest lists is on the disk before the manifest is
            write(target / "manifest.json", survey(target))
            sync_folder(self.folder)
            return name, True

    def switch(self, name: str) -> bool:
        """Make a complete release the current one.

        Returns
        -------
        bool
            Whether it was another one before.
        """
        self._check_id(name)
        with self._locked():
            if self.dry:
                return name != self.current_id()
            if not self._complete(self._existing(name)):
                raise ReleaseError(f"the release {name} is unfinished: install it again")
            return self._switch(name, "switch")

    def rollback(self) -> str:
        """Switch to the release that was in use before the current one, passing over damaged ones.

        A release that a rollback left is not gone back to: a second rollback goes one further.

        Returns
        -------
        str
            The release now in use.
        """
        with self._locked():
            damaged = []
            for name in self._earlier():
                if self.verify(name)["count"]:
                    damaged.append(name)
                    continue
                if not self.dry:
                    self._switch(name, "rollback")
                return name
            now = self.current_id()
            if now is None:
                raise ReleaseError("no release is in use: switch to one by its ID")
            why = f" ({', '.join(damaged)} damaged)" if damaged else ""
            raise ReleaseError(f"there is no earlier release to go back to from {now}{why}")

    def prune(self, keep: int = 3) -> list[str]:
        """Remove what is not needed any more.

        That is: releases beyond the newest `keep`, but never the current or the previous one;
        the damaged build of a release that was built again and is in use; unfinished folders;
        and wheels that no kept release names.

        Returns
        -------
        list of str
            What was removed, as paths below the root.
        """
        if keep < 1:
            raise ReleaseError(f"keep is {keep}: at least 1 release stays", 2)
        with self._locked():
            state = self.status()
            kept = [name for name in (state["current"], state["previous"]) if name]
            for release in state["releases"]:
                name = release["id"]
                if release["complete"] and name not in kept and not self._replaced(name):
                    kept += [name] if len(kept) < keep else []
            gone = [self.folder / name for name in sorted(self._names()) if name not in kept]
            locks = [self.folder / name / "requirements.txt" for name in kept]
            if kept:  # without any, they may be there for the first release
                gone += unneeded(self.root / "wheels", locks)
            gone += [p for p in map(self.root.joinpath, LEFTOVERS) if os.path.lexists(p)]
            for path in [] if self.dry else gone:
                remove(path)
            return [str(path.relative_to(self.root)) for path in gone]

    def discard(self, name: str) -> bool:
        """Remove one release that is not in use, such as one that failed its health checks."""
        self._check_id(name)
        with self._locked():
            if name == self._named():
                raise ReleaseError(f"the release {name} is in use: switch to another one first")
            there = name in self._names()
            if there and not self.dry:
                remove(self.folder / name)
                sync_folder(self.folder)
            return there

    def reset(self) -> bool:
        """Remove everything of ours, the root last; refuses a folder that holds anything else."""
        root = Path(os.path.abspath(self.root))
        if len(root.parts) < 3:
            raise ReleaseError(
                f"{root} is not a folder of releases: give one such as /opt/qrobot", 2
            )
        if not root.is_dir():
            return False
        foreign = sorted(p.name for p in root.iterdir() if p.name not in OURS)
        if foreign:
            raise ReleaseError(f"{root} also holds {', '.join(foreign[:5])}: move that away first")
        with self._locked():
            if not self.dry:
                # First what names the rest, so that nothing ever leads to a half removed release.
                for entry in ("current", "current.new", "history.json"):
                    remove(self.root / entry)
                sync_folder(self.root)
                for name in sorted(self._names()):
                    remove(self.folder / name)
                for entry in sorted(OURS - {".lock"}):
                    remove(self.root / entry)
                remove(self.root / ".lock")
                self.root.rmdir()
            return True

    # How

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """One run at a time; what it writes is readable for all; what fails is one sentence."""
        if self.dry:
            yield
            return
        mask = os.umask(0o022)
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            with open(self.root / ".lock", "a", encoding="utf-8") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise ReleaseError(
                        f"another run works on {self.root}: wait until it has ended"
                    ) from None
                self._lock = lock.fileno()
                yield
        except PermissionError as error:
            raise ReleaseError(f"no permission to write {error.filename}: run it as root") from None
        except OSError as error:
            where = f" ({error.filename})" if error.filename else ""
            raise ReleaseError(f"{error.strerror or error}{where}") from None
        finally:
            self._lock = None
            os.umask(mask)

    def _build(self, target: Path, scratch: Path, *given: Any) -> None:
        """Make the environment; uv holds the lock as long as it lives."""
        build(target, scratch, *given, self._held())

    def _compile(self, target: Path, scratch: Path) -> str:
        """Compile its searches, or take over what the release in use has; return why not."""
        now = self.current_id()
        return compile_searches(target, scratch, self.folder / now if now else None, self._held())

    def _held(self) -> tuple[int, ...]:
        return () if self._lock is None else (self._lock,)

    def _switch(self, name: str, how: str) -> bool:
        if name == self._named():
            return False
        if self.current.exists() and not self.current.is_symlink():
            raise ReleaseError(f"{self.current} is not a link: move it away first")
        # The history first: an entry that current does not follow is an intent that never came
        # true, and _log leaves it out. The other way round, a rollback would read as a switch.
        stamp = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        entry = {"id": name, "at": stamp, "how": how}
        write(self.root / "history.json", [*self._log(), entry][-LOGGED:])
        new = self.root / "current.new"
        new.unlink(missing_ok=True)
        os.symlink(os.path.join("releases", name), new)
        sync_folder(self.root)
        os.replace(new, self.current)
        sync_folder(self.root)
        return True

    def _free_name(self, wanted: str) -> str:
        """Name that a release can be built under: not current, not another one's."""
        number = 1
        while True:
            name = wanted if number == 1 else f"{wanted}.{number}"
            if name != self._named() and not (self._complete(name) and self.base(name) != wanted):
                return name
            number += 1

    def _check_room(self, need_mb: int, keep_free_mb: int, spare: int = 0) -> None:
        free = (self._free() + spare) // MB
        if free < need_mb + keep_free_mb:
            raise ReleaseError(
                f"{free} MB are free for {self.root}, but the release takes {need_mb} MB and "
                f"{keep_free_mb} MB are to stay free: remove old releases (qrobot-release prune) "
                "or other files"
            )
