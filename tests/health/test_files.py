"""The files that ``qrobot health`` writes and reads: whole or not at all, named and coded."""

from __future__ import annotations

import json
import os
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from health import samples
from health.commands import code_of
from prometheus_client.parser import text_string_to_metric_families

from qrobot.health import read_report


def test_every_face_of_one_run(planted: dict[str, Any], tmp_path: Path) -> None:
    planted["findings"] = list(samples.FINDINGS)
    paths = {name: tmp_path / name for name in ("x.json", "x.xml", "x.html", "x.prom")}
    words = zip(("-o", "--junit", "--html", "--prometheus"), paths.values(), strict=True)
    assert code_of("numpy", *[word for pair in words for word in pair]) == 0
    assert {path.name for path in tmp_path.iterdir()} == set(paths)
    assert [check.name for check in read_report(paths["x.json"]).checks] == ["numpy"]
    assert ET.parse(paths["x.xml"]).getroot().tag == "testsuites"
    assert "</html>" in paths["x.html"].read_text()
    families = {f.name for f in text_string_to_metric_families(paths["x.prom"].read_text())}
    assert "qrobot_health_check_status" in families


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full exists on Linux only")
@pytest.mark.parametrize("option", ["--output", "--junit", "--html", "--prometheus"])
def test_a_full_disk_costs_one_face_and_no_other(
    planted: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    words: list[str | Path] = ["numpy"]
    for one in ("--output", "--junit", "--html", "--prometheus"):
        words += [one, "/dev/full" if one == option else tmp_path / one.strip("-")]
    assert code_of(*words) == 2
    said = capsys.readouterr()
    assert "1 passed" in said.out
    sentences = [line for line in said.err.splitlines() if line.startswith("qrobot: ")]
    assert len(sentences) == 1
    assert "/dev/full" in sentences[0]
    assert "No space left" in sentences[0]
    assert len(list(tmp_path.iterdir())) == 3
    assert Path("/dev/full").is_char_device()


def test_a_disk_that_fills_up_in_between_leaves_nothing_half_written(
    planted: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = tmp_path / "x.prom"
    old.write_text("what stood there\n")

    def full(*_: object) -> None:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(os, "fsync", full)  # of the texts
    monkeypatch.setattr(os, "rename", full)  # of prometheus-client
    words = ("--output", tmp_path / "x.json", "--html", tmp_path / "x.html", "--prometheus", old)
    assert code_of("numpy", *words) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["x.prom"]
    assert old.read_text() == "what stood there\n"


def test_a_folder_that_may_not_be_written_is_refused_before_the_checks(
    planted: dict[str, Any], tmp_path: Path
) -> None:
    if os.geteuid() == 0:
        pytest.skip("root may write everything")
    tmp_path.chmod(0o555)
    assert code_of("numpy", "-o", tmp_path / "x.json") == 2
    assert planted["ran"] == []


def test_metrics_through_a_link_keep_the_link(planted: dict[str, Any], tmp_path: Path) -> None:
    target, link = tmp_path / "real.prom", tmp_path / "x.prom"
    target.write_text("")
    link.symlink_to(target)
    assert code_of("numpy", "--prometheus", link) == 0
    assert link.is_symlink()
    assert "qrobot_health_info" in target.read_text()


def test_a_baseline_may_be_overwritten_by_its_successor(
    planted: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    last = tmp_path / "last.json"
    assert code_of("numpy", "dimod", "-o", last) == 0
    planted["status"] = {"dimod": "absent"}
    assert code_of("--quick", "--compare", last, "-o", last) == 1
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["dimod", "status", "pass", "absent", "worse"] in rows
    assert json.loads(last.read_text())["comparison"]["worse"] == 1
    read_report(last)
    assert code_of("--quick", "--compare", last) == 0  # it did not get worse since


@pytest.mark.parametrize("option", ["--html", "--junit", "--prometheus"])
def test_no_other_face_may_overwrite_the_baseline(
    planted: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    last, link = tmp_path / "last.json", tmp_path / "link"
    assert code_of("numpy", "-o", last) == 0
    link.symlink_to(last)
    text = last.read_text()
    planted["ran"] = []
    for path in (last, link):
        assert code_of("numpy", "--compare", last, option, path) == 2
        assert "is an input" in capsys.readouterr().err
    assert planted["ran"] == []
    assert last.read_text() == text


def test_version_drift_fails_only_when_strict(planted: dict[str, Any], tmp_path: Path) -> None:
    last = tmp_path / "last.json"
    assert code_of("numpy", "-o", last) == 0
    data = json.loads(last.read_text())
    data["checks"][0]["versions"]["numpy"] = "0.9"
    last.write_text(json.dumps(data))
    assert code_of("numpy", "--compare", last) == 0
    assert code_of("numpy", "--compare", last, "--strict-compare") == 1


def test_two_files_are_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = samples.report()
    other = samples.changed(one, "qiskit", status="error")
    paths = []
    for number, report in enumerate((one, other)):
        paths.append(tmp_path / f"{number}.json")
        paths[-1].write_text(json.dumps(report.to_dict()))
    assert code_of("compare", *paths) == 1
    assert code_of("compare", *reversed(paths)) == 0
    assert code_of("compare", *reversed(paths), "--strict") == 1
    capsys.readouterr()
    assert code_of("compare", *paths, "--json") == 1
    assert json.loads(capsys.readouterr().out)["changes"][0]["name"] == "qiskit"


def test_a_fleet_is_merged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in range(3):
        report = samples.report(f"pi-{number}")
        if number == 2:
            report = replace(report, python="3.13.5")
        (tmp_path / f"{number}.json").write_text(json.dumps(report.to_dict()))
    files = sorted(tmp_path.glob("*.json"))
    page = tmp_path / "fleet.html"
    assert code_of("merge", *files, "--html", page) == 0
    assert "machine python: 3.11.2 on 2; 3.13.5 on pi-2" in capsys.readouterr().out
    assert "pi-2" in page.read_text()
    assert code_of("merge", *files, "--json") == 0
    (difference,) = json.loads(capsys.readouterr().out)["differences"]
    assert difference["different"] == {"3.13.5": ["pi-2"]}
    assert code_of("merge", *files, "--html", files[0]) == 2  # never over an input
    assert code_of("merge", *files, "--html", "/dev/full") == 2
    said = capsys.readouterr()
    assert "3.13.5 on pi-2" in said.out
    assert "No space left" in said.err


def test_an_unhealthy_machine_of_a_fleet_is_code_1(tmp_path: Path) -> None:
    report = samples.changed(samples.report(), "numpy", status="fail")
    path = tmp_path / "x.json"
    path.write_text(json.dumps(report.to_dict()))
    assert code_of("merge", path) == 1
