"""Memory, swap, and the disk of the folder in use."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from functools import partial

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

MEMORY = partial(Finding, "memory", "Memory", unit="MiB")
AVAILABLE = partial(Finding, "memory-available", "Memory available", unit="MiB", steady=False)
SWAP = partial(Finding, "swap-used", "Swap used", unit="MiB", steady=False)
DISK = partial(Finding, "disk-free", "Disk free", unit="MiB", steady=False)


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
    if total is None:
        return MEMORY("unknown", None, "/proc/meminfo does not tell")
    if total < SMALL:
        text = f"little{limited}: plan with the classical backends, or use a board with 4 GB"
        return MEMORY("warning", total, text)
    return MEMORY("good", total, f"in all{limited}")


def _available(available: int | None) -> Finding:
    if available is None:
        return AVAILABLE("unknown", None, "/proc/meminfo does not tell")
    if available < TIGHT:
        return AVAILABLE("warning", available, "little: a stack may be killed; end other programs")
    return AVAILABLE("good", available, "for programs")


def _swap(total: int | None, free: int | None, memory_mb: int | None) -> Finding:
    if total is None or free is None:
        return SWAP("unknown", None, "/proc/meminfo does not tell")
    used = max(0, total - free)
    if used > SWAPPED * total:
        return SWAP("warning", used, f"of {total} MiB: memory is short; end other programs")
    if total:
        return SWAP("good", used, f"of {total} MiB")
    if memory_mb is not None and memory_mb < SMALL:
        text = "there is none and memory is short: add 1 GB of swap (zram or a file)"
        return SWAP("warning", 0, text)
    return SWAP("good", 0, "there is none")


def _disk(machine: Machine) -> Finding:
    free, fixed = None, False
    with suppress(OSError):
        free = psutil.disk_usage(str(machine.folder)).free // 2**20
        fixed = bool(os.statvfs(machine.folder).f_flag & os.ST_RDONLY)
    if free is None:
        return DISK("unknown", None, f"{machine.folder} cannot be asked")
    where = f"below {machine.folder}"
    if fixed:  # as in a container: nobody means to write here, however little room there is
        return DISK("good", free, f"{where}: read-only, so reports and jobs need another folder")
    if free < FULL:
        text = f"{where}: full, so plans and jobs cannot be kept; free some space"
        return DISK("fault", free, text)
    if free < LOW:
        return DISK("warning", free, f"{where}: little; free some space")
    return DISK("good", free, where)
