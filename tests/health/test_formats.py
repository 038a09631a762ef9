"""JUnit XML and metrics, read again by somebody else's reader."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest
from health import samples
from health.samples import BROKEN, MIXED, STRANGE
from prometheus_client.parser import text_string_to_metric_families

from qrobot.errors import InputError
from qrobot.health import Report
from qrobot.health.reports import junit, write_prometheus

ALLOWED = {
    "testsuites": {"name", "time", "tests", "failures", "errors"},
    "testsuite": {
        "name",
        "tests",
        "failures",
        "errors",
        "skipped",
        "time",
        "timestamp",
        "hostname",
    },
    "properties": set(),
    "property": {"name", "value"},
    "testcase": {"name", "classname", "time"},
    "failure": {"message", "type"},
    "error": {"message", "type"},
    "skipped": {"message"},
    "system-out": set(),
}
"""What Jenkins' schema (junit-10.xsd) knows, of that what is used here."""

INSIDE = {
    "testsuites": {"testsuite"},
    "testsuite": {"properties", "testcase"},
    "properties": {"property"},
    "testcase": {"failure", "error", "skipped", "system-out"},
}


def checked(text: str) -> ET.Element:
    """Return the root of XML that obeys the rules of a CI server."""
    root = ET.fromstring(text)
    for element in root.iter():
        assert set(element.attrib) <= ALLOWED[element.tag]
        assert {child.tag for child in element} <= INSIDE.get(element.tag, set())
    for suite in root:
        cases = suite.findall("testcase")
        assert suite.get("tests") == str(len(cases))
        for counter, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            assert suite.get(counter) == str(sum(case.find(tag) is not None for case in cases))
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", suite.get("timestamp", ""))
        total = sum(float(case.get("time", "")) for case in cases)
        assert float(suite.get("time", "")) == pytest.approx(total, abs=0.01)
        for case in cases:
            assert case.get("classname")
            assert sum(child.tag != "system-out" for child in case) <= 1
    for counter in ("tests", "failures", "errors"):
        assert int(root.get(counter, "")) == sum(int(suite.get(counter, "")) for suite in root)
    return root


def outcomes(root: ET.Element) -> dict[str, str]:
    return {
        case.get("name", ""): next((c.tag for c in case if c.tag != "system-out"), "passed")
        for case in root.iter("testcase")
    }


def test_junit_says_what_happened() -> None:
    root = checked(junit(BROKEN))
    found = outcomes(root)
    assert [found[name] for name in ("numpy", "scipy", "aer", "pyscf")] == [
        "passed", "failure", "error", "skipped",
    ]  # fmt: skip
    assert found["memory"] == "failure"
    assert found["throttled"] == "passed"
    assert found["libc"] == "skipped"
    assert [suite.get("name") for suite in root] == [
        "qrobot.health.base", "qrobot.health.gate_model", "qrobot.health.science",
        "qrobot.health.machine",
    ]  # fmt: skip
    assert "number 1 is 2" in root.findall(".//failure")[0].get("message", "")
    properties = {p.get("name"): p.get("value") for p in root.iter("property")}
    assert properties["numpy"] == "1.2.3"
    assert properties["model"] == "Raspberry Pi 4 Model B Rev 1.4"


def test_an_absent_stack_that_was_required_is_a_failure_in_junit() -> None:
    assert outcomes(checked(junit(replace(MIXED, required=True))))["pyscf"] == "failure"


def test_junit_of_nothing_and_of_anything_is_xml() -> None:
    checked(junit(replace(MIXED, checks=(), system=())))
    root = checked(junit(STRANGE).encode("utf-8", "strict").decode())
    assert "5 > 3 ]]>" in root.findall(".//error")[0].get("message", "")


def metrics_of(report: Report, tmp_path: Path) -> dict[tuple[str, frozenset[str]], float]:
    path = tmp_path / "x.prom"
    write_prometheus(path, report)
    assert [one.name for one in tmp_path.iterdir()] == ["x.prom"]
    found = {}
    for family in text_string_to_metric_families(path.read_text()):
        assert family.name.startswith("qrobot_health_")
        assert family.type == "gauge"
        assert family.documentation
        for sample in family.samples:
            assert sample.timestamp is None  # the textfile collector refuses them
            key = (sample.name.removeprefix("qrobot_health_"), frozenset(sample.labels.values()))
            found[key] = sample.value
    return found


def test_metrics_in_base_units(tmp_path: Path) -> None:
    found = metrics_of(MIXED, tmp_path)
    assert found["check_status", frozenset({"scipy", "base", "fail"})] == 1
    assert found["check_status", frozenset({"scipy", "base", "pass"})] == 0
    assert found["check_import_seconds", frozenset({"numpy", "base"})] == 0.5
    assert found["check_run_seconds", frozenset({"numpy", "base"})] == 0.25
    assert found["check_peak_memory_bytes", frozenset({"numpy", "base"})] == 80 * 2**20
    assert ("check_run_seconds", frozenset({"aer", "gate model"})) not in found
    assert found["package_info", frozenset({"numpy", "1.2.3"})] == 1
    assert found["run_timestamp_seconds", frozenset()] == 1795161600  # 2026-11-20 08:00 UTC
    assert found["temperature_celsius", frozenset()] == 51.5
    assert found["memory_bytes", frozenset()] == 3792 * 2**20
    assert found["clock_synchronised", frozenset()] == 1
    assert found["throttled_bits", frozenset()] == 0x50005
    assert found["healthy", frozenset()] == 0
    assert metrics_of(samples.report(), tmp_path)["healthy", frozenset()] == 1


@pytest.mark.parametrize("bit", range(4))
def test_the_throttling_bits_have_a_series_each(bit: int, tmp_path: Path) -> None:
    name = ("under_voltage", "frequency_capped", "throttled", "soft_temperature_limit")[bit]
    for shift, when in ((0, "now"), (16, "since_start")):
        one = samples.found(samples.report(), "throttled", value=1 << (bit + shift))
        found = {k: v for k, v in metrics_of(one, tmp_path).items() if k[0] == "throttled"}
        assert len(found) == 8
        assert [key for key, value in found.items() if value] == [
            ("throttled", frozenset({name, when}))
        ]


def test_labels_may_hold_anything(tmp_path: Path) -> None:
    words = '<b>"quoted"\\ back\nslash'
    one = replace(samples.report(), model=words, system=(), checks=(samples.check(words),))
    found = metrics_of(one, tmp_path)
    assert found["check_status", frozenset({words, "base", "pass"})] == 1


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot write"):
        write_prometheus(tmp_path / "no" / "x.prom", MIXED)
    with pytest.raises(InputError, match="cannot write"):  # a lone surrogate is no UTF-8
        write_prometheus(tmp_path / "x.prom", STRANGE)
    assert not list(tmp_path.iterdir())
