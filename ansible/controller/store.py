"""The folder of wheels that profiles, Pythons and machines share: nothing in it is unverified."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from common import read_json, say, sha256, write_json
from packaging.tags import Tag, compatible_tags, cpython_tags
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

from locks import Pin
from qrobot.errors import RemoteError

# glibc 2.28 is what the locks are tested with; Debian bookworm has 2.36.
OLDEST = {"aarch64": 17, "x86_64": 5}
NAMED = {"aarch64": ("2014",), "x86_64": ("2014", "2010", "1")}


@dataclass(frozen=True)
class Target:
    """The Python and the machine that wheels are for."""

    python: str
    machine: str

    def __str__(self) -> str:
        return f"Python {self.python} on {self.machine}"

    @property
    def platforms(self) -> list[str]:
        """The platforms whose wheels run there, the newest first."""
        numbered = [f"manylinux_2_{minor}" for minor in range(28, OLDEST[self.machine] - 1, -1)]
        named = [f"manylinux{era}" for era in NAMED[self.machine]]
        return [f"{name}_{self.machine}" for name in numbered + named]

    @cached_property
    def tags(self) -> frozenset[Tag]:
        """The tags of wheels that run there."""
        python = tuple(map(int, self.python.split(".")))
        cp = "cp" + self.python.replace(".", "")
        own = cpython_tags(python, [cp], self.platforms)
        return frozenset([*own, *compatible_tags(python, cp, self.platforms)])


@dataclass(frozen=True)
class File:
    """A verified file of the store."""

    name: str
    sha256: str
    size: int


class Store:
    """Wheels by file name, and which of them was chosen for which pin.

    Parameters
    ----------
    folder
        Holds ``files/``, one ``chosen-PYTHON-MACHINE.json`` a target and ``built.json``: the
        wheels built from a source archive, by the archive's hash.
    target
        What wheels are looked for.
    """

    def __init__(self, folder: Path, target: Target) -> None:
        self.folder = folder
        self.target = target
        self.files = folder / "files"
        self.files.mkdir(parents=True, exist_ok=True)
        self._chosen_path = folder / f"chosen-{target.python}-{target.machine}.json"
        self._built_path = folder / "built.json"
        self._chosen: dict[str, str] = read_json(self._chosen_path) or {}
        self._built: dict[str, dict[str, str]] = read_json(self._built_path) or {}
        for left in folder.glob("tmp-*"):  # of a run that was killed; we are alone here
            shutil.rmtree(left, ignore_errors=True)

    @contextmanager
    def scratch(self) -> Iterator[Path]:
        """Lend a folder from which a rename into the store is one step."""
        with tempfile.TemporaryDirectory(dir=self.folder, prefix="tmp-") as folder:
            yield Path(folder)

    def find(self, pin: Pin) -> File | None:
        """Return the file for a pin, its bytes just verified, or nothing."""
        for archive in pin.hashes:
            if (made := self._built.get(archive)) and (
                file := self._verified(made["name"], [made["sha256"]])
            ):
                return file
        names = [self._chosen.get(f"{pin.name}=={pin.version}")]
        if len(pin.hashes) <= 2:  # one wheel and perhaps its source: no better one to be asked for
            names += [path.name for path in self.files.iterdir() if self.fits(path.name, pin)]
        for name in names:
            if name and (file := self._verified(name, pin.hashes)):
                return file
        return None

    def fits(self, name: str, pin: Pin) -> bool:
        """Tell whether a file is, by its name, a wheel of the pin that runs on the target."""
        try:
            project, version, _, tags = parse_wheel_filename(name)
        except InvalidWheelFilename:
            return False
        return (project, str(version)) == (pin.name, pin.version) and bool(tags & self.target.tags)

    def keep(self, path: Path, pin: Pin) -> File:
        """Take a downloaded wheel in, if it is one that the lock allows here.

        Raises
        ------
        RemoteError
            When its bytes or its name are not of the pin; the file is not kept.
        """
        found = sha256(path)
        if f"sha256:{found}" not in pin.hashes or not self.fits(path.name, pin):
            raise RemoteError(
                f"{path.name}: not a file that the lock allows for {self.target} (its sha256 is "
                f"{found}), it was not kept; the index serves other bytes than the lock was made "
                "from: ask another one"
            )
        file = self.put(path)
        self._chosen[f"{pin.name}=={pin.version}"] = file.name
        write_json(self._chosen_path, self._chosen)
        return file

    def keep_built(self, path: Path, archive: str) -> File:
        """Take a wheel in that was built from the source archive with the hash ``sha256:...``."""
        file = self.put(path)
        self._built[archive] = {"name": file.name, "sha256": file.sha256}
        write_json(self._built_path, self._built)
        return file

    def put(self, path: Path) -> File:
        """Move a whole file into the store, over one of the same name."""
        file = File(path.name, sha256(path), path.stat().st_size)
        path.replace(self.files / path.name)
        return file

    def _verified(self, name: str, hashes: list[str] | tuple[str, ...]) -> File | None:
        path = self.files / name
        if not path.is_file():
            return None
        found = sha256(path)
        if found in hashes or f"sha256:{found}" in hashes:
            return File(name, found, path.stat().st_size)
        say(f"wheelhouse: {name} is not what the lock allows: it is fetched anew")
        path.unlink()
        return None
