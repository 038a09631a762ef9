"""The runner of every study: each result is kept as soon as it is there, and Ctrl-C ends it."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import psutil

from qrobot._extras import distribution_version
from qrobot._machine import read_cpuinfo
from qrobot._version import __version__

__all__ = ["Part", "machine", "measured_here", "run_parts"]

T = TypeVar("T")

PACKAGES = (
    "numpy", "dimod", "dwave-samplers", "pyvrp", "ortools", "numba", "qiskit", "qiskit-aer",
    "pennylane", "pennylane-lightning", "amazon-braket-sdk", "dwave-system",
)  # fmt: skip


@dataclass(frozen=True)
class Part(Generic[T]):
    """One list of a report, and what fills it.

    Parameters
    ----------
    name
        Key of the list in the report.
    results
        What is measured, one by one.
    plain
        A result as plain data.
    on_result
        Called with each result when it is kept.
    """

    name: str
    results: Iterable[T]
    plain: Callable[[T], dict[str, Any]]
    on_result: Callable[[T], None] | None = None


def machine() -> dict[str, Any]:
    """Return what something is measured on: processor, memory, system and versions."""
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


def measured_here() -> dict[str, Any]:
    """Return the machine and the time, as every report carries them."""
    return {"machine": machine(), "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())}


def run_parts(
    report: dict[str, Any],
    parts: Iterable[Part[Any]],
    save: Callable[[], None],
    interrupted: Callable[[], bool] | None = None,
) -> None:
    """Fill a report part by part; when it is interrupted, it keeps what it has and says so.

    Parameters
    ----------
    report
        With an empty list for each part.
    parts
        In their sequence.
    save
        Called after each result, and once more when the run is interrupted.
    interrupted
        Asked after each result; True ends the run as Ctrl-C does.
    """
    try:
        for part in parts:
            for result in part.results:
                report[part.name].append(part.plain(result))
                save()
                if part.on_result is not None:
                    part.on_result(result)
                if interrupted is not None and interrupted():
                    raise KeyboardInterrupt
    except KeyboardInterrupt:
        report["interrupted"] = True
        save()
