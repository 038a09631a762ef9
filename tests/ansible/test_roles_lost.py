"""A robot whose power is cut in a long task: QROBOT_ROLES=1, as root, a minute.

The limits are those of ansible.cfg and the role qrobot in kind, and seconds in size.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from machine import PLAYBOOKS, Machine, program
from processes import HANG, until

LIMITS = {
    "ANSIBLE_SSH_ARGS": "-o ControlMaster=auto -o ControlPersist=60s"
    " -o ServerAliveInterval=1 -o ServerAliveCountMax=2",
    "ANSIBLE_TIMEOUT": "2",
}
JOB = {
    "module": "ansible.legacy.command",
    "options": {"argv": ["sh", "-c", "touch /run/job-began; sleep {{ work }}"]},
    "poll": 0.5,
    "silence": "{{ silence }}",
}
PLAY = [
    {
        "hosts": "all",
        "gather_facts": False,
        "tasks": [
            {"name": "Work for long", "qrobot_job": JOB},
            {"ansible.builtin.debug": {"msg": "FINISHED {{ inventory_hostname }}"}},
        ],
    }
]


@pytest.fixture
def run(machine: Machine) -> Iterator[subprocess.Popen[str]]:
    """A long task on the machine, and a short one on this computer, both begun."""
    folder = machine.folder
    (folder / "play.yml").write_text(json.dumps(PLAY))
    hosts = {
        "robot": {
            "ansible_host": machine.address,
            "ansible_user": "pi",
            "ansible_ssh_private_key_file": f"{folder}/key",
            "ansible_ssh_common_args": f"-o UserKnownHostsFile='{folder}/known_hosts'",
            "work": 7000,
        },
        "other": {"ansible_connection": "local", "ansible_become": False, "work": 0,
                  "ansible_python_interpreter": "/usr/bin/python3"},
    }  # fmt: skip
    (folder / "two.json").write_text(json.dumps({"all": {"hosts": hosts}}))
    environment = {
        **os.environ, **LIMITS, "ANSIBLE_CONFIG": str(PLAYBOOKS / "ansible.cfg"),
        "ANSIBLE_NOCOLOR": "1", "ANSIBLE_ASYNC_DIR": str(folder / "jobs"),
    }  # fmt: skip
    machine.root("rm -f /run/job-began")
    child = subprocess.Popen(
        [program("ansible-playbook"), "--inventory", folder / "two.json", "-e", "silence=4",
         folder / "play.yml"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        until(
            lambda: (
                machine.ssh("test -e /run/job-began").returncode == 0 or child.poll() is not None
            ),
            "the long task begins",
        )
        yield child
    finally:
        child.kill()
        child.wait()


def ended(child: subprocess.Popen[str]) -> str:
    """What a run said that ends by itself, long before the task would."""
    text, _ = child.communicate(timeout=HANG)
    return text


def test_a_task_that_was_ended_on_the_robot_is_noticed(
    machine: Machine, run: subprocess.Popen[str]
) -> None:
    machine.root("pkill -KILL -f [a]sync_wrapper; pkill -KILL -f 'sleep 700[0]'")
    text = ended(run)
    assert run.returncode == 2, text
    assert "FINISHED other" in text
    assert re.search(
        r"\n  robot failed: 'Work for long' did not reach its end: it was ended from outside", text
    )


def test_a_robot_without_power_is_noticed_and_the_other_goes_on(
    machine: Machine, run: subprocess.Popen[str], tmp_path: Path
) -> None:
    machine.cut()  # the last test of this file
    text = ended(run)
    assert run.returncode == 4, text
    assert "FINISHED other" in text
    assert re.search(r"\n  robot did not answer: no answer for \d+ s during 'Work for long'", text)
    assert "the run reached its end on 1 of 2 robots" in text
