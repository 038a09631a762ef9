"""A report in files: JSON, a page, JUnit XML for CI servers, metrics for node_exporter's collector.

JUnit XML has no standard; this keeps to what Jenkins' schema allows and GitLab, GitHub's actions
and others read: properties and counts on the suites, ``failure``, ``error`` and ``skipped`` in the
cases.
"""

from __future__ import annotations

import os
import re
import stat
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from qrobot._files import StrPath, write_bytes_atomic, write_text_atomic
from qrobot._json import json_text
from qrobot.errors import InputError
from qrobot.health.model import CheckResult, Finding, FindingStatus, Report, Status
from qrobot.health.reports.compare import Comparison
from qrobot.health.reports.fleet import FleetHealth
from qrobot.health.reports.summary import (
    attention,
    checks_table,
    machine_line,
    system_table,
    totals_line,
    when,
)
from qrobot.health.system.hardware import THROTTLED
from qrobot.pages import Bar, render

__all__ = [
    "GAUGES",
    "as_json",
    "document",
    "fleet_html",
    "html",
    "junit",
    "metrics",
    "save",
    "write_prometheus",
]

if TYPE_CHECKING:
    from prometheus_client import CollectorRegistry, Gauge

HERE = Path(__file__).parent

FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, escaped or not."""

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


def document(report: Report, comparison: Comparison | None = None) -> dict[str, Any]:
    """Return plain data, with the comparison as a field of its own where there is one."""
    data = report.to_dict()
    if comparison is not None:
        data["comparison"] = comparison.to_dict()
    return data


def as_json(report: Report, comparison: Comparison | None = None) -> str:
    """Return the document as text."""
    return json_text(document(report, comparison), indent=1, ensure_ascii=False)


def save(
    report: Report,
    comparison: Comparison | None = None,
    *,
    output: StrPath | None = None,
    junit_path: StrPath | None = None,
    html_path: StrPath | None = None,
    prometheus: StrPath | None = None,
) -> list[InputError]:
    """Write every format that has a path, each whole or not at all.

    Returns
    -------
    list of InputError
        One for each that could not be written: what stood there before is untouched.
    """
    formats: list[tuple[StrPath | None, Callable[[StrPath], None]]] = [
        (output, lambda path: write_text_atomic(path, as_json(report, comparison) + "\n")),
        (junit_path, lambda path: write_text_atomic(path, junit(report))),
        (html_path, lambda path: write_text_atomic(path, html(report, comparison))),
        (prometheus, lambda path: write_prometheus(path, report)),
    ]
    troubles = []
    for path, write in formats:
        if path is not None:
            try:
                write(path)
            except InputError as error:
                troubles.append(error)
    return troubles


def html(report: Report, comparison: Comparison | None = None) -> str:
    """Return the page of one report: what needs attention first, then charts, then all of it."""
    asked = "the checks that were named" if report.profile == "named" else report.profile
    times, memory = _charts(report)
    return render(
        HERE / "report.html",
        report=report,
        machine=machine_line(report),
        when=when(report),
        asked=asked + (", none may be absent" if report.required else ""),
        totals=totals_line(report),
        attention=_attention(report),
        comparison=comparison,
        times=times,
        memory=memory,
        checks=checks_table(report),
        system=system_table(report),
    )


def fleet_html(fleet: FleetHealth) -> str:
    """Return the page of a fleet: who is unhealthy, what differs and on whom, and who is slow."""
    notes = [*fleet.notes, *fleet.bad_lines(), *fleet.slow_lines()]
    differences = [column.sentence().partition(": ") for column in fleet.columns]
    return render(
        HERE / "fleet.html",
        fleet=fleet,
        notes=[("", "", note) for note in notes],
        differences=[("", f"{head}:", rest) for head, _, rest in differences],
        pace=[Bar(name, (pace,), f"{pace:.2f}") for name, pace in fleet.pace.items() if pace],
    )


def _attention(report: Report) -> list[tuple[str, str, str]]:
    findings, checks = attention(report)
    rows: list[tuple[str, str, str]] = [(f.status, f.title, f.message) for f in findings]
    rows += [(check.status, check.name, check.message) for check in checks]
    return sorted(rows, key=lambda row: row[0] not in {"fault", "fail", "error"})


def _charts(report: Report) -> tuple[list[Bar], list[Bar]]:
    """Return the seconds and the memory of the checks that began."""
    times, memory = [], []
    for check in report.checks:
        if check.import_seconds is not None:
            parts = (check.import_seconds, check.run_seconds or 0.0)
            took = sum(parts)
            times.append(Bar(check.name, parts, f"{took:.2f}" if took < 100 else f"{took:.0f}"))
        if check.peak_mb is not None:
            memory.append(Bar(check.name, (check.peak_mb,), f"{check.peak_mb:.0f}"))
    return times, memory


def junit(report: Report) -> str:
    """Return the XML: one suite a group of checks, and one of the machine.

    A wrong answer is a ``failure``, no answer an ``error``, an absent stack ``skipped``, or a
    failure where it was required. A fault of the machine is a failure; a warning passes, with
    its sentence in ``system-out``; what could not be told is skipped.
    """
    root = ET.Element("testsuites", name="qrobot health", time=_time(report.seconds))
    groups: dict[str, list[CheckResult]] = {}
    for check in report.checks:
        groups.setdefault(check.group, []).append(check)
    for group, checks in groups.items():
        cases = [_check(check, report.required) for check in checks]
        name = re.sub(r"\W+", "_", group)
        _suite(root, f"qrobot.health.{name}", report, cases)
    if report.system:
        _suite(root, "qrobot.health.machine", report, [_finding(f) for f in report.system])
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    ET.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _suite(root: ET.Element, name: str, report: Report, cases: Sequence[ET.Element]) -> None:
    begun = datetime.fromisoformat(report.made).astimezone(UTC)
    suite = ET.SubElement(
        root,
        "testsuite",
        name=name,
        tests=str(len(cases)),
        failures=str(sum(case.find("failure") is not None for case in cases)),
        errors=str(sum(case.find("error") is not None for case in cases)),
        skipped=str(sum(case.find("skipped") is not None for case in cases)),
        time=_time(sum(float(case.get("time", "0")) for case in cases)),
        timestamp=begun.strftime("%Y-%m-%dT%H:%M:%S"),  # that schema knows no zone
        hostname=_clean(report.host),
    )
    properties = ET.SubElement(suite, "properties")
    about = {
        "qrobot": report.qrobot,
        "python": report.python,
        "machine": report.machine,
        "model": report.model or "unknown",
        "profile": report.profile,
        "totals": totals_line(report),
    }
    for key, value in (about | report.versions).items():
        ET.SubElement(properties, "property", name=_clean(key), value=_clean(value))
    for case in cases:
        case.set("classname", name)
        suite.append(case)


def _check(check: CheckResult, required: bool) -> ET.Element:
    took = (check.import_seconds or 0.0) + (check.run_seconds or 0.0)
    case = ET.Element("testcase", name=_clean(check.name), time=_time(took))
    tag = {"pass": "", "fail": "failure", "error": "error", "absent": "skipped"}[check.status]
    if check.status == "absent" and required:
        tag = "failure"
    if tag:
        _outcome(case, tag, check.status, check.message)
    versions = ", ".join(f"{name} {version}" for name, version in check.versions.items())
    lines = [
        f"{check.title} (expected from: {check.message})" if not tag else check.title,
        f"versions: {versions or 'none'}",
        f"import {_said(check.import_seconds, 's')}, run {_said(check.run_seconds, 's')}, "
        f"peak memory {_said(check.peak_mb, 'MB')}",
    ]
    ET.SubElement(case, "system-out").text = _clean("\n".join(lines))
    return case


def _finding(finding: Finding) -> ET.Element:
    case = ET.Element("testcase", name=_clean(finding.name), time=_time(0.0))
    if finding.status in ("fault", "unknown"):
        tag = "failure" if finding.status == "fault" else "skipped"
        _outcome(case, tag, finding.status, finding.message)
    said = f"{finding.title}: {finding.text()}: {finding.status}: {finding.message}"
    ET.SubElement(case, "system-out").text = _clean(said)
    return case


def _outcome(case: ET.Element, tag: str, kind: str, message: str) -> None:
    text = _clean(message)
    outcome = ET.SubElement(case, tag, message=text)
    if tag != "skipped":  # which has no type
        outcome.set("type", kind)
        outcome.text = text


def _clean(text: str) -> str:
    return FORBIDDEN.sub("\ufffd", text)


def _time(seconds: float) -> str:
    return f"{seconds:.3f}"


def _said(value: float | None, unit: str) -> str:
    return "not reached" if value is None else f"{value:.3f} {unit}"


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
    begun = datetime.fromisoformat(report.made).timestamp()
    gauge("run_timestamp_seconds", "When the run began, in Unix time.").set(begun)
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
        for one in get_args(FindingStatus):
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
            advice="check the folder and its free space, or choose another place",
        ) from None
