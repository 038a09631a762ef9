"""One robot that fails stops no other, and the end of every run names who failed and why."""

from __future__ import annotations

import importlib.util
import json
import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from fleet_house import ANSIBLE, DEAD, LOCAL, play, robot, stand_in
from release_house import PLUGINS, program

INSTALLED = {"id": "2.0", "current": "1.0"}
TASKS: dict[str, list[dict[str, Any]]] = {
    "preflight": [
        {"ansible.builtin.raw": "true", "changed_when": False},
        {
            "ansible.builtin.fail": {"msg": "{{ inventory_hostname }}: the clock is wrong"},
            "when": "late | default(false)",
        },
    ],
    "release": [
        {
            "when": "broken | default(false)",
            "block": [{"ansible.builtin.command": {"argv": ["false"]}}],
            "rescue": [{"ansible.builtin.fail": {"msg": "its proof failed (aer: wrong answer)"}}],
        },
        {
            "when": "healed | default(false)",
            "block": [{"ansible.builtin.command": {"argv": ["false"]}}],
            "rescue": [{"ansible.builtin.debug": {"msg": "mended"}}],
        },
        {"ansible.builtin.set_fact": {"release_installed": INSTALLED}},
    ],
    "hardening": [{"ansible.builtin.debug": {"msg": "FINISHED {{ inventory_hostname }}"}}],
}
FAULTS: list[tuple[dict[str, Any], str, int]] = [
    ({"qrobot_profile": "huge"}, "failed: value of qrobot_profile must be one of: solver, edge", 2),
    ({"late": True}, "failed: the clock is wrong (task 'preflight : ", 2),
    ({"broken": True}, "failed: its proof failed (aer: wrong answer) (task 'release : ", 2),
    ({"qrobot_silence": "soon"}, "failed: argument 'qrobot_silence' is of type", 2),
    (DEAD, "did not answer: ", 4),
]
Provision = Callable[..., Any]


@pytest.fixture
def provision(tmp_path: Path) -> Provision:
    stand_in(tmp_path, "provision.yml", TASKS)

    def run(odd: dict[str, dict[str, Any]], count: int = 4, **more: Any) -> Any:
        names = [f"pi-{number}" for number in range(1, count + 1)]
        hosts = {name: LOCAL | odd.get(name, {}) for name in names}
        return play(tmp_path, tmp_path / "provision.yml", hosts, **more)

    return run


def finished(done: Any) -> list[str]:
    return sorted(re.findall(r"FINISHED ([^\"\s]*)", done.stdout))


# Each fault on the robot that comes first; a failed one and a silent one also after another.
@pytest.mark.parametrize(
    ("which", "fault", "says", "code"),
    [("pi-1", *fault) for fault in FAULTS[2::2]]
    + [pytest.param("pi-1", *fault, marks=pytest.mark.slow) for fault in (*FAULTS[:2], FAULTS[3])]
    + [pytest.param("pi-2", *fault, marks=pytest.mark.slow) for fault in FAULTS[2::2]],
)
def test_the_others_go_on_and_the_end_says_who_failed_and_why(
    provision: Provision, which: str, fault: dict[str, Any], says: str, code: int
) -> None:
    program("ssh")
    done = provision({which: fault}, count=2)
    assert done.returncode == code, done.stdout + done.stderr
    (other,) = {"pi-1", "pi-2"} - {which}
    assert finished(done) == [other]
    end = done.stdout.partition("PLAY RECAP")[2]
    assert f"\n  {which} {says}" in end
    assert "the run reached its end on 1 of 2 robots" in end
    assert f"\n  {other} " not in end


@pytest.mark.slow
def test_several_faults_are_all_named(provision: Provision) -> None:
    program("ssh")
    odd = {f"pi-{n}": fault for n, (fault, _, _) in enumerate(FAULTS, start=1)}
    done = provision(odd, count=7)
    end = done.stdout.partition("PLAY RECAP")[2]
    for number, (_, says, _) in enumerate(FAULTS, start=1):
        assert f"\n  pi-{number} {says}" in end
    assert finished(done) == ["pi-6", "pi-7"]
    assert "on 2 of 7 robots" in end


