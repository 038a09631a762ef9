"""System, kernel, container, Python, C library; and whether the clock is right."""

from __future__ import annotations

import ctypes
import platform
import re
from collections.abc import Iterator
from contextlib import suppress
from datetime import date
from functools import partial

from qrobot.health.model import Finding
from qrobot.health.system.machine import Machine

__all__ = ["clock", "software", "synchronised"]

FIRST, LAST = (3, 11), (3, 13)
"""Versions of Python that qRobot is tested on."""

END = {(3, 11): date(2027, 10, 31), (3, 12): date(2028, 10, 31), (3, 13): date(2029, 10, 31)}
"""When Python's own makers stop to close security holes."""

GLIBC = (2, 28)
"""What the compiled packages are built for: manylinux_2_28."""

STA_UNSYNC, TIME_ERROR = 0x40, 5
"""From linux/timex.h."""

BEGAN = 2026
"""A clock that shows an earlier year is wrong: this code is not older."""


def software(machine: Machine) -> Iterator[Finding]:
    """Find out about the system."""
    yield _system(machine)
    yield Finding("kernel", "Kernel", "good", platform.release() or None, "as it names itself")
    yield _container(machine)
    yield _python(machine)
    yield _libc(machine)


def _system(machine: Machine) -> Finding:
    text = machine.text("etc/os-release") or machine.text("usr/lib/os-release") or ""
    found = re.search(r"^PRETTY_NAME=[\"']?([^\"'\n]*)", text, re.MULTILINE)
    if not found or not found[1].strip():
        return Finding("os", "System", "unknown", None, "/etc/os-release does not name it")
    return Finding("os", "System", "good", found[1].strip(), "as /etc/os-release names it")


def _container(machine: Machine) -> Finding:
    kind = "none"
    first = machine.text("run/systemd/container") or ""
    groups = machine.text("proc/1/cgroup") or ""
    if (machine.root / ".dockerenv").exists():
        kind = "docker"
    elif (machine.root / "run/.containerenv").exists():
        kind = "podman"
    elif first:
        kind = first.split()[0]
    elif found := re.search(r"docker|kubepods|lxc|libpod", groups):
        kind = found[0]
    text = "not in a container" if kind == "none" else "memory and clock are the host's"
    return Finding("container", "Container", "good", kind, text)


def _python(machine: Machine) -> Finding:
    version = ".".join(map(str, machine.python))
    about, series = ("python", "Python"), machine.python[:2]
    supported = f"{FIRST[0]}.{FIRST[1]} to {LAST[0]}.{LAST[1]}"
    if machine.implementation != "CPython":
        text = f"{machine.implementation} has no compiled packages; use CPython {supported}"
        return Finding(*about, "fault", version, text)
    if series < FIRST:
        return Finding(*about, "fault", version, f"too old; use Python {supported}")
    if series > LAST:
        text = f"newer than what is tested; use Python {supported} when a stack is missing"
        return Finding(*about, "warning", version, text)
    if machine.now.date() > END[series]:
        text = f"no security updates since {END[series]}; use a newer one"
        return Finding(*about, "warning", version, text)
    return Finding(*about, "good", version, f"has security updates until {END[series]}")


def _libc(machine: Machine) -> Finding:
    fact = partial(Finding, "libc", "C library")
    wanted = f"compiled packages need glibc {GLIBC[0]}.{GLIBC[1]} or newer (manylinux_2_28)"
    found = re.match(r"glibc (\d+)\.(\d+)", machine.libc)
    if found:
        old = (int(found[1]), int(found[2])) < GLIBC
        text = f"too old: {wanted}; use a newer system" if old else wanted
        return fact("fault" if old else "good", machine.libc, text)
    if machine.folders("lib/ld-musl-*"):
        return fact("fault", "musl", f"{wanted}; use Debian instead of Alpine")
    return fact("unknown", machine.libc or None, wanted)


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
    fact = partial(Finding, "clock-synchronised", "Clock synchronised", steady=False)
    if machine.now.year < BEGAN:
        text = (
            f"it shows {machine.now:%Y-%m-%d}: services will refuse us; "
            "run sudo timedatectl set-ntp true, and wait for the network"
        )
        yield fact("warning", False, text)
        return
    right = synchronised()
    if right is None:
        yield fact("unknown", None, "the kernel does not tell")
    elif right:
        yield fact("good", True, "a time service keeps it right")
    else:
        text = "no time service keeps it right; run sudo timedatectl set-ntp true"
        yield fact("warning", False, text)
