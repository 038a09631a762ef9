#!/usr/bin/python3
"""Releases of qRobot on a robot: install, verify, switch, roll back, prune.

A release is a folder ``ROOT/releases/ID`` that is a Python environment of its own. It is complete
when ``manifest.json`` is in it, which is written last, after everything else is on the disk: a
power cut at any moment leaves a release that is complete or one that the next install wipes.
``ROOT/current`` names the release in use and is only ever replaced by one rename.

The folder that ``current`` names is never wiped, for services run from it and an environment cannot
be moved. When it is damaged, the same release is built again as ``ID.2`` (``ID.3``, ...);
``release.json`` in each holds the ID without that suffix.

Standard library only: this file is part of an Ansible module and, by itself, the program
``qrobot-release``.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

MB = 1_000_000
ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,79}")
NAMED = 20  # differences that are named one by one
LOGGED = 200  # switches that history.json remembers
LEFTOVERS = (".build", ".history.json.new", "current.new")  # of a run that was cut off
OURS = {".lock", *LEFTOVERS, "bin", "current", "history.json", "releases", "wheels"}


class ReleaseError(Exception):
    """What was asked cannot be done; the text is one sentence with the mend.

    Parameters
    ----------
    problem
        The sentence.
    code
        Exit code of the program: 1 for a state that forbids it, 2 for bad input.
    """

    def __init__(self, problem: str, code: int = 1) -> None:
        super().__init__(problem)
        self.code = code


def sync_folder(folder: Path) -> None:
    """Put the names in a folder on the disk."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write(path: Path, value: Any) -> None:
    """Write a text, or a value as JSON, so that a power cut leaves the old file or the new one."""
    text = value if isinstance(value, str) else json.dumps(value, separators=(",", ":")) + "\n"
    new = path.with_name(f".{path.name}.new")
    with open(new, "w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(new, path)
    sync_folder(path.parent)


def read(path: Path, kind: type) -> Any:
    """Value of a JSON file, or None when it is missing, unreadable or not of that kind."""
    try:
        value = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return value if isinstance(value, kind) else None


def remove(path: Path) -> None:
    """Delete a file, link or folder; a release stops to be complete before the rest of it goes."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
        return
    if (path / "manifest.json").exists():
        os.unlink(path / "manifest.json")
        sync_folder(path)
    shutil.rmtree(path)


def survey(folder: Path) -> dict[str, Any]:
    """Manifest of a release: size and time of every file, target of every link, bytes on the disk.

    Compiled files are left out of the list, because Python may write them again at any time.
    """
    files: dict[str, list[int]] = {}
    links: dict[str, str] = {}
    total = 0
    for place, folders, names in os.walk(folder):
        inside = os.path.relpath(place, folder)
        for name in [*names, *folders]:
            path = os.path.join(place, name)
            key = os.path.normpath(os.path.join(inside, name))
            stat = os.lstat(path)
            total += stat.st_blocks * 512
            if os.path.islink(path):
                links[key] = os.readlink(path)
            elif name in names and "__pycache__" not in key.split(os.sep):
                files[key] = [stat.st_size, stat.st_mtime_ns]
    return {"bytes": total, "files": files, "links": links}


def compare(folder: Path, manifest: dict[str, Any]) -> Iterator[str]:
    """Yield each difference between a release and its manifest."""
    for name, (size, mtime) in manifest["files"].items():
        try:
            stat = os.lstat(folder / name)
        except OSError:
            yield f"{name} is missing"
            continue
        if stat.st_size != size:
            yield f"{name} has {stat.st_size} bytes instead of {size}"
        elif stat.st_mtime_ns != mtime:
            yield f"{name} was changed"
    for name, target in manifest["links"].items():
        path = folder / name
        if not path.is_symlink():
            yield f"{name} is missing"
        elif os.readlink(path) != target:
            yield f"{name} leads to {os.readlink(path)} instead of {target}"
        elif not path.exists():
            yield f"{name} leads to {target}, which is not there"


def complaint(output: str) -> str:
    """Return what uv says went wrong, in one line."""
    found = re.findall(r"^\s*(?:error|cause):\s*(.+)$", output, re.MULTILINE)
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    text = ": ".join(found) or (lines[-1] if lines else "uv gave no reason")
    return text.replace("Failed to download", "cannot use").rstrip(".")


def wheel_key(name: str, version: str) -> tuple[str, str]:
    """Name and version in one spelling: ``Foo_Bar``, ``1.0`` are ``foo-bar``, ``1``."""
    plain = re.sub(r"(\.0)+(?![.\d])", "", version.lower().replace("_", "-"), count=1)
    return re.sub(r"[-_.]+", "-", name).lower(), plain


class Releases:
    """The releases under one root, such as ``/opt/qrobot``.

    Parameters
    ----------
    root
        Folder that holds ``releases``, ``wheels``, ``current`` and ``history.json``.
    dry
        Answer what would be done, and do nothing.
    """

    def __init__(self, root: Path | str, dry: bool = False) -> None:
        self.root = Path(root)
        self.folder = self.root / "releases"
        self.current = self.root / "current"
        self.dry = dry
        self._lock: int | None = None

    # What is there

    def status(self, verify: bool = False) -> dict[str, Any]:
        """State of the root.

        Parameters
        ----------
        verify
            Also compare each complete release with its manifest.

        Returns
        -------
        dict
            ``current``, ``previous`` (names or None), ``releases`` (newest first, each with ``id``,
            ``base``, ``complete``, ``size_mb``, ``installed_at``, ``note`` and, if verified,
            ``damaged``) and ``free_mb``.
        """
        releases = []
        for name in reversed(self._by_age()):
            manifest, record = self._manifest(name), self._record(name)
            entry = {
                "id": name,
                "base": self.base(name),
                "complete": manifest is not None,
                "size_mb": round(manifest["bytes"] / MB) if manifest else None,
                "installed_at": record.get("installed_at"),
                "note": record.get("note", {}),
            }
            if verify:
                entry["damaged"] = manifest is not None and self.verify(name)["count"] > 0
            releases.append(entry)
        past = self._earlier()
        return {
            "current": self.current_id(),
            "previous": past[0] if past else None,
            "releases": releases,
            "free_mb": self._free() // MB,
        }

    def current_id(self) -> str | None:
        """Name of the release in use; None without one, or when the link leads nowhere."""
        name = self._named()
        return name if name and (self.folder / name).is_dir() else None

    def base(self, name: str) -> str:
        """ID that a release was installed for: its name without the suffix of a second build."""
        return str(self._record(name).get("id", name))

    def complete_id_for(self, wanted: str, verify: bool = False) -> str | None:
        """Name of a complete release for an ID: the one in use, or else the latest.

        Parameters
        ----------
        wanted
            The ID, as it was given to `install`.
        verify
            Pass over those that are damaged.
        """
        found = [
            n for n in reversed(self._by_age()) if self.base(n) == wanted and self._complete(n)
        ]
        found.sort(key=lambda name: name != self.current_id())
        return next((n for n in found if not verify or not self.verify(n)["count"]), None)

    def verify(self, name: str) -> dict[str, Any]:
        """Compare a release with its manifest.

        Returns
        -------
        dict
            ``count`` of the differences and ``differences``, the first 20 of them.

        Raises
        ------
        ReleaseError
            When there is no release of that name.
        """
        manifest = self._manifest(self._existing(name))
        if manifest is None:
            return {"count": 1, "differences": ["manifest.json is missing: it is unfinished"]}
        found = list(compare(self.folder / name, manifest))
        return {"count": len(found), "differences": found[:NAMED]}

    # What changes it

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
            build = self.root / ".build"
            remove(target)
            remove(build)
            self._check_room(need_mb, keep_free_mb)
            self.folder.mkdir(exist_ok=True)
            build.mkdir()
            try:
                self._build(target, build, requirements, Path(wheels), Path(uv), python)
            except (ReleaseError, OSError):
                remove(target)  # its room is needed, and nothing of it can be used
                raise
            finally:
                shutil.rmtree(build, ignore_errors=True)
            record = {
                "id": wanted,
                "serial": 1 + max((self._serial(n) for n in self._names()), default=0),
                "installed_at": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
                "note": note or {},
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
            gone += self._unneeded_wheels(kept)
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

    def _build(
        self, target: Path, build: Path, requirements: str, wheels: Path, uv: Path, python: str
    ) -> None:
        """Make the environment of a release.

        Wheels are unpacked once, into a cache on the same file system, and linked from there; the
        cache goes afterwards, so that no two releases share a file.
        """
        always: list[Any] = ["--quiet", "--offline", "--no-config", "--no-python-downloads"]
        always += ["--cache-dir", build / "cache"]
        self._uv(target, build, [uv, "venv", *always, "--no-project", "--python", python, target])
        write(target / "requirements.txt", requirements)
        install = [uv, "pip", "install", *always, "--python", target / "bin" / "python"]
        install += ["--no-index", "--find-links", wheels, "--require-hashes", "--no-deps"]
        install += ["--no-build", "--compile-bytecode", "--link-mode", "hardlink"]
        install += ["--requirement", target / "requirements.txt"]
        self._uv(target, build, install)
        (target / ".lock").unlink(missing_ok=True)  # uv's own, writable for all

    def _uv(self, target: Path, build: Path, command: list[Any]) -> None:
        """Run uv with a clean environment; it holds the lock as long as it lives."""
        place = {
            "PATH": "/usr/bin:/bin",
            "HOME": str(build),
            "TMPDIR": str(build),
            "LC_ALL": "C.UTF-8",
        }
        try:
            done = subprocess.run(
                [str(word) for word in command],
                env=place,
                cwd=build,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                check=False,
                pass_fds=(self._lock,) if self._lock is not None else (),
            )
        except OSError as error:
            raise ReleaseError(f"cannot run {command[0]}: {error.strerror}", 2) from None
        if done.returncode:
            reason = complaint(done.stderr or done.stdout)
            full = "No space left" in reason
            mend = "make room" if full else "collect its wheels again"
            raise ReleaseError(f"the release {target.name} was not installed: {reason}: {mend}")

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

    def _log(self) -> list[dict[str, str]]:
        """Switches that took place, oldest first; the last one names the current release."""
        now = self._named()
        if now is None:
            return []
        log = [e for e in read(self.root / "history.json", list) or [] if isinstance(e, dict)]
        at = max((i for i, entry in enumerate(log) if entry.get("id") == now), default=None)
        return [*log, {"id": now, "how": "by hand"}] if at is None else log[: at + 1]

    def _earlier(self) -> list[str]:
        """Releases to go back to, the latest first: complete, and not the current one again."""
        now = self.current_id()
        if now is None:
            return []
        past: list[str] = []
        for entry in self._log():
            if entry.get("how") == "rollback" and entry["id"] in past:
                while past[-1] != entry["id"]:
                    past.pop()
            elif not past or past[-1] != entry["id"]:
                past.append(entry["id"])
        found: list[str] = []
        for name in reversed(past[:-1]):
            # The same ID as the current one is the damaged build that it replaced.
            if name not in found and self.base(name) != self.base(now) and self._complete(name):
                found.append(name)
        return found

    def _by_age(self) -> list[str]:
        """Releases, oldest first: by their last switch; those that wait for theirs are newest."""
        last = {entry["id"]: at for at, entry in enumerate(self._log())}
        return sorted(self._names(), key=lambda n: (last.get(n, len(last)), self._serial(n), n))

    def _names(self) -> list[str]:
        if not self.folder.is_dir():
            return []
        return [p.name for p in self.folder.iterdir() if ID.fullmatch(p.name) and p.is_dir()]

    def _named(self) -> str | None:
        """Release that the link names, whether it is there or not."""
        try:
            folder, name = os.path.split(os.readlink(self.current))
        except OSError:
            return None
        return name if folder == "releases" and ID.fullmatch(name) else None

    def _free_name(self, wanted: str) -> str:
        """Name that a release can be built under: not current, not another one's."""
        number = 1
        while True:
            name = wanted if number == 1 else f"{wanted}.{number}"
            if name != self._named() and not (self._complete(name) and self.base(name) != wanted):
                return name
            number += 1

    def _manifest(self, name: str) -> dict[str, Any] | None:
        manifest: dict[str, Any] | None = read(self.folder / name / "manifest.json", dict)
        return manifest if manifest and {"bytes", "files", "links"} <= set(manifest) else None

    def _complete(self, name: str) -> bool:
        return self._manifest(name) is not None

    def _record(self, name: str) -> dict[str, Any]:
        return read(self.folder / name / "release.json", dict) or {}

    def _serial(self, name: str) -> int:
        return int(self._record(name).get("serial", 0))

    def _replaced(self, name: str) -> bool:
        """Whether the release in use is a later build of the same one."""
        now = self.current_id()
        same = now is not None and self.base(now) == self.base(name)
        return same and self._serial(name) < self._serial(str(now))

    def _unneeded_wheels(self, kept: list[str]) -> list[Path]:
        if not kept:
            return []  # they may be there for the first release
        needed = set()
        for name in kept:
            try:
                text = (self.folder / name / "requirements.txt").read_text(encoding="utf-8")
            except OSError:
                return []  # what a damaged release needs is not known
            for package, version in re.findall(
                r"(?m)^([\w.-]+)(?:\[.*?\])?\s*==\s*([^\s;\\]+)", text
            ):
                needed.add(wheel_key(package, version))
        unneeded = []
        for path in sorted((self.root / "wheels").glob("*")):
            parts = path.name.split("-")
            wheel = path.suffix == ".whl" and len(parts) >= 5
            if path.name.endswith(".part") or (
                wheel and wheel_key(parts[0], parts[1]) not in needed
            ):
                unneeded.append(path)
        return unneeded

    def _check_id(self, name: str) -> None:
        if not ID.fullmatch(name):
            raise ReleaseError(
                f"{name!r} is not an ID of a release: letters, digits and . _ + - only, up to 80", 2
            )

    def _existing(self, name: str) -> str:
        self._check_id(name)
        if name not in self._names():
            have = ", ".join(reversed(self._by_age())) or "none"
            raise ReleaseError(f"there is no release {name} under {self.root} (there: {have})", 2)
        return name

    def _free(self) -> int:
        place = Path(os.path.abspath(self.root))
        while not place.is_dir():
            place = place.parent
        return shutil.disk_usage(place).free

    def _check_room(self, need_mb: int, keep_free_mb: int, spare: int = 0) -> None:
        free = (self._free() + spare) // MB
        if free < need_mb + keep_free_mb:
            raise ReleaseError(
                f"{free} MB are free for {self.root}, but the release takes {need_mb} MB and "
                f"{keep_free_mb} MB are to stay free: remove old releases (qrobot-release prune) "
                "or other files"
            )


EXAMPLES = """examples:
  qrobot-release list                    releases, the one in use and the one before it
  qrobot-release verify                  is any file of the release in use missing or changed?
  sudo qrobot-release rollback           back to the release before
  sudo qrobot-release switch 1.0-edge-3f2a9c
  sudo qrobot-release prune --keep 2     remove older releases and their wheels

exit codes: 0 done, 1 damaged or nothing to go back to, 2 bad input
After rollback or switch, restart what runs: sudo systemctl restart 'qrobot*'
"""


def as_table(state: dict[str, Any]) -> str:
    """Releases as lines of text."""
    lines = []
    for release in state["releases"]:
        use = {state["current"]: "in use", state["previous"]: "before"}.get(release["id"], "")
        whole = f"{release['size_mb']} MB" if release["complete"] else "unfinished"
        when = release["installed_at"] or "-"
        lines.append(f"{use:8}{release['id']:40}{whole:>12}  {when}".rstrip())
    return "\n".join([*(lines or ["no releases"]), f"{state['free_mb']} MB are free"])


def main(arguments: list[str] | None = None) -> int:
    """Run the program for the person at the robot; returns its exit code."""
    import argparse

    parser = argparse.ArgumentParser(
        prog="qrobot-release",
        description="Releases of qRobot on this robot.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--json", action="store_true", help="answer as JSON")
    common.add_argument("--root", default="/opt/qrobot", help="default: %(default)s")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("list", parents=[common], help="releases, newest first")
    verify = commands.add_parser("verify", parents=[common], help="compare with the manifest")
    verify.add_argument("id", nargs="?", help="default: the one in use")
    commands.add_parser("rollback", parents=[common], help="go back to the release before")
    switch = commands.add_parser("switch", parents=[common], help="use another release")
    switch.add_argument("id")
    prune = commands.add_parser("prune", parents=[common], help="remove old releases and wheels")
    prune.add_argument("--keep", type=int, default=3, help="how many stay (default: %(default)s)")
    given = parser.parse_args(arguments)
    try:
        answer, text, code = _run(Releases(given.root), given)
    except ReleaseError as error:
        answer, text, code = {"error": str(error)}, f"qrobot-release: {error}", error.code
    except OSError as error:
        problem = f"cannot read {error.filename or given.root}: {error.strerror}"
        answer, text, code = {"error": problem}, f"qrobot-release: {problem}", 1
    out = sys.stderr if "error" in answer and not given.json else sys.stdout
    out.write((json.dumps(answer, indent=2) if given.json else text) + "\n")
    return code


def _run(releases: Releases, given: Any) -> tuple[dict[str, Any], str, int]:
    """Answer, its text and the exit code of one command."""
    if given.command == "list":
        state = releases.status()
        return state, as_table(state), 0
    if given.command == "verify":
        name = given.id or releases.current_id()
        if name is None:
            raise ReleaseError(f"no release is in use under {releases.root}: name one by its ID")
        found = releases.verify(name)
        more = found["count"] - len(found["differences"])
        lines = [*found["differences"], *([f"and {more} more"] if more else [])]
        text = "\n".join(lines) or f"{name}: every file is as installed"
        return {"id": name, **found}, text, int(found["count"] > 0)
    if given.command == "prune":
        removed = releases.prune(given.keep)
        return {"removed": removed}, "\n".join(removed) or "nothing to remove", 0
    changed = True
    if given.command == "rollback":
        name = releases.rollback()
    else:
        name, changed = given.id, releases.switch(given.id)
    return {"current": name, "changed": changed}, f"in use: {name}", 0


if __name__ == "__main__":
    sys.exit(main())
