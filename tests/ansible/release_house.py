"""What the tests of releases share: tiny real wheels, the installer, the playbook program."""

from __future__ import annotations

import base64
import hashlib
import importlib
import os
import shutil
import sys
import zipfile
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

PLUGINS = Path(__file__).resolve().parents[2] / "ansible" / "plugins"
STARTER = PLUGINS.parent / "roles/runtime/files/__main__.py"


def installed(folder: Path) -> Path:
    """Lay the program out as the role does; Python runs the folder."""
    folder.mkdir()
    (folder / "__main__.py").symlink_to(STARTER)
    (folder / "qrobot_release").symlink_to(PLUGINS / "module_utils/qrobot_release")
    return folder


def load() -> ModuleType:
    """The module of the releases; it imports nothing of Ansible."""
    return importlib.import_module("qrobot_release")


def program(name: str, *more: str) -> str:
    """Path of a program; skips the test where it is absent."""
    found = [shutil.which(name), f"{sys.prefix}/bin/{name}", *more]
    for path in found:
        if path and os.access(path, os.X_OK):
            return path
    pytest.skip(f"{name} is not installed")


def uv() -> str:
    """Path of uv; skips the test where it is absent."""
    return program("uv", "/opt/tools/bin/uv")


def wheel(folder: Path, name: str, version: str, text: str = "x = 1\n") -> dict[str, Any]:
    """Make a wheel of one module, with a program of the same name; returns its entry."""
    folder.mkdir(parents=True, exist_ok=True)
    info = f"{name}-{version}.dist-info"
    files = {
        f"{name}.py": text + "def main():\n    print(__file__)\n",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{info}/entry_points.txt": f"[console_scripts]\n{name} = {name}:main\n",
    }
    record = ""
    for path, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content.encode()).digest())
        record += f"{path},sha256={digest.decode().rstrip('=')},{len(content)}\n"
    files[f"{info}/RECORD"] = record + f"{info}/RECORD,,\n"
    target = folder / f"{name}-{version}-py3-none-any.whl"
    with zipfile.ZipFile(target, "w") as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path, (2026, 1, 1, 0, 0, 0)), content)
    return entry(target)


def entry(path: Path) -> dict[str, Any]:
    """Name, size and hash of a file."""
    content = path.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    return {"name": path.name, "size": len(content), "sha256": digest}


def lock(*wheels: dict[str, Any]) -> str:
    """Requirements of wheels, as a lock writes them."""
    lines = []
    for one in wheels:
        name, version = one["name"].split("-")[:2]
        lines.append(f"{name}=={version} \\\n    --hash=sha256:{one['sha256']}\n")
    return "".join(lines)
