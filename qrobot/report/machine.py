"""What machine something was measured on."""

from __future__ import annotations

import os
import platform
from typing import Any

import psutil

from qrobot._extras import distribution_version
from qrobot._machine import read_cpuinfo
from qrobot._version import __version__

__all__ = ["machine"]

PACKAGES = (
    "numpy", "dimod", "dwave-samplers", "pyvrp", "ortools", "numba", "qiskit", "qiskit-aer",
    "pennylane", "pennylane-lightning", "amazon-braket-sdk", "dwave-system",
)  # fmt: skip


def machine() -> dict[str, Any]:
    """Return processor, memory, system and the versions that matter, as plain data."""
    entries = read_cpuinfo()
    named = entries.get("model name") or entries.get("Model")
    return {
        "processor": named or platform.processor() or "unknown",
        "architecture": platform.machine(),
        "cores": os.cpu_count(),
        "memory_gb": round(psutil.virtual_memory().total / 1e9, 1),
        "system": platform.platform(),
        "python": platform.python_version(),
        "qrobot": __version__,
        "packages": {name: version for name in PACKAGES if (version := distribution_version(name))},
    }
