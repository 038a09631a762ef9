"""What the tests of the collector of wheels share: tiny wheels, a folder as index."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import json
import os
import re
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "ansible/controller/wheelhouse.py"


def python_with_pip(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A Python with pip that sees what this one sees."""
    if importlib.util.find_spec("pip"):
        return sys.executable
    folder = tmp_path_factory.mktemp("pip")
    made = subprocess.run(
        [sys.executable, "-m", "venv", folder], capture_output=True, text=True, check=False
    )
    if made.returncode:
        pytest.skip("no pip here, and venv cannot make one")
    purelib = sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)})
    Path(purelib, "ours.pth").write_text(sysconfig.get_path("purelib") + "\n")
    # venv brings an old setuptools on 3.11, which would hide the one of the lock.
    uninstall = [folder / "bin/python", "-m", "pip", "uninstall", "--quiet", "--yes", "setuptools"]
    subprocess.run(uninstall, capture_output=True, check=True)
    return str(folder / "bin/python")


def built_by(name: str) -> None:
    """Skip where the build tool is not the one of the lock."""
    locked = re.search(rf"^{name}==(\S+)", (ROOT / "locks/build.txt").read_text(), re.MULTILINE)
    assert locked
    try:
        if importlib.metadata.version(name) == locked[1]:
            return
    except importlib.metadata.PackageNotFoundError:
        pass
    pytest.skip(f"{name} {locked[1]} of locks/build.txt is not installed here")


def wheel(folder: Path, name: str, tag: str = "py3-none-any", more: str = "", **files: str) -> Path:
    """Write a wheel, version 1.0, with one module and what else is given."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}-1.0-{tag}.whl"
    info = f"{name}-1.0.dist-info"
    files |= {
        f"{name}.py": f"tag = {tag!r}{more}\n",
        # Some packages guess where they end; the lock knows better.
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n"
        "Requires-Python: >=3.8,<3.11\n",
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: {tag}\n",
        f"{info}/RECORD": "".join(f"{file},,\n" for file in files),
    }
    with zipfile.ZipFile(path, "w") as archive:
        for file, text in files.items():
            archive.writestr(zipfile.ZipInfo(file), text)
    return path


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def pin(name: str, *paths: Path, marker: str = "") -> str:
    hashes = " \\\n".join(f"    --hash=sha256:{digest(path)}" for path in paths)
    return f"{name}==1.0{marker} \\\n{hashes}\n    # via\n    #   made up\n"


class House:
    """A lock, an index in a folder, and the program that collects from it."""

    def __init__(self, folder: Path, python: str) -> None:
        self.folder, self.python = folder, python
        self.index, self.dest = folder / "index", folder / "house"
        self.lock, self.uv_lock = folder / "lock.txt", folder / "uv.txt"
        program = {"uv-1.0.data/scripts/uv": "the program"}
        uv = [wheel(self.index, "uv", f"py3-none-manylinux_2_17_{m}.manylinux2014_{m}", **program)
              for m in ("aarch64", "x86_64")]  # fmt: skip
        self.uv_lock.write_text(pin("uv", *uv))
        self.own = wheel(folder, "qrobot")

    def start(self, *words: str, own: bool = False, **env: str) -> subprocess.Popen[str]:
        clean = {key: value for key, value in os.environ.items() if not key.startswith("PIP_")}
        clean |= {"PIP_CONFIG_FILE": os.devnull, "PIP_NO_CACHE_DIR": "1", "PYTHONPATH": str(ROOT)}
        here = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(self.index)}
        given = [] if own else ["--wheel", str(self.own)]
        return subprocess.Popen(
            [self.python, PROGRAM, "--json", "--lock", self.lock, "--uv-lock", self.uv_lock,
             "--dest", self.dest, *given, *words],
            env=clean | (env or here), text=True, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip

    def run(self, *words: str, own: bool = False, **env: str) -> tuple[dict[str, Any], str]:
        process = self.start(*words, own=own, **env)
        out, told = process.communicate()
        assert process.returncode == 0, told
        return json.loads(out), told

    def refused(self, code: int, *words: str, **env: str) -> str:
        """Return the one sentence of a run that cannot do its work."""
        process = self.start(*words, **env)
        out, told = process.communicate()
        assert (process.returncode, out) == (code, "")
        assert "Traceback" not in told
        return told.splitlines()[-1]

    @property
    def files(self) -> set[str]:
        return {path.name for path in (self.dest / "files").iterdir()}


def simple(house: House, *names: str) -> list[Path]:
    paths = [wheel(house.index, name) for name in names]
    house.lock.write_text("".join(map(pin, names, paths)))
    return paths
