"""A lock as one machine sees it: the pins whose markers hold there."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

MACHINE = {"amd64": "x86_64", "arm64": "aarch64"}
PIN = re.compile(r"^(?P<requirement>[A-Za-z0-9][^\\#\n]*==[^\\#\n]*)", re.MULTILINE)
HASH = re.compile(r"--hash=(sha256:[0-9a-f]{64})")


@dataclass(frozen=True)
class Pin:
    name: str
    version: str
    hashes: tuple[str, ...]
    text: str


def pins(lock: str, arch: str, python: str | None = None) -> Iterator[Pin]:
    """Yield what a lock pins for a machine, ``arm64`` or ``amd64``, and a Python: ours if none."""
    python = python or f"{sys.version_info[0]}.{sys.version_info[1]}"
    environment = {
        "python_version": python,
        "python_full_version": f"{python}.0",
        "platform_machine": MACHINE[arch],
        "platform_system": "Linux",
        "sys_platform": "linux",
        "os_name": "posix",
        "implementation_name": "cpython",
        "platform_python_implementation": "CPython",
    }
    starts = [*PIN.finditer(lock)]
    ends = [*(match.start() for match in starts), len(lock)][1:]
    for match, end in zip(starts, ends, strict=True):
        pin = Requirement(match["requirement"].strip())
        if pin.marker is None or pin.marker.evaluate(environment):
            text = lock[match.start() : end]
            version = next(iter(pin.specifier)).version
            yield Pin(canonicalize_name(pin.name), version, tuple(HASH.findall(text)), text)
