"""What machine something was measured on."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from pathlib import Path
from typing import Any

import psutil

from qrobot._version import __version__

__all__ = ["machine"]

PACKAGES = (
    "numpy", "dimod", "dwave-samplers", "pyvrp", "ortools", "numba", "qiskit", "qiskit-aer",
    "pennylane", "pennylane-lightning", "amazon-braket-sdk", "dwave-system",
)  # fmt: skip


def machine() -> dict[str, Any]:
    """Return processor, memory, system and the versions that matter, as plain data."""
    return {
        "processor": _processor(),
        "architecture": platform.machine(),
        "cores": os.cpu_count(),
        "memory_gb": round(psutil.virtual_memory().total / 1e9, 1),
        "system": platform.platform(),
        "python": platform.python_version(),
        "qrobot": __version__,
        "packages": {name: version for name in PACKAGES if (version := _version(name))},
    }


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or "unknown"
    for line in text.splitlines():
        name, _, value = line.partition(":")
        if name.strip() in {"model name", "Model"}:
            return value.strip()
    return platform.processor() or "unknown"


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None
