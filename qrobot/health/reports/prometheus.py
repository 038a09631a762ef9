"""A report as metrics, for the textfile collector of node_exporter."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from qrobot._files import StrPath, write_bytes_atomic
from qrobot.errors import InputError
from qrobot.health.model import Report, Standing, Status
from qrobot.health.system.board import THROTTLED

if TYPE_CHECKING:
    from prometheus_client import CollectorRegistry, Gauge

__all__ = ["metrics", "write_prometheus"]

MEBI = 2**20

GAUGES = {
    "temperature": ("temperature_celsius", "Temperature of the processor.", 1),
    "memory": ("memory_bytes", "Memory that programs may use in all.", MEBI),
    "memory-available": ("memory_available_bytes", "Memory that is free for programs.", MEBI),
    "swap-used": ("swap_used_bytes", "Swap in use.", MEBI),
    "disk-free": ("disk_free_bytes", "Free disk of the folder in use.", MEBI),
    "clock-synchronised": ("clock_synchronised", "Whether a time service keeps it right.", 1),
    "throttled": ("throttled_bits", "The bits of vcgencmd get_throttled as a number.", 1),
}
"""Finding to metric, its help, and the factor to base units."""


def metrics(report: Report) -> CollectorRegistry:
    """Return the metrics of a report in a registry of their own.

    Statuses are one series a status, 1 for the one that holds, so that a rule can name it.
    """
    from prometheus_client import CollectorRegistry, Gauge

    registry = CollectorRegistry()

    def gauge(name: str, text: str, *labels: str) -> Gauge:
        return Gauge(f"qrobot_health_{name}", text, labels, registry=registry)

    info = gauge("info", "Who made the report; always 1.", "version", "python", "machine", "model")
    info.labels(report.qrobot, report.python, report.machine, report.model or "").set(1)
    when = datetime.fromisoformat(report.made).timestamp()
    gauge("run_timestamp_seconds", "When the run began, in Unix time.").set(when)
    gauge("run_duration_seconds", "What the whole run took.").set(report.seconds)
    gauge("healthy", "1: no check is bad and the machine has no fault.").set(report.healthy)
    package = gauge("package_info", "Installed packages; always 1.", "package", "version")
    for name, version in report.versions.items():
        package.labels(name, version).set(1)

    status = gauge("check_status", "1 for the status that holds.", "check", "group", "status")
    figures = {
        "check_import_seconds": ("What the imports took.", "import_seconds", 1),
        "check_run_seconds": ("What the computation took.", "run_seconds", 1),
        "check_peak_memory_bytes": ("Largest resident memory.", "peak_mb", MEBI),
    }
    for check in report.checks:
        for one in get_args(Status):
            status.labels(check.name, check.group, one).set(check.status == one)
    for metric, (text, field, factor) in figures.items():
        series = gauge(metric, text, "check", "group")
        for check in report.checks:
            if (value := getattr(check, field)) is not None:
                series.labels(check.name, check.group).set(value * factor)
    _machine(report, gauge)
    return registry


def _machine(report: Report, gauge: Callable[..., Gauge]) -> None:
    if not report.system:
        return
    status = gauge("finding_status", "1 for the status that holds.", "finding", "status")
    for finding in report.system:
        for one in get_args(Standing):
            status.labels(finding.name, one).set(finding.status == one)
    for name, (metric, text, factor) in GAUGES.items():
        found = report.finding(name)
        if found is not None and isinstance(found.value, bool | int | float):
            gauge(metric, text).set(found.value * factor)
    found = report.finding("throttled")
    if found is not None and isinstance(found.value, int):
        series = gauge("throttled", "1 while, or since, it is so.", "condition", "when")
        for bit, condition in THROTTLED.items():
            name = condition.replace("-", "_").replace(" ", "_")
            series.labels(name, "now").set(found.value >> bit & 1)
            series.labels(name, "since_start").set(found.value >> (bit + 16) & 1)


def write_prometheus(path: StrPath, report: Report) -> None:
    """Write the metrics, the whole file or nothing.

    Raises
    ------
    InputError
        When the file cannot be written; what stood there before is untouched.
    """
    from prometheus_client import generate_latest, write_to_textfile

    registry = metrics(report)
    target = Path(os.path.realpath(path))  # a link keeps pointing to the file
    if target.exists() and not stat.S_ISREG(target.stat().st_mode):
        write_bytes_atomic(path, generate_latest(registry))  # the library would replace a device
        return
    try:
        write_to_textfile(str(target), registry)
    except (OSError, ValueError) as error:  # ValueError: no text in UTF-8
        raise InputError(
            f"cannot write {os.fspath(path)!r}: {getattr(error, 'strerror', None) or error}",
            mend="check the folder and its free space, or choose another place",
        ) from None
