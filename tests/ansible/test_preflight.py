"""What preflight refuses by its own reckoning, whatever zone the controller is in."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from fleet_house import play

yaml = pytest.importorskip("yaml")
ROLE = Path(__file__).resolve().parents[2] / "ansible/roles/preflight"

SLOW = pytest.mark.slow
Hosts = dict[str, dict[str, Any]]


def playbook(
    folder: Path, tasks: list[Any], hosts: Hosts, *options: str, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run tasks on hosts that have variables."""
    path = folder / "play.yml"
    path.write_text(json.dumps([{"hosts": "all", "gather_facts": False, "tasks": tasks}]))
    return play(folder, path, hosts, *options, environment=environment)


def run_task(
    folder: Path, task: str, hosts: Hosts, zone: str = "UTC"
) -> tuple[set[str], dict[str, str]]:
    """Run one task of the role here: the hosts that passed, and what it said of the others."""
    tasks = yaml.safe_load((ROLE / "tasks/main.yml").read_text())
    chosen = [one for one in tasks if one["name"] == task]
    assert len(chosen) == 1
    defaults = yaml.safe_load((ROLE / "defaults/main.yml").read_text())
    local = {**defaults, "ansible_connection": "local"}
    hosts = {name: local | variables for name, variables in hosts.items()}
    said = playbook(folder, chosen, hosts, TZ=zone).stdout
    refused = re.findall(r"^fatal: \[(\w+)\]: FAILED! => (.*)$", said, re.M)
    passed = set(re.findall(r"^ok: \[(\w+)\]$", said, re.M))
    return passed, {name: json.loads(answer)["msg"] for name, answer in refused}


@pytest.mark.parametrize(
    "zone", ["America/New_York", *(pytest.param(z, marks=SLOW) for z in ("UTC", "Asia/Kolkata"))]
)
def test_a_clock_is_told_right_from_wrong_in_every_zone(tmp_path: Path, zone: str) -> None:
    now = int(time.time())
    hours = {"right": 0, "slow": -5, "fast": 5}
    hosts = {name: {"machine": {"time": now + off * 3600}} for name, off in hours.items()}
    passed, refused = run_task(tmp_path, "Refuse a wrong clock", hosts, zone)
    assert passed == {"right"}
    assert refused.keys() == {"slow", "fast"}
    for message in refused.values():
        assert now <= int(message.split("date --set=@")[1]) <= time.time()


def test_a_home_that_the_sandboxes_hide_is_refused(tmp_path: Path) -> None:
    homes = {"good": "/var/lib/qrobot", "hidden": "/home/qrobot"}
    hosts = {name: {"qrobot_home": home} for name, home in homes.items()}
    passed, refused = run_task(tmp_path, "Refuse a home that the services may not see", hosts)
    assert (passed, refused.keys()) == ({"good"}, {"hidden"})


SSH = """#!{python}
import json, sys
open({told!r} + sys.argv[-2], "w").write(json.dumps(sys.argv[1:]))
sys.exit({code})
"""


def log_in(
    folder: Path, hosts: Hosts, *options: str, code: int = 0
) -> tuple[int, str, dict[str, list[str]]]:
    """Run the role's trial of the key with a stand-in for ssh: code, text, words by address."""
    programs, told = folder / "programs", folder / "told"
    programs.mkdir()
    told.mkdir()
    (programs / "ssh").write_text(SSH.format(python=sys.executable, told=f"{told}/", code=code))
    (programs / "ssh").chmod(0o755)
    tasks = [{"ansible.builtin.include_tasks": str(ROLE / "tasks/key.yml")}]
    python = {"ansible_python_interpreter": sys.executable}
    hosts = {name: python | variables for name, variables in hosts.items()}
    path = f"{programs}:{os.environ['PATH']}"
    done = playbook(folder, tasks, hosts, *options, PATH=path)
    words = {path.name: json.loads(path.read_text()) for path in told.iterdir()}
    return done.returncode, done.stdout + done.stderr, words


QUOTED = {
    '-o ProxyCommand="ssh -W %h:%p -q jump"': ["-o", "ProxyCommand=ssh -W %h:%p -q jump"],
    "-o 'ProxyCommand ssh -W %h:%p jump'": ["-o", "ProxyCommand ssh -W %h:%p jump"],
    '-o "ProxyCommand=nc -X 5 -x proxy:1080 %h %p"': [
        "-o", "ProxyCommand=nc -X 5 -x proxy:1080 %h %p",
    ],
    "-o UserKnownHostsFile='/srv/my fleet/known_hosts' -4": [
        "-o", "UserKnownHostsFile=/srv/my fleet/known_hosts", "-4",
    ],
    "-o ProxyCommand='sh -c \"exec $HELPER %h\"'": ["-o", 'ProxyCommand=sh -c "exec $HELPER %h"'],
    "-J me@jump:2222": ["-J", "me@jump:2222"],
    "": [],
}  # fmt: skip


@pytest.mark.slow
def test_arguments_of_ssh_may_be_quoted(tmp_path: Path) -> None:
    hosts, wanted = {}, {}
    for name in ("ansible_ssh_common_args", "ansible_ssh_extra_args"):
        for given, words in QUOTED.items():
            host = f"picker-{len(hosts)}"
            hosts[host], wanted[host] = {name: given}, words
    code, text, told = log_in(tmp_path, hosts)
    assert code == 0, text
    for host, words in wanted.items():
        assert told[host][-2:] == [host, "true"]
        assert told[host][len(told[host]) - 2 - len(words) : -2] == words, hosts[host]


def test_the_trial_logs_in_as_ansible_does(tmp_path: Path) -> None:
    cases: list[tuple[dict[str, Any], list[str]]] = [
        ({"ansible_host": "10.0.0.4", "ansible_port": 2222, "ansible_user": "pi"},
         ["-p 2222", "-l pi", "10.0.0.4 true"]),
        ({"ansible_ssh_host": "10.0.0.5", "ansible_ssh_port": 23, "ansible_ssh_user": "me"},
         ["-p 23", "-l me", "10.0.0.5 true"]),
        ({"ansible_ssh_private_key_file": "/srv/my key"},
         ["-i /srv/my key -o IdentitiesOnly=yes", "picker-2 true"]),
        ({"ansible_private_key_file": "/srv/key"},
         ["-i /srv/key -o IdentitiesOnly=yes", "picker-3 true"]),
        ({}, ["-p 22", "picker-4 true"]),
    ]  # fmt: skip
    hosts = {f"picker-{number}": variables for number, (variables, _) in enumerate(cases)}
    code, text, told = log_in(tmp_path, hosts)
    assert code == 0, text
    assert len(told) == len(cases)
    for _, words in cases:
        address = words[-1].removesuffix(" true")
        for one in words:
            assert one in " ".join(told[address])


@pytest.mark.slow
def test_the_command_line_names_the_user_and_the_key(tmp_path: Path) -> None:
    key = tmp_path / "key"
    code, text, told = log_in(tmp_path, {"picker-1": {}}, "--user", "me", "--private-key", str(key))
    assert code == 0, text
    words = " ".join(told["picker-1"])
    assert f"-i {key} -o IdentitiesOnly=yes -l me picker-1 true" in words


def test_a_robot_that_no_key_opens_is_refused(tmp_path: Path) -> None:
    code, text, _ = log_in(tmp_path, {"picker-1": {}}, code=255)
    assert code == 2
    assert "picker-1: no key logs in" in text
