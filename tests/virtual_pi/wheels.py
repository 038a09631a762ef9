"""Wheels of qRobot for the proof: this checkout's, a next version, and one that is broken."""

from __future__ import annotations

import base64
import hashlib
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path


def build(root: Path, folder: Path) -> Path:
    """Build this checkout's wheel once; the proof uses one and the same throughout."""
    found = sorted(folder.glob("qrobot-*.whl"))
    if not found:
        subprocess.run(
            [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "-d", folder],
            cwd=root, check=True, capture_output=True,
        )  # fmt: skip
        found = sorted(folder.glob("qrobot-*.whl"))
    return found[0]


def rewritten(
    wheel: Path, folder: Path, version: str, change: Callable[[str, bytes], bytes]
) -> Path:
    """Return a wheel of another version whose files went through a function.

    It is a proper wheel: its RECORD fits, so only what it does tells that it is broken.
    """
    old = wheel.name.split("-")[1]
    target = folder / wheel.name.replace(f"-{old}-", f"-{version}-", 1)
    folder.mkdir(parents=True, exist_ok=True)
    record = []
    with (
        zipfile.ZipFile(wheel) as source,
        zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as out,
    ):
        for name in source.namelist():
            if name.endswith("/RECORD"):
                continue
            data = source.read(name)
            if name.endswith((".dist-info/METADATA", "qrobot/_version.py")):
                data = data.replace(old.encode(), version.encode(), 1)
            data = change(name, data)
            new = name.replace(f"qrobot-{old}.dist-info", f"qrobot-{version}.dist-info")
            out.writestr(new, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{new},sha256={digest},{len(data)}")
        home = f"qrobot-{version}.dist-info/RECORD"
        out.writestr(home, "\n".join([*record, f"{home},,"]) + "\n")
    return target
