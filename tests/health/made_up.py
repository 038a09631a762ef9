"""Machines that are made up: folders that look like ``/proc`` and ``/sys`` of one."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from qrobot.health import Finding
from qrobot.health.system import Machine, system_findings

__all__ = ["ASIMD_CRC", "LSE", "PI4", "machine", "no_tool", "told", "vcgencmd"]

PI4 = {
    "proc/cpuinfo": "processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd08\n"
    "Model\t\t: Raspberry Pi 4 Model B Rev 1.4\n",
    "proc/meminfo": "MemTotal:        3884092 kB\nMemFree:  100 kB\nMemAvailable:    3145728 kB\n"
    "SwapTotal:       524288 kB\nSwapFree:        524288 kB\n",
    "proc/device-tree/model": "Raspberry Pi 4 Model B Rev 1.4\0",
    "proc/device-tree/serial-number": "10000000abcdef01\0",
    "proc/sys/kernel/arch": "aarch64\n",
    "etc/os-release": 'NAME="Debian"\nPRETTY_NAME="Debian GNU/Linux 12 (bookworm)"\n',
    "etc/machine-id": "0123456789abcdef0123456789abcdef\n",
    "sys/class/thermal/thermal_zone0/type": "cpu-thermal\n",
    "sys/class/thermal/thermal_zone0/temp": "51608\n",
}

ASIMD_CRC = 1 << 1 | 1 << 7
LSE = 1 << 8


@pytest.fixture
def no_tool(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Let nothing on the PATH be found but what a test puts there."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    return folder


def machine(root: Path, files: dict[str, str | bytes] | None = None, **facts: Any) -> Machine:
    for name, text in (PI4 if files is None else files).items():
        path = root / "root" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    (root / "root").mkdir(exist_ok=True)
    known: dict[str, Any] = {
        "root": root / "root",
        "architecture": "aarch64",
        "bits": 64,
        "page_bytes": 4096,
        "hwcap": ASIMD_CRC,
        "python": (3, 11, 2),
        "implementation": "CPython",
        "libc": "glibc 2.36",
        "cores": 4,
        "folder": root,
        "now": datetime(2026, 11, 22, tzinfo=UTC),
    }
    return Machine(**known | facts)


def told(one: Machine) -> dict[str, Finding]:
    found = {finding.name: finding for finding in system_findings(one)}
    for finding in found.values():
        assert finding.message
        assert "\n" not in finding.message
        json.dumps(finding.to_dict(), allow_nan=False)
    return found


def vcgencmd(folder: Path, script: str) -> None:
    tool = folder / "vcgencmd"
    tool.write_text(f"#!/bin/sh\n{script}\n")
    tool.chmod(0o755)
