"""The locks: which there are, for whom, and what they pin on a machine.

Whoever builds an image, collects wheels for a robot or compares robots with their lock asks here.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "LOCKS",
    "MACHINES",
    "PROFILES",
    "PYTHONS",
    "ROBOTS",
    "Pin",
    "environment",
    "lock_of",
    "pins",
]

LOCKS = Path(__file__).resolve().parent

PROFILES = {
    "base": (),
    "solver": ("solver",),
    "edge": ("edge",),
    "full": ("full",),
    "dev": ("solver", "excel", "maps", "dev", "docs", "provision"),
}
"""The profiles that have a lock, NAME.txt, and the extras of qRobot that it holds."""

ROBOTS = {"solver": "solver", "edge": "edge", "lab": "full"}
"""What a robot or an image can be, by the name that its user gives, and the profile of its lock."""

PYTHONS = ("3.11", "3.13")
"""Those of Debian bookworm and trixie."""

MACHINES = {"arm64": "aarch64", "amd64": "x86_64"}
"""Debian's and Docker's names, and the kernel's."""

PIN = re.compile(r"^(?P<requirement>[A-Za-z0-9][^\\#\n]*==[^\\#\n]*)", re.MULTILINE)
HASH = re.compile(r"--hash=(sha256:[0-9a-f]{64})")


@dataclass(frozen=True)
class Pin:
    """One version of one package.

    Parameters
    ----------
    name, version
        The name as pip writes it.
    extras
        Of that package.
    hashes
        Of the files that may be installed, as ``sha256:...``.
    text
        The lines of the lock.
    """

    name: str
    version: str
    extras: tuple[str, ...]
    hashes: tuple[str, ...]
    text: str


def lock_of(robot: str) -> str:
    """Return the file name of the lock of a robot or an image: solver, edge or lab."""
    return f"{ROBOTS[robot]}.txt"


def environment(machine: str, python: str) -> dict[str, str]:
    """Return the values of markers on Linux, for the kernel's name of a machine."""
    return {
        "python_version": python,
        "python_full_version": f"{python}.2",
        "platform_machine": machine,
        "platform_system": "Linux",
        "sys_platform": "linux",
        "os_name": "posix",
        "implementation_name": "cpython",
        "platform_python_implementation": "CPython",
    }


def pins(lock: str, machine: str, python: str | None = None) -> Iterator[Pin]:
    """Yield what the text of a lock pins for a machine and a Python: ours when none is named."""
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    here = environment(machine, python or f"{sys.version_info[0]}.{sys.version_info[1]}")
    starts = [*PIN.finditer(lock)]
    ends = [*(match.start() for match in starts), len(lock)][1:]
    for match, end in zip(starts, ends, strict=True):
        pin = Requirement(match["requirement"].strip())
        if pin.marker is None or pin.marker.evaluate(here):
            text = lock[match.start() : end]
            version = next(iter(pin.specifier)).version
            name, extras = canonicalize_name(pin.name), tuple(sorted(pin.extras))
            yield Pin(name, version, extras, tuple(HASH.findall(text)), text)