def test_what_was_mended_on_the_way_is_no_failure(provision: Provision) -> None:
    done = provision({"pi-2": {"healed": True}})
    assert done.returncode == 0, done.stdout + done.stderr
    assert "No robot failed: the run reached its end on 4 robots." in done.stdout
    assert len(finished(done)) == 4


@pytest.mark.slow
def test_robots_of_batches_that_never_began_and_that_were_stopped_are_named(
    provision: Provision,
) -> None:
    done = provision({"pi-1": {"broken": True}}, qrobot_batch=[2], qrobot_max_fail=0)
    assert done.returncode == 2
    end = done.stdout.partition("PLAY RECAP")[2]
    assert "\n  pi-1 failed: its proof failed" in end
    assert "\n  pi-2 was stopped: another robot of its batch failed" in end
    for name in ("pi-3", "pi-4"):
        assert f"\n  {name} was not begun: a batch before its own failed" in end
    assert "on 0 of 4 robots" in end


def test_a_failure_in_an_early_batch_is_told_by_the_exit_code(provision: Provision) -> None:
    done = provision({"pi-1": {"broken": True}}, qrobot_batch=[2])
    assert done.returncode == 2
    assert finished(done) == ["pi-2", "pi-3", "pi-4"]


def test_a_rollback_begins_with_one_robot_and_names_what_cannot_return(tmp_path: Path) -> None:
    stand_in(tmp_path, "rollback.yml", {})
    handler = {"name": "Restart the services of the release", "ansible.builtin.meta": "noop"}
    (tmp_path / "roles/release/handlers/main.yml").write_text(json.dumps([handler]))
    roots = {name: tmp_path / name for name in ("pi-1", "pi-2", "pi-3", "pi-4", "pi-5")}
    for name, root in roots.items():
        made = robot(root, "1.0", {"click": "1.0"})
        if name != "pi-3":  # it has nothing to return to
            made.install("2.0", "", root / "wheels", "uv", "python", {"profile": "solver"})
            made.switch("2.0")
    hosts = {name: LOCAL | {"qrobot_root": str(root)} for name, root in roots.items()}
    done = play(tmp_path, tmp_path / "rollback.yml", hosts)
    assert done.returncode == 2, done.stdout + done.stderr
    assert done.stdout.count("PLAY [Roll back]") == 2
    now = {name: (root / "current").readlink().name for name, root in roots.items()}
    assert now == dict.fromkeys(roots, "1.0")
    end = done.stdout.partition("PLAY RECAP")[2]
    assert "\n  pi-3 failed: " in end
    assert "on 4 of 5 robots" in end
    done = play(tmp_path, tmp_path / "rollback.yml", hosts, qrobot_batch=2)
    assert done.stdout.count("PLAY [Roll back]") <= 3


@pytest.fixture(scope="module")
def outcome() -> ModuleType:
    pytest.importorskip("ansible")
    path = PLUGINS / "callback/qrobot_outcome.py"
    spec = importlib.util.spec_from_file_location("qrobot_outcome", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("result", "says"),
    [
        ({"msg": "no"}, "no"),
        ({"msg": "Task failed: a\n  b"}, "a b"),
        ({"msg": None}, "no reason was given"),
        ({}, "no reason was given"),
        ({"msg": ["a", "b"]}, "['a', 'b']"),
        ({"msg": "non-zero return code", "rc": 3, "stderr": "", "stdout": "x\ny\n"},
         "exit code 3: y"),
        ({"msg": "non-zero return code", "rc": 3, "stderr": "z\n", "stdout": "x"},
         "exit code 3: x"),
        ({"msg": "One or more items failed", "results": [{"msg": "fine"}, {"failed": True,
          "msg": "item 2"}]}, "item 2"),
        ({"censored": "the output has been hidden"},
         "its answer is hidden, because it may hold a secret"),
    ],
)  # fmt: skip
def test_a_reason_is_one_line(outcome: ModuleType, result: dict[str, Any], says: str) -> None:
    assert outcome.sentence(result) == says


def test_a_long_reason_is_cut(outcome: ModuleType) -> None:
    assert len(outcome.sentence({"msg": "word " * 10**4})) == outcome.LENGTH


def test_every_run_has_the_callback() -> None:
    text = (ANSIBLE / "ansible.cfg").read_text()
    enabled = re.search(r"^callbacks_enabled = (.*)$", text, re.M)
    assert enabled
    assert "qrobot_outcome" in enabled[1].split(", ")
