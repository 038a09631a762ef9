"""Collect the wheels of a profile for a robot, every one held against the hashes of locks/.

The robot asks no package index: what is collected here goes to it over SSH. All profiles and
robots share one folder, build/wheelhouse/files; a run that finds everything there asks nobody.
The wheels of a robot are searched for instructions that a Pi 4 lacks (instructions.py).
Exit codes: 0 done, 2 an argument or a lock cannot be used, 3 something is missing or wrong.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import sys
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import instructions
from common import ROOT, lock_folder, read_json, run, say, sha256, write_json
from fetch import fetch, line, own_wheel
from packaging.utils import InvalidWheelFilename, parse_wheel_filename
from store import File, Store, Target

from locks import LOCKS, MACHINES, PYTHONS, ROBOTS, Pin, lock_of, pins
from qrobot.errors import BackendError, InputError

BYTECODE = 1.5  # installed files with their compiled form, as a multiple of the files


def main() -> None:
    options = arguments()
    python = choice("python", options.python, PYTHONS)
    target = Target(python, choice("machine", options.machine, MACHINES.values()))
    profile = choice("profile", options.profile, ROBOTS)
    lock = options.lock or LOCKS / lock_of(profile)
    folder = options.dest
    wanted = read_lock(lock, target)
    uv_pin = next((pin for pin in read_lock(options.uv_lock, target) if pin.name == "uv"), None)
    if uv_pin is None:
        raise InputError("it pins no uv", source=str(options.uv_lock), advice="run `make lock`")
    with lock_folder(folder, "wheelhouse"):
        store = Store(folder, target)
        own = take_own_wheel(options.wheel, store) if options.wheel else own_wheel(store)
        *files, uv = collect([*wanted, uv_pin], store)
        document = describe(profile, target, store, [*files, own], own)
        document["uv"] = asdict(uv) | unpack_uv(store, uv, uv_pin.version)
        document["unreviewed"] = unreviewed_on_a_pi([*files, uv], store)
        path = folder / f"{profile}-{target.python}-{target.machine}.json"
        before = read_json(path)
        changed = before != document
        if changed:
            write_json(path, document)
    if options.json:
        print(json.dumps({"changed": changed} | document))
    size = sum(file["size"] for file in document["files"]) / 1e6
    say(f"wheelhouse: {document['id']}: {len(document['files'])} wheels, {size:.0f} MB")
    for sentence in document["unreviewed"]:
        say(f"wheelhouse: {sentence}")
    if options.strict and document["unreviewed"]:
        raise BackendError(f"{len(document['unreviewed'])} findings are not reviewed")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--profile", default="edge", help="solver, edge (default) or lab")
    parser.add_argument("--python", default="3.13", help="the robot's Python: 3.11 or 3.13")
    parser.add_argument("--machine", default="aarch64", help="aarch64 (default) or x86_64")
    parser.add_argument("--lock", type=Path, help="another lock than the profile's")
    parser.add_argument("--uv-lock", type=Path, default=ROOT / "locks" / "provision.txt",
                        help="the lock that pins uv")  # fmt: skip
    parser.add_argument("--wheel", type=Path, help="qRobot's own wheel: by default it is built")
    parser.add_argument("--dest", type=Path, default=ROOT / "build" / "wheelhouse")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument("--strict", action="store_true",
                        help="fail at instructions that nobody has reviewed")  # fmt: skip
    return parser.parse_args()


def choice(field: str, value: str, known: Any) -> str:
    if value not in known:
        advice = f"give {' or '.join(known)}"
        raise InputError(f"{value} is not known", field=f"--{field}", advice=advice)
    return value


def read_lock(path: Path, target: Target) -> list[Pin]:
    """Return the pins that hold on the target, by name."""
    try:
        text = path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is not text"
        raise InputError(f"not readable ({why})", source=str(path), field="lock") from None
    try:
        found = sorted(pins(text, target.machine, target.python), key=lambda pin: pin.name)
    except ValueError as error:
        why = str(error).splitlines()[0]
        raise InputError(
            f"is not a lock ({why})", source=str(path), advice="run `make lock`"
        ) from None
    bare = [pin.name for pin in found if not pin.hashes]
    if bare or not found:
        problem = f"{bare[0]} has no hash" if bare else f"it pins nothing for {target}"
        raise InputError(problem, source=str(path), advice="run `make lock`")
    return found


def take_own_wheel(path: Path, store: Store) -> File:
    """Take qRobot's own wheel from a file."""
    try:
        name, _, _, tags = parse_wheel_filename(path.name)
    except InvalidWheelFilename:
        name, tags = None, frozenset()
    if name != "qrobot" or not tags & store.target.tags:
        advice = "build one with `make dist`"
        raise InputError(
            "is not a wheel of qRobot", source=str(path), field="--wheel", advice=advice
        )
    with store.scratch() as folder:
        try:
            copy = Path(shutil.copyfile(path, folder / path.name))
        except OSError as error:
            raise InputError(f"not readable ({error.strerror})", source=str(path)) from None
        size_unpacked(copy)
        return store.put(copy)


