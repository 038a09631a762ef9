"""What the kernel tells of this machine: memory, a container's limit, cores, processor.

Functions that take a root read below it, so that tests can lay out a machine of their own.
"""

from __future__ import annotations

import os
import re
import sys
from contextlib import suppress
from pathlib import Path

__all__ = [
    "available_memory",
    "container_memory",
    "peak_memory",
    "read_cpuinfo",
    "read_system_file",
    "slowdown",
    "usable_cores",
]

MOST = 2**18
"""Bytes that are read of one file; those of /proc that matter are far smaller."""

ROOT = Path("/")

CGROUPS = (
    ("memory.max", "memory.current", "memory.stat", "inactive_file"),
    ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes", "memory/memory.stat",
     "total_inactive_file"),
)  # fmt: skip
"""Version 2 and version 1 of control groups: the limit (``max`` without one), the use, and the
part of the use that is a cache of files, which the kernel gives back before anything is killed."""


def read_system_file(path: Path) -> str | None:
    """Return what a file of the kernel holds, None when it cannot be read."""
    with suppress(OSError, ValueError), path.open("rb") as file:
        return file.read(MOST).decode(errors="replace").replace("\0", "").strip()
    return None


def usable_cores() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def slowdown() -> float:
    """Return by how much other programs slow this one down: those that want to run, per core."""
    return max(1.0, os.getloadavg()[0] / usable_cores())


def peak_memory() -> int:
    """Return the largest resident memory of this program so far, in bytes.

    On Linux `getrusage` starts at the size of the process that started this one, so a large parent
    would show as a large program; ``VmHWM`` begins anew. Under an emulator of processes
    (qemu-user) it is the emulator's memory, program and translations together.
    """
    status = read_system_file(ROOT / "proc/self/status") or ""
    if found := re.search(r"^VmHWM:\s+(\d+) kB$", status, re.MULTILINE):
        return int(found[1]) * 1024
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def available_memory() -> int:
    """Return the bytes that can be allocated without swapping, within a container's limit."""
    import psutil

    room = int(psutil.virtual_memory().available)
    limit, used = container_memory()
    return room if limit is None else min(room, max(limit - used, 0))


def container_memory(root: Path = ROOT) -> tuple[int | None, int]:
    """Return the container's limit, None without one, and what programs hold of it, in bytes."""
    groups = root / "sys/fs/cgroup"
    for most, now, statistics, cache in CGROUPS:
        limit, used = (_number(groups / name) for name in (most, now))
        if limit is not None:
            text = read_system_file(groups / statistics) or ""
            found = re.search(rf"^{cache} (\d{{1,18}})$", text, re.MULTILINE)
            return limit, max(0, (used or 0) - (int(found[1]) if found else 0))
    return None, 0


def _number(path: Path) -> int | None:
    with suppress(ValueError):
        return int(read_system_file(path) or "")
    return None


def read_cpuinfo(root: Path = ROOT) -> dict[str, str]:
    """Return the entries of /proc/cpuinfo, of the first processor where each has its own."""
    entries: dict[str, str] = {}
    for line in (read_system_file(root / "proc/cpuinfo") or "").splitlines():
        name, _, value = line.partition(":")
        entries.setdefault(name.strip(), value.strip())
    entries.pop("", None)
    return entries
