"""Fleets: how upgrade.yml rolls, and that the health page names who sent no report.

Stand-ins, so that no robot is needed. For upgrade.yml: the roles preflight, runtime, wheelhouse,
release, stacks and health are replaced by one line each that says that a robot was touched; the
playbook itself is ours, byte for byte, and so is the role qrobot. For health.yml: the program
systemctl, whose "start" puts each robot's next report in place.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fleet_house import ANSIBLE, DEAD, LOCAL, play, stand_in
from health.samples import check, report
from release_house import program

ROBOTS = [f"pi-{number}" for number in range(1, 9)]
Run = Callable[..., tuple[subprocess.CompletedProcess[str], list[list[str]]]]


@pytest.fixture
def upgrade(tmp_path: Path) -> Run:
    """Run our upgrade.yml with stand-ins for its roles; also the robots of each batch."""
    # The first task that needs a connection.
    tasks: dict[str, list[dict[str, Any]]] = {
        "preflight": [{"ansible.builtin.raw": "true", "changed_when": False}]
    }
    installed = {"id": "2.0", "current": "1.0"}
    tasks["release"] = [
        {"ansible.builtin.debug": {"msg": "TOUCHED {{ ansible_play_batch | join(' ') }}"}},
        {"ansible.builtin.fail": {"msg": "its proof failed"}, "when": "broken | default(false)"},
        {"ansible.builtin.debug": {"msg": "SWITCHED {{ inventory_hostname }}"}},
        {"ansible.builtin.set_fact": {"release_installed": installed}},
    ]
    stand_in(tmp_path, "upgrade.yml", tasks)

    def run(odd: dict[str, dict[str, Any]], **more: Any) -> Any:
        hosts = {name: LOCAL | odd.get(name, {}) for name in ROBOTS}
        done = play(tmp_path, tmp_path / "upgrade.yml", hosts, **more)
        batches: list[list[str]] = []
        for said in re.findall(r"TOUCHED ([^\"]*)", done.stdout):
            batches += [] if said.split() in batches else [said.split()]
        return done, batches

    return run


def switched(done: subprocess.CompletedProcess[str]) -> list[str]:
    return sorted(re.findall(r"SWITCHED ([^\"]*)", done.stdout))


def test_one_robot_first_and_then_a_quarter_at_a_time(upgrade: Run) -> None:
    done, batches = upgrade({})
    assert done.returncode == 0, done.stdout + done.stderr
    assert [len(batch) for batch in batches] == [1, 2, 2, 2, 1]
    assert sorted(name for batch in batches for name in batch) == switched(done) == ROBOTS
    assert "pi-8: 2.0 is in use, before it 1.0" in done.stdout


@pytest.mark.slow
def test_a_first_robot_that_fails_ends_the_upgrade(upgrade: Run) -> None:
    done, batches = upgrade({"pi-1": {"broken": True}})
    assert done.returncode != 0
    assert batches == [["pi-1"]]
    assert switched(done) == []


def test_a_robot_that_fails_later_keeps_the_rest_untouched(upgrade: Run) -> None:
    done, batches = upgrade({"pi-4": {"broken": True}})
    assert done.returncode != 0
    assert batches == [["pi-1"], ["pi-2", "pi-3"], ["pi-4", "pi-5"]]
    # pi-5 stops where pi-4 failed: before its own switch, with the release that it had.
    assert switched(done) == ["pi-1", "pi-2", "pi-3"]
    assert not re.search(r"pi-[678]\b", done.stdout.partition("PLAY RECAP")[0])


@pytest.mark.slow
def test_an_unreachable_robot_fails_the_run_and_ends_it_when_its_batch_is_lost(
    upgrade: Run,
) -> None:
    program("ssh")  # what does not reach the robot that does not answer
    done, batches = upgrade({"pi-4": DEAD})
    assert done.returncode != 0
    assert switched(done) == [name for name in ROBOTS if name != "pi-4"]
    done, batches = upgrade({"pi-1": DEAD})
    assert done.returncode != 0
    assert batches == []


@pytest.mark.slow
def test_the_batches_are_given_on_the_command_line(upgrade: Run) -> None:
    done, batches = upgrade(
        {"pi-4": {"broken": True}}, qrobot_batch=[3, "100%"], qrobot_max_fail=50
    )
    assert [len(batch) for batch in batches] == [3, 5]
    assert done.returncode != 0
    assert switched(done) == [name for name in ROBOTS if name != "pi-4"]


# The health page

SYSTEMCTL = """#!/bin/sh
case "$1" in
  show) printf 'Id=qrobot-health.service\\nLoadState=loaded\\nActiveState=inactive\\n' ;;
  start) for next in {folder}/*/next.json; do cp "$next" "$(dirname "$next")/report.json"; done ;;
esac
"""


@pytest.fixture
def health(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Run our health.yml on robots that are folders, with a stand-in for systemctl."""
    robots, programs = tmp_path / "robots", tmp_path / "programs"
    programs.mkdir()
    (programs / "systemctl").write_text(SYSTEMCTL.format(folder=robots))
    (programs / "systemctl").chmod(0o755)
    monkeypatch.setenv("PATH", str(programs), prepend=":")

    def run(
        made: dict[str, dict[str, Any]], *dead: str, **more: Any
    ) -> tuple[Any, dict[str, Any], str]:
        hosts: dict[str, Any] = dict.fromkeys(dead, DEAD)
        for name, reports in made.items():
            folder = robots / name
            folder.mkdir(parents=True, exist_ok=True)
            for file, one in reports.items():
                (folder / f"{file}.json").write_text(json.dumps(one.to_dict()))
            hosts[name] = {**LOCAL, "qrobot_reports": str(folder)}
        settings = {"qrobot_fetched": f"{tmp_path}/fleet", "health_poll": 1, **more}
        done = play(tmp_path, ANSIBLE / "health.yml", hosts, **settings)
        page = tmp_path / "fleet/fleet.html"
        assert page.exists(), done.stdout + done.stderr
        found = json.loads((tmp_path / "fleet/fleet.json").read_text())
        return done, found, page.read_text()

    return run


def test_a_fleet_that_is_healthy_and_answers(health: Any) -> None:
    old, new = report("a"), report("a", made="2026-11-21T08:00:00+00:00")
    done, found, page = health({"a": {"report": old, "next": new}})
    assert done.returncode == 0, done.stdout + done.stderr
    assert {m["name"]: m["made"] for m in found["machines"]} == {"a": new.made}
    assert found["notes"] == []
    assert "1 machine, 0 unhealthy" in page


@pytest.mark.slow
def test_robots_without_a_new_report_are_named(health: Any, tmp_path: Path) -> None:
    program("ssh")  # what does not reach the robot that does not answer
    (tmp_path / "fleet").mkdir()
    earlier = report("gone", made="2026-11-01T08:00:00+00:00")
    (tmp_path / "fleet/gone.json").write_text(json.dumps(earlier.to_dict()))
    ill = replace(report("ill"), checks=(check("qiskit", "fail", message="wrong answer"),))
    made = {"ill": {"next": ill}, "stuck": {"report": report("stuck")}, "bare": {}}
    done, found, page = health(made, "gone", health_seconds=0)  # at once, without polls
    assert done.returncode != 0
    notes = dict(note.split(" sent no report ", 1) for note in found["notes"])
    assert sorted(notes) == ["bare", "gone", "stuck"]
    assert "Connection refused" in notes["gone"]
    assert "the report shown is of 2026-11-01T08:00:00+00:00" in notes["gone"]
    assert "the checks made no new report" in notes["stuck"]
    assert "there is no earlier one" in notes["bare"]
    for name in notes:
        assert f"{name} sent no report" in done.stdout
        assert f"{name} sent no report" in page
    assert "ill is unhealthy" in done.stdout
    # A robot that does not answer is waited for once.
    assert done.stdout.count("UNREACHABLE!") == 1


@pytest.mark.parametrize(
    ("asked", "code", "word"),
    [
        ([{"name": "a", "why": ""}], 0, "0 unhealthy"),
        ([{"name": "a", "why": ""}, {"name": "ill", "why": ""}], 1, "ill is unhealthy"),
        ([{"name": "ill", "why": ""}, {"name": "x", "why": "away"}], 3, "x sent no report (away)"),
        ([{"name": "torn", "why": ""}], 3, "torn sent no report (its report cannot be used"),
        ([{"name": "x", "why": "away"}], 3, "0 machines"),
        ({"a": 1}, 2, "is not a list of robots"),
    ],
)
def test_the_program_tells_by_its_exit_code(
    asked: Any, code: int, word: str, tmp_path: Path
) -> None:
    ill = replace(report("ill"), checks=(check("qiskit", "fail"),))
    for name, one in (("a", report("a")), ("ill", ill)):
        (tmp_path / f"{name}.json").write_text(json.dumps(one.to_dict()))
    (tmp_path / "torn.json").write_text('{"schema": "qrobot.health/1", ')
    command = [sys.executable, str(ANSIBLE / "controller/fleet_health.py"), f"--folder={tmp_path}"]
    done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    assert word in done.stdout + done.stderr
    assert "Traceback" not in done.stderr
