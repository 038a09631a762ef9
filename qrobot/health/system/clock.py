"""The clock: whether it is kept right by others, and whether it can be right at all."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import suppress

from qrobot.health.model import Finding
from qrobot.health.system.machine import Machine

__all__ = ["clock", "synchronised"]

STA_UNSYNC, TIME_ERROR = 0x40, 5
"""From linux/timex.h."""

BEGAN = 2026
"""A clock that shows an earlier year is wrong: this code is not older."""


class _Timex(ctypes.Structure):
    """The beginning of ``struct timex``; what follows is only room for the kernel to fill."""

    _fields_ = (
        ("modes", ctypes.c_uint),
        ("offset", ctypes.c_long),
        ("freq", ctypes.c_long),
        ("maxerror", ctypes.c_long),
        ("esterror", ctypes.c_long),
        ("status", ctypes.c_int),
        ("rest", ctypes.c_byte * 512),
    )


def synchronised() -> bool | None:
    """Return whether the kernel's clock is kept right by a time service; None: not told."""
    with suppress(OSError, AttributeError):
        adjtimex = ctypes.CDLL(None).adjtimex
        adjtimex.argtypes, adjtimex.restype = [ctypes.POINTER(_Timex)], ctypes.c_int
        answer = _Timex(modes=0)  # 0: only ask
        state = int(adjtimex(ctypes.byref(answer)))
        if state >= 0:
            return state != TIME_ERROR and not answer.status & STA_UNSYNC
    return None


def clock(machine: Machine) -> Iterator[Finding]:
    """Find out about the clock."""
    about = ("clock-synchronised", "Clock synchronised")
    if machine.now.year < BEGAN:
        text = (
            f"it shows {machine.now:%Y-%m-%d}: services will refuse us; "
            "run sudo timedatectl set-ntp true, and wait for the network"
        )
        yield Finding(*about, "warning", False, text, steady=False)
        return
    right = synchronised()
    if right is None:
        yield Finding(*about, "unknown", None, "the kernel does not tell", steady=False)
    elif right:
        yield Finding(*about, "good", True, "a time service keeps it right", steady=False)
    else:
        text = "no time service keeps it right; run sudo timedatectl set-ntp true"
        yield Finding(*about, "warning", False, text, steady=False)
