"""Wheels that no release needs any more."""

from __future__ import annotations

import re
from pathlib import Path


def wheel_key(name: str, version: str) -> tuple[str, str]:
    """Name and version in one spelling: ``Foo_Bar``, ``1.0`` are ``foo-bar``, ``1``."""
    plain = re.sub(r"(\.0)+(?![.\d])", "", version.lower().replace("_", "-"), count=1)
    return re.sub(r"[-_.]+", "-", name).lower(), plain


def unneeded(wheels: Path, locks: list[Path]) -> list[Path]:
    """Return the wheels, and parts of wheels, that no lock names; none when a lock is missing."""
    needed = set()
    for lock in locks:
        try:
            text = lock.read_text(encoding="utf-8")
        except OSError:
            return []  # what a damaged release needs is not known
        for package, version in re.findall(r"(?m)^([\w.-]+)(?:\[.*?\])?\s*==\s*([^\s;\\]+)", text):
            needed.add(wheel_key(package, version))
    found = []
    for path in sorted(wheels.glob("*")):
        parts = path.name.split("-")
        wheel = path.suffix == ".whl" and len(parts) >= 5
        if path.name.endswith(".part") or (wheel and wheel_key(parts[0], parts[1]) not in needed):
            found.append(path)
    return found
