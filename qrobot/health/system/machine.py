"""The raw facts of a machine, gathered once; the judging is in the files beside this one."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from qrobot._machine import read_system_file, usable_cores

__all__ = ["Machine"]

AT_HWCAP = 16
"""From linux/auxvec.h."""


def _auxiliary(kind: int) -> int:
    """Return a value of the auxiliary vector, which an emulator fills in as its CPU would."""
    with suppress(OSError, AttributeError):
        getauxval = ctypes.CDLL(None).getauxval
        getauxval.argtypes, getauxval.restype = [ctypes.c_ulong], ctypes.c_ulong
        return int(getauxval(kind))
    return 0


def _libc() -> str:
    with suppress(OSError, ValueError, AttributeError):
        return os.confstr("CS_GNU_LIBC_VERSION") or ""
    return ""


def _folder() -> Path:
    try:
        return Path.cwd()
    except OSError:  # it was removed
        return Path("/")


@dataclass(frozen=True)
class Machine:
    """What the kernel, the C library and Python say of themselves.

    Parameters
    ----------
    root
        Where ``/proc``, ``/sys`` and ``/etc`` are: another folder in tests.
    architecture
        As ``uname -m`` says it: that of the kernel, not of the programs.
    bits
        Of the programs (the userland).
    page_bytes
        Size of a memory page.
    hwcap
        The processor's features as the kernel tells this very process; 0 when unknown.
    python, implementation
        Version, and who made it.
    libc
        Such as ``glibc 2.36``; empty when unknown.
    cores
        Processors that this process may use.
    folder
        Where reports, plans and jobs would be written to.
    now
        The time by the machine's clock, UTC.
    """

    root: Path = Path("/")
    architecture: str = field(default_factory=platform.machine)
    bits: int = 64 if sys.maxsize > 2**32 else 32
    page_bytes: int = field(default_factory=lambda: os.sysconf("SC_PAGE_SIZE"))
    hwcap: int = field(default_factory=lambda: _auxiliary(AT_HWCAP))
    python: tuple[int, int, int] = sys.version_info[:3]
    implementation: str = platform.python_implementation()
    libc: str = field(default_factory=_libc)
    cores: int = field(default_factory=usable_cores)
    folder: Path = field(default_factory=_folder)
    now: datetime = field(default_factory=lambda: datetime.now(UTC))

    def text(self, path: str) -> str | None:
        """Return what a file below the root holds, None when it cannot be read."""
        return read_system_file(self.root / path)

    def number(self, path: str) -> int | None:
        """Return the whole number that a file holds."""
        with suppress(ValueError):
            return int(self.text(path) or "")
        return None

    def folders(self, pattern: str) -> list[str]:
        """Return the paths below the root that match, sorted."""
        with suppress(OSError, ValueError):
            return sorted(str(found.relative_to(self.root)) for found in self.root.glob(pattern))
        return []

    def identity(self) -> str | None:
        """Return a digest that tells this machine from others, or None.

        A digest, because the id itself is nobody's business; with the board's serial number,
        because the id is copied with a memory card.
        """
        own = self.text("etc/machine-id") or ""
        serial = self.text("proc/device-tree/serial-number") or ""
        if not own + serial:
            return None
        return hashlib.sha256(f"qrobot.health {own} {serial}".encode()).hexdigest()[:12]
