"""Collect the Debian packages that one robot lacks, by its own sources and its own keys.

For ``offline: true``: the robot's package state, sources and keys were fetched over SSH; the
controller's apt resolves and downloads as that robot would, in a folder of its own, and leaves a
small repository that is pushed to the robot. Same state, same packages: nobody is asked again.
Exit codes: 0 done, 2 an argument cannot be used, 3 something is missing or not as signed.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from common import ROOT, lock_folder, read_json, run, say, sha256, write_json
from robotapt import Apt, Wanted

from qrobot.errors import BackendError, InputError

NAME = re.compile(r"[a-z0-9][a-z0-9+.-]+")


def main() -> None:
    options = arguments()
    for tool in ("apt-get", "dpkg-deb"):
        if shutil.which(tool) is None:
            raise BackendError(
                f"there is no {tool} here: packages for offline robots are collected on Debian "
                "or Ubuntu; provision with offline: false, or from such a machine"
            )
    with unpack(options.facts) as folder:
        document = gather(options, folder)
    if options.json:
        print(json.dumps(document))
    size = sum(file["size"] for file in document["files"]) / 1e6
    say(f"debs: {len(document['packages'])} packages, {size:.1f} MB in {document['path']}")


def gather(options: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Return the repository for this robot as it is now, collected or still there."""
    packages = sorted(set(options.packages))
    for name in packages:
        if not NAME.fullmatch(name):
            raise InputError(f"{name!r} is not the name of a package", field="--packages")
    status, arch = read_facts(folder, options.arch)
    what = "\0".join([arch, *packages]).encode() + b"\0" + status
    key = hashlib.sha256(what).hexdigest()[:16]
    with lock_folder(options.dest, "debs"):
        document = find_collected(options.dest, key)
        changed = document is None
        if document is None:
            document = collect(folder, arch, packages, options.dest, key)
    return document | {"changed": changed, "path": str((options.dest / key).resolve())}


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--facts", type=Path, required=True,
        help="folder or tar file fetched from the robot: status, arch, sources, keyrings",
    )  # fmt: skip
    parser.add_argument("--arch", help="such as arm64: in place of the file arch")
    parser.add_argument("--packages", nargs="+", required=True, metavar="NAME")
    parser.add_argument("--dest", type=Path, default=ROOT / "build" / "debs")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    return parser.parse_args()


@contextlib.contextmanager
def unpack(path: Path) -> Iterator[Path]:
    """Lend the folder of facts, unpacked where they came as a tar file: files only."""
    if not path.is_file():
        yield path
        return
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        try:
            with tarfile.open(path) as archive:
                for member in archive.getmembers():
                    with contextlib.suppress(KeyError):  # a link to what is not in it
                        source = archive.extractfile(member)
                        target = (folder / member.name).resolve()
                        if source and target.is_relative_to(folder.resolve()):
                            target.parent.mkdir(parents=True, exist_ok=True)
                            target.write_bytes(source.read())
        except (tarfile.TarError, EOFError):
            raise InputError("is not a tar file", source=str(path), field="--facts") from None
        yield folder


def read_facts(folder: Path, arch: str | None) -> tuple[bytes, str]:
    """Return the robot's package state and its architecture."""
    try:
        status = (folder / "status").read_bytes()
        arch = arch or (folder / "arch").read_text().strip()
    except OSError as error:
        name = Path(error.filename).name
        advice = "fetch the robot's facts again"
        raise InputError(f"{name} is not readable", field="--facts", advice=advice) from None
    if b"Package: " not in status or not re.fullmatch(r"[a-z0-9]+", arch):
        wrong = "arch" if b"Package: " in status else "status"
        raise InputError(f"{wrong} is not what dpkg writes", field="--facts")
    return status, arch


def find_collected(dest: Path, key: str) -> dict[str, Any] | None:
    """Return what an earlier run collected, if every byte of it is still there."""
    document: dict[str, Any] | None = read_json(dest / f"{key}.json")
    if document is None:
        return None
    for file in document["files"]:
        path = dest / key / file["name"]
        if not path.is_file() or sha256(path) != file["sha256"]:
            return None
    return document


def collect(folder: Path, arch: str, packages: list[str], dest: Path, key: str) -> dict[str, Any]:
    """Download what the robot lacks and make a repository of it, whole or not at all."""
    begun = time.monotonic()
    for left in dest.glob("tmp-*"):  # of a run that was killed; we are alone here
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=dest, prefix="tmp-") as scratch:
        apt = Apt(folder, arch, Path(scratch).resolve() / "apt")
        say(f"debs: reading the robot's package lists ({arch})")
        apt.update()
        wanted = apt.wanted(packages)
        size = sum(deb.size for deb in wanted) / 1e6
        say(f"debs: {len(wanted)} packages to fetch, {size:.1f} MB")
        made = Path(scratch) / key
        made.mkdir()
        apt.download(packages, wanted, made)
        names = index(made, wanted)
        files = [
            {"name": path.name, "sha256": sha256(path), "size": path.stat().st_size}
            for path in sorted(made.iterdir())
        ]
        shutil.rmtree(dest / key, ignore_errors=True)
        made.replace(dest / key)
    document = {"packages": names, "files": files}
    write_json(dest / f"{key}.json", document)
    say(f"debs: {time.monotonic() - begun:.0f} s")
    return document


def index(folder: Path, wanted: list[Wanted]) -> list[str]:
    """Write the index of a folder of packages: ``NAME=VERSION`` of each."""
    names, blocks = [], []
    for deb in sorted(wanted, key=lambda deb: deb.name):
        path = folder / deb.name
        done = subprocess.run(
            ["dpkg-deb", "--field", str(path)], capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise BackendError(f"{deb.name}: dpkg-deb cannot read it; run it again")
        control = done.stdout.rstrip("\n")
        fields = dict(re.findall(r"^(\S+): (.*)$", control, re.MULTILINE))
        names.append(f"{fields['Package']}={fields['Version']}")
        blocks.append(
            f"{control}\nFilename: ./{deb.name}\nSize: {deb.size}\nSHA256: {deb.sha256}\n"
        )
    (folder / "Packages").write_text("\n".join(blocks))
    return names


if __name__ == "__main__":
    sys.exit(run("debs", main))
