"""``qrobot health``: what it prints, its JSON and its exit codes."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest
from click.testing import CliRunner

import qrobot.health
from qrobot.cli.health import command
from qrobot.health import CheckResult, all_checks, choose
from qrobot.health.model import Status

ROOT = Path(__file__).resolve().parents[2]


def qrobot_health(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "qrobot", "health", *words],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )


def result(name: str, status: Status) -> CheckResult:
    return CheckResult(
        name=name,
        title="planted",
        group="base",
        status=status,
        versions={"thing": "1.2"},
        import_seconds=0.5,
        run_seconds=None,
        peak_mb=30.0,
        answer=(1.0, math.nan),
        expected=(1.0, 2.0),
        tolerance=1e-9,
        message="planted words",
    )


def test_the_json_has_the_schema() -> None:
    done = qrobot_health("numpy", "qrobot", "--json")
    assert done.returncode == 0, done.stdout
    data = json.loads(done.stdout)
    assert data["schema"] == "qrobot.health/1"
    assert [check["name"] for check in data["checks"]] == ["numpy", "qrobot"]
    for check in data["checks"]:
        assert set(check) == {field.name for field in fields(CheckResult)}
        assert check["status"] == "pass"
        assert len(check["answer"]) == len(check["expected"]) > 0
    assert [line.split()[1] for line in done.stderr.splitlines()] == ["numpy", "qrobot"]


def test_quick_runs_the_base_only(monkeypatch: pytest.MonkeyPatch) -> None:
    ran = []
    monkeypatch.setattr(
        qrobot.health, "run", lambda check, limits: ran.append(check) or result(check.name, "pass")
    )
    assert CliRunner().invoke(command, ["--quick"]).exit_code == 0
    assert {"numpy", "dimod", "qrobot"} <= {check.name for check in ran} < set(all_checks())
    assert all(check.extra is None for check in ran)


@pytest.mark.parametrize(
    ("words", "told"), [(["nope"], "'nope' is no check"), (["numpy", "--quick"], "--quick")]
)
def test_bad_input_is_one_sentence(words: list[str], told: str) -> None:
    done = qrobot_health(*words)
    assert done.returncode == 2
    assert done.stdout == ""
    assert told in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_the_list_names_every_check_and_runs_none() -> None:
    done = qrobot_health("--list")
    assert done.returncode == 0
    assert done.stderr == ""
    assert [line.split()[0] for line in done.stdout.splitlines()[2:]] == list(all_checks())
    rows = json.loads(qrobot_health("--list", "--json").stdout)
    assert [row["name"] for row in rows] == list(all_checks())


@pytest.mark.parametrize(
    ("status", "named", "code"),
    [
        ("pass", False, 0), ("pass", True, 0), ("fail", False, 1), ("fail", True, 1),
        ("error", False, 1), ("error", True, 1), ("absent", False, 0), ("absent", True, 1),
    ],
)  # fmt: skip
def test_exit_codes(
    monkeypatch: pytest.MonkeyPatch, status: Status, named: bool, code: int
) -> None:
    monkeypatch.setattr(
        qrobot.health,
        "run",
        lambda check, limits: result(check.name, status if check.name == "dimod" else "pass"),
    )
    done = CliRunner().invoke(command, ["dimod", "numpy"] if named else [])
    assert done.exit_code == code
    assert "thing" not in done.stdout
    assert ("dimod: planted words" in done.stdout) == (status != "pass")


def test_numbers_that_json_does_not_know_are_null() -> None:
    data = result("x", "fail").to_dict()
    assert data["answer"] == [1.0, None]
    json.dumps(data, allow_nan=False)


def test_names_are_taken_once_and_in_their_sequence() -> None:
    assert [c.name for c in choose(["scipy", "numpy", "scipy"])] == ["scipy", "numpy"]


def test_listing_checks_imports_no_sdk() -> None:
    code = "import sys; from qrobot.health import all_checks; all_checks(); print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    sdks = {module.split(".")[0] for check in all_checks().values() for module in check.imports}
    assert not loaded & (sdks - {"numpy", "qrobot"})
