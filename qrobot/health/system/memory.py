"""Memory, swap, and the disk of the folder in use."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress

import psutil

from qrobot._machine import container_memory
from qrobot.health.model import Finding
from qrobot.health.system.machine import Machine

__all__ = ["memory"]

SMALL, TIGHT = 1800, 300
"""MiB of memory in all, and available, below which there is a warning."""

SWAPPED = 0.5
"""Share of the swap in use from which there is a warning."""

LOW, FULL = 1000, 50
"""MiB of free disk: below the first a warning, below the second a fault."""


def memory(machine: Machine) -> Iterator[Finding]:
    """Find out about memory and disk."""
    sizes = _sizes(machine.text("proc/meminfo") or "")
    total, available = sizes.get("MemTotal"), sizes.get("MemAvailable")
    limit, used = container_memory(machine.root)
    limited = total is not None and limit is not None and limit // 2**20 < total
    if limited and limit is not None:
        total = limit // 2**20
        available = min(available or total, max(0, limit - used) // 2**20)
    yield _total(total, " by the container's limit" if limited else "")
    yield _available(available)
    yield _swap(sizes.get("SwapTotal"), sizes.get("SwapFree"), total)
    yield _disk(machine)


def _sizes(text: str) -> dict[str, int]:
    """Return the entries of /proc/meminfo in MiB."""
    return {
        name: int(size) // 1024
        for name, size in re.findall(r"^(\w+):\s+(\d{1,15}) kB$", text, re.MULTILINE)
    }


def _total(total: int | None, limited: str) -> Finding:
    about = ("memory", "Memory")
    if total is None:
        return Finding(*about, "unknown", None, "/proc/meminfo does not tell", "MiB")
    if total < SMALL:
        text = f"little{limited}: plan with the classical backends, or use a board with 4 GB"
        return Finding(*about, "warning", total, text, "MiB")
    return Finding(*about, "good", total, f"in all{limited}", "MiB")


def _available(available: int | None) -> Finding:
    about = ("memory-available", "Memory available")
    if available is None:
        return Finding(*about, "unknown", None, "/proc/meminfo does not tell", "MiB", steady=False)
    if available < TIGHT:
        text = "little: a stack may be killed; end other programs"
        return Finding(*about, "warning", available, text, "MiB", steady=False)
    return Finding(*about, "good", available, "for programs", "MiB", steady=False)


def _swap(total: int | None, free: int | None, memory_mb: int | None) -> Finding:
    about = ("swap-used", "Swap used")
    if total is None or free is None:
        return Finding(*about, "unknown", None, "/proc/meminfo does not tell", "MiB", steady=False)
    used = max(0, total - free)
    if used > SWAPPED * total:
        text = f"of {total} MiB: memory is short; end other programs"
        return Finding(*about, "warning", used, text, "MiB", steady=False)
    if total:
        return Finding(*about, "good", used, f"of {total} MiB", "MiB", steady=False)
    if memory_mb is not None and memory_mb < SMALL:
        text = "there is none and memory is short: add 1 GB of swap (zram or a file)"
        return Finding(*about, "warning", 0, text, "MiB", steady=False)
    return Finding(*about, "good", 0, "there is none", "MiB", steady=False)


def _disk(machine: Machine) -> Finding:
    about = ("disk-free", "Disk free")
    free, fixed = None, False
    with suppress(OSError):
        free = psutil.disk_usage(str(machine.folder)).free // 2**20
        fixed = bool(os.statvfs(machine.folder).f_flag & os.ST_RDONLY)
    if free is None:
        text = f"{machine.folder} cannot be asked"
        return Finding(*about, "unknown", None, text, "MiB", steady=False)
    where = f"below {machine.folder}"
    if fixed:  # as in a container: nobody means to write here, however little room there is
        text = f"{where}: read-only, so reports and jobs need another folder"
        return Finding(*about, "good", free, text, "MiB", steady=False)
    if free < FULL:
        text = f"{where}: full, so plans and jobs cannot be kept; free some space"
        return Finding(*about, "fault", free, text, "MiB", steady=False)
    if free < LOW:
        text = f"{where}: little; free some space"
        return Finding(*about, "warning", free, text, "MiB", steady=False)
    return Finding(*about, "good", free, where, "MiB", steady=False)