def collect(wanted: list[Pin], store: Store) -> list[File]:
    """Return a verified file for every pin, in their sequence; fetch what is missing."""
    there = {pin: store.find(pin) for pin in wanted}
    known = [file for file in there.values() if file]
    missing = [pin for pin, file in there.items() if file is None]

    def progress(files: list[File]) -> None:
        size = sum(file.size for file in [*known, *files]) / 1e6
        count = len(known) + len(files)
        say(f"wheelhouse: {count} of {len(wanted)} wheels, {size:.0f} MB")

    if missing:
        say(f"wheelhouse: {len(missing)} of {len(wanted)} wheels to fetch for {store.target}")
        fetch(missing, store, progress)
        there = {pin: store.find(pin) for pin in wanted}
    lost = [pin.name for pin, file in there.items() if file is None]
    if lost:
        raise BackendError(f"{', '.join(lost)}: gone from {store.files} meanwhile; run it again")
    return [file for file in there.values() if file]


def describe(
    profile: str, target: Target, store: Store, files: list[File], own: File
) -> dict[str, Any]:
    """Say what a release is made of."""
    files = sorted(files, key=lambda file: file.name)
    version = str(parse_wheel_filename(own.name)[1])
    what = [f"python {target.python}", f"machine {target.machine}"]
    what += [f"{file.name} {file.sha256}" for file in files]
    digest = hashlib.sha256("\n".join(sorted(what)).encode()).hexdigest()
    lines = []
    for file in files:
        name, release, _, _ = parse_wheel_filename(file.name)
        lines.append(line(name, str(release), (f"sha256:{file.sha256}",)))
    installed = sum(size_unpacked(store.files / file.name) for file in files)
    return {
        "profile": profile,
        "python": target.python,
        "machine": target.machine,
        "id": f"{version}-{profile}-{digest[:8]}",
        "version": version,
        "requirements": "\n".join(sorted(lines)) + "\n",
        "files": [asdict(file) for file in files],
        "installed_mb": round(installed * BYTECODE / 1e6),
    }


def unreviewed_on_a_pi(files: list[File], store: Store) -> list[str]:
    """Return a sentence for each kind of instruction that a Pi 4 lacks and nobody has reviewed."""
    if store.target.machine != "aarch64":
        return []
    paths = [store.files / file.name for file in files]
    found = instructions.scan(paths, store.folder / "instructions.json")
    return instructions.unreviewed(found, instructions.reviews())


def size_unpacked(path: Path) -> int:
    """Return how many bytes a wheel's files have."""
    try:
        with zipfile.ZipFile(path) as wheel:
            return sum(entry.file_size for entry in wheel.infolist())
    except zipfile.BadZipFile:
        raise BackendError(f"{path.name} is not a wheel: it cannot be opened") from None


def unpack_uv(store: Store, wheel: File, version: str) -> dict[str, str]:
    """Take the program uv out of its wheel: the robot installs with it."""
    path = store.folder / f"uv-{version}-{store.target.machine}" / "uv"
    with store.scratch() as folder:
        try:
            with (
                zipfile.ZipFile(store.files / wheel.name) as archive,
                archive.open(f"uv-{version}.data/scripts/uv") as source,
                (folder / "uv").open("wb") as copy,
            ):
                shutil.copyfileobj(source, copy)
        except (zipfile.BadZipFile, KeyError):
            raise BackendError(f"{wheel.name}: it holds no program uv") from None
        digest = sha256(folder / "uv")
        if not path.is_file() or sha256(path) != digest or not os.access(path, os.X_OK):
            path.parent.mkdir(exist_ok=True)
            (folder / "uv").chmod(0o755)
            (folder / "uv").replace(path)
    return {"version": version, "binary": str(path.resolve()), "binary_sha256": digest}


if __name__ == "__main__":
    sys.exit(run("wheelhouse", main))
