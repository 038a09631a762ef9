"""``qrobot health``: what it prints, what it refuses, and its exit codes."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import started
from click.testing import CliRunner
from health import samples
from health.commands import code_of

from qrobot.cli.health import command
from qrobot.errors import InputError
from qrobot.health import CheckResult, Limits, all_checks, choose, make_report
from qrobot.health.model import Finding, Status

ROOT = Path(__file__).resolve().parents[2]


def qrobot_health(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return started.run("health", *words, folder=ROOT)


def test_the_json_has_the_schema() -> None:
    done = qrobot_health("numpy", "qrobot", "--json")
    assert done.returncode == 0, done.stdout
    data = json.loads(done.stdout)
    schema = json.loads(qrobot_health("--schema").stdout)
    jsonschema.Draft202012Validator(schema, format_checker=jsonschema.FormatChecker()).validate(
        data
    )
    assert [check["name"] for check in data["checks"]] == ["numpy", "qrobot"]
    for check in data["checks"]:
        assert set(check) == {field.name for field in fields(CheckResult)}
        assert check["status"] == "pass"
        assert len(check["answer"]) == len(check["expected"]) > 0
    assert [line.split()[1] for line in done.stderr.splitlines()] == ["numpy", "qrobot"]


def test_quick_runs_the_base_only(planted: dict[str, Any]) -> None:
    assert code_of("--quick") == 0
    assert {"numpy", "dimod", "qrobot"} <= set(planted["ran"]) < set(all_checks())
    assert all(all_checks()[name].quick for name in planted["ran"])


def test_options_reach_the_runner(planted: dict[str, Any]) -> None:
    assert code_of("numpy", "--jobs", "3", "--timeout", "7", "--memory", "100") == 0
    assert planted["options"]["jobs"] == 3
    assert planted["options"]["limits"].seconds == 7
    assert planted["options"]["limits"].megabytes == 100


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nope"], "'nope' is not a check"),
        (["numpy", "--quick"], "--quick"),
        (["numpy", "--profile", "edge"], "--profile"),
        (["--profile", "vast"], "use one of: base, solver, edge, full"),
        (["--strict-compare"], "--compare"),
        (["--network", "--no-system"], "--no-system"),
        (["--output", "/no/such/folder/x.json"], "folder"),
        (["--html", "/"], "folder"),
        (["--output", "same", "--junit", "same"], "written twice"),
        (["--compare", "/no/such.json"], "/no/such.json"),
        (["compare", "/no/such.json", "x"], "/no/such.json"),
        (["merge", "/no/such.json"], "/no/such.json"),
        (["--json", "merge"], "'merge' is not a check"),
        (["--", "merge"], "'merge' is not a check"),
    ],
)
def test_bad_input_is_one_sentence_before_any_check(
    words: list[str], told: str, planted: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert code_of(*words) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert told in said.err
    assert len(said.err.strip().splitlines()) == 1
    assert planted["ran"] == []


@pytest.mark.parametrize("option", ["--timeout", "--memory"])
@pytest.mark.parametrize("number", ["nan", "inf", "-inf", "0", "-1", "much"])
def test_a_limit_is_a_finite_number_above_zero(
    planted: dict[str, Any], capsys: pytest.CaptureFixture[str], option: str, number: str
) -> None:
    assert code_of("numpy", option, number) == 2
    said = capsys.readouterr().err
    assert option in said
    assert number in said
    assert planted["ran"] == []


@pytest.mark.parametrize("number", [math.nan, math.inf, 0.0, -1.0])
@pytest.mark.parametrize("field", ["seconds", "megabytes"])
def test_limits_refuse_what_limits_nothing(field: str, number: float) -> None:
    with pytest.raises(InputError, match="give a finite number above 0") as error:
        Limits(**{field: number})
    assert error.value.field == field


@pytest.mark.parametrize("words", [["merge"], ["compare"], ["compare", "one.json"]])
def test_commands_ask_for_their_files(words: list[str]) -> None:
    done = qrobot_health(*words)
    assert done.returncode == 2
    assert "Missing argument" in done.stderr
    assert "Traceback" not in done.stderr


def test_no_check_is_named_like_a_command() -> None:
    assert not set(all_checks()) & set(command.commands)
    assert {"merge", "compare"} < set(command.commands)


def test_names_options_and_their_sequence_are_free(planted: dict[str, Any]) -> None:
    for words in (["numpy", "--json", "dimod"], ["--json", "numpy", "dimod"],
                  ["run", "numpy", "dimod"], ["--", "numpy", "dimod"]):  # fmt: skip
        assert code_of(*words) == 0
        assert planted["ran"] == ["numpy", "dimod"]


def test_help_names_the_commands_and_not_itself() -> None:
    told = CliRunner().invoke(command, ["--help"], prog_name="qrobot health").output
    assert told.startswith("Usage: qrobot health [OPTIONS] [NAMES]...\n")
    assert "merge" in told
    assert "--strict-compare" in told
    assert "FILES" in CliRunner().invoke(command, ["merge", "--help"]).output


def test_the_list_names_every_check_and_runs_none() -> None:
    done = qrobot_health("--list")
    assert done.returncode == 0
    assert done.stderr == ""
    assert [line.split()[0] for line in done.stdout.splitlines()[2:]] == list(all_checks())
    rows = json.loads(qrobot_health("--list", "--json").stdout)
    assert [row["name"] for row in rows] == list(all_checks())


@pytest.mark.parametrize(
    ("status", "words", "code"),
    [
        ("pass", [], 0), ("pass", ["dimod"], 0), ("fail", [], 1), ("fail", ["dimod"], 1),
        ("error", [], 1), ("error", ["dimod"], 1), ("absent", [], 0), ("absent", ["dimod"], 1),
        ("absent", ["--profile", "edge"], 1), ("pass", ["--profile", "edge"], 0),
        ("absent", ["--quick"], 0), ("absent", ["--quick", "--profile", "base"], 1),
    ],
)  # fmt: skip
def test_exit_codes(
    planted: dict[str, Any],
    capsys: pytest.CaptureFixture[str],
    status: Status,
    words: list[str],
    code: int,
) -> None:
    planted["status"] = {"dimod": status}
    assert code_of(*words) == code
    said = capsys.readouterr().out
    assert (f"dimod: why dimod is {status}" in said) == (status != "pass")


@pytest.mark.parametrize(
    ("status", "words", "code"),
    [("fault", [], 1), ("warning", [], 0), ("unknown", [], 0), ("fault", ["--no-system"], 0)],
)
def test_a_fault_of_the_machine_counts_and_a_warning_does_not(
    planted: dict[str, Any],
    capsys: pytest.CaptureFixture[str],
    status: Any,
    words: list[str],
    code: int,
) -> None:
    planted["findings"] = [Finding("x", "A fact", status, 7, "why; advice", "MiB")]
    assert code_of("numpy", *words) == code
    shown = f"{status}: A fact 7 MiB: why; advice" in capsys.readouterr().out
    assert shown == (status in ("fault", "warning") and not words)


def test_numbers_that_json_does_not_know_are_null() -> None:
    data = samples.check("x", "fail", answer=(1.0, math.nan)).to_dict()
    assert data["answer"] == [1.0, None]
    json.dumps(data, allow_nan=False)


def test_a_report_says_where_and_when_it_was_made() -> None:
    report = make_report([])
    assert report.host
    assert report.made.endswith("+00:00")
    assert report.machine == os.uname().machine
    assert report.python == ".".join(map(str, sys.version_info[:3]))


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
