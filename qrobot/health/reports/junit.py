"""A report as JUnit XML, for CI servers.

There is no standard; this keeps to what Jenkins' schema allows and GitLab, GitHub's actions
and others read: properties and counts on the suites, ``failure``, ``error`` and ``skipped`` in
the cases.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from datetime import UTC, datetime

from qrobot.health.model import CheckResult, Finding, Report
from qrobot.health.reports.summary import totals_line

__all__ = ["junit"]

FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, escaped or not."""


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
        _suite(root, f"qrobot.health.{_word(group)}", report, cases)
    if report.system:
        _suite(root, "qrobot.health.machine", report, [_finding(f) for f in report.system])
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    ET.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _suite(root: ET.Element, name: str, report: Report, cases: Sequence[ET.Element]) -> None:
    when = datetime.fromisoformat(report.made).astimezone(UTC)
    suite = ET.SubElement(
        root,
        "testsuite",
        name=name,
        tests=str(len(cases)),
        failures=str(sum(case.find("failure") is not None for case in cases)),
        errors=str(sum(case.find("error") is not None for case in cases)),
        skipped=str(sum(case.find("skipped") is not None for case in cases)),
        time=_time(sum(float(case.get("time", "0")) for case in cases)),
        timestamp=when.strftime("%Y-%m-%dT%H:%M:%S"),  # that schema knows no zone
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


def _word(group: str) -> str:
    return re.sub(r"\W+", "_", group)


def _time(seconds: float) -> str:
    return f"{seconds:.3f}"


def _said(value: float | None, unit: str) -> str:
    return "not reached" if value is None else f"{value:.3f} {unit}"
