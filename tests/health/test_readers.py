"""Readers that go away change no exit code, and keep back no report."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from health import samples

from qrobot.health import read_report

ROOT = Path(__file__).resolve().parents[2]

UNHEALTHY = ("numpy", "--timeout", "0.001", "--no-system")


def unread(*words: str | Path, out: bool = True, err: bool = False) -> int:
    """Return the exit code of ``qrobot health`` whose streams nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        return subprocess.run(
            [sys.executable, "-m", "qrobot", "health", *map(str, words)],
            stdout=writer if out else subprocess.DEVNULL,
            stderr=writer if err else subprocess.DEVNULL,
            check=False,
            cwd=ROOT,
        ).returncode
    finally:
        os.close(writer)


@pytest.mark.parametrize(("out", "err"), [(True, False), (False, True), (True, True)])
def test_unhealthy_stays_unhealthy_and_every_report_is_written(
    out: bool, err: bool, tmp_path: Path
) -> None:
    path = tmp_path / "late.json"
    assert unread(*UNHEALTHY, "dimod", "--output", path, out=out, err=err) == 1
    assert [check.name for check in read_report(path).checks] == ["numpy", "dimod"]
    assert unread(*UNHEALTHY, "--json", out=out, err=err) == 1


def test_a_report_that_could_not_be_written_stays_code_2() -> None:
    assert unread(*UNHEALTHY, "--html", "/dev/full", err=True) == 2


def test_bad_input_stays_code_2() -> None:
    assert unread("nope", err=True) == 2


def test_commands_that_read_reports_keep_their_code(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text(json.dumps(samples.report().to_dict()))
    worse = samples.changed(samples.report(), "numpy", status="fail")
    bad.write_text(json.dumps(worse.to_dict()))
    assert unread("merge", bad) == unread("merge", bad, "--json") == 1
    assert unread("compare", good, bad) == 1
    assert unread("compare", good, good) == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full exists on Linux only")
def test_a_full_log_stops_no_check(tmp_path: Path) -> None:
    path = tmp_path / "late.json"
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "qrobot", "health", *UNHEALTHY, "--output", path],
            stdout=subprocess.DEVNULL, stderr=full, check=False, cwd=ROOT,
        )  # fmt: skip
    assert done.returncode == 1
    assert len(read_report(path).checks) == 1
