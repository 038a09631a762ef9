"""The check of the roles: what a role has on a robot and does not own is told, without a robot."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from fleet_house import ANSIBLE

pytest.importorskip("yaml")
OWNS = "roles/health/vars/owns.yml"
TASKS = "roles/health/tasks/main.yml"
# What is changed in a copy of the playbooks: the file, a text in it, what takes its place, and a
# part of the sentence.
FAULTS = {
    "no facts": (OWNS, "health_owns:", "other:", "there is no health_owns in it"),
    "a key that nobody reads": (OWNS, "  units:", "  unit:", "'unit' is not a key; use one of"),
    "a text for a list": (OWNS, "tags: [health, step10]", "tags: health", "tags is not a list"),
    "a role that is not there": (OWNS, "[release]", "[relaese]", "it needs 'relaese', which"),
    "an unknown switch": (OWNS, "qrobot_health_timer", "qrobot_timer", "is not a setting of roles"),
    "a file": (
        OWNS, "files: [/etc/systemd/system/qrobot-health.timer, ", "files: [",
        "task 'Describe the daily checks' writes /etc/systemd/system/qrobot-health.timer",
    ),
    "a file in a rescue": (
        "roles/hardening/tasks/main.yml", "dest: /etc/nftables.conf\n        mode: \"0755\"\n"
        "        remote_src", "dest: /etc/nft.conf\n        mode: \"0755\"\n        remote_src",
        "task 'Put the packet filter's old settings back' writes /etc/nft.conf",
    ),
    "a link": (
        "roles/release/tasks/switch.yml", "dest: /usr/local/bin/qrobot", "dest: /usr/bin/qrobot",
        "task 'Put qrobot on the path' writes /usr/bin/qrobot, which the role does not own",
    ),
    "a file that nobody writes": (
        OWNS, "files: [", "files: [/etc/health.conf, ", "no task writes /etc/health.conf",
    ),
    "a unit": (
        OWNS, "units: [qrobot-health.timer, ", "units: [",
        "enables qrobot-health.timer, which is not among its units",
    ),
    "a unit's file": (
        OWNS, "timer, qrobot-health.service]", "timer]", "qrobot-health.service is not among its",
    ),
    "a user": (
        "roles/desktop/vars/owns.yml", "users: [qrobot-desktop]", "users: []",
        "makes the user qrobot-desktop, who is not among its users",
    ),
    "a package": (
        TASKS, "---\n", "---\n- name: Bring it\n  ansible.builtin.apt:\n    name: jq\n",
        "task 'Bring it' installs packages; base does that",
    ),
    "other tags": (
        "provision.yml", "{{ provision_tags.health }}", "{{ provision_tags.base }}",
        "the tags of health are not",
    ),
    "another switch": (
        "provision.yml", "when: qrobot_health_timer", "when: qrobot_metrics",
        "health is not switched by the switch",
    ),
}  # fmt: skip


@pytest.fixture
def playbooks(tmp_path: Path) -> Path:
    shutil.copytree(ANSIBLE / "roles", tmp_path / "roles")
    shutil.copy(ANSIBLE / "provision.yml", tmp_path)
    return tmp_path


def test_the_roles_own_everything_that_they_have() -> None:
    command = [sys.executable, ANSIBLE / "controller/check_roles.py"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("fault", FAULTS)
def test_what_a_role_does_not_own_is_told(playbooks: Path, fault: str) -> None:
    file, text, other, says = FAULTS[fault]
    path = playbooks / file
    before = path.read_text()
    assert before.count(text) >= 1
    path.write_text(before.replace(text, other, 1))
    from check_roles import faults

    said = faults(playbooks)
    assert any(says in line for line in said), said


def test_a_role_without_facts_and_one_that_is_not_played_are_told(playbooks: Path) -> None:
    (playbooks / "roles/metrics/vars/owns.yml").unlink()
    play = playbooks / "provision.yml"
    play.write_text(re.sub(r"    - role: docker\n.*\n.*\n", "", play.read_text()))
    done = subprocess.run(
        [sys.executable, ANSIBLE / "controller/check_roles.py", playbooks],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    said = done.stderr.splitlines()
    assert any("metrics/vars/owns.yml: there is no metrics_owns in it" in line for line in said)
    assert any("the role docker is not there" in line for line in said)


def test_make_lint_runs_it() -> None:
    text = (ANSIBLE.parent / "Makefile").read_text()
    recipe = text.partition("\nlint:")[2].partition("\n\n")[0]
    assert "ansible/controller/check_roles.py" in recipe
