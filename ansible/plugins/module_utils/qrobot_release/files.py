"""Files that survive power cuts, and what a release consists of."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any


class ReleaseError(Exception):
    """What was asked cannot be done; the text is one sentence with the advice.

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
