"""What preflight refuses by its own reckoning, whatever zone the controller is in."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml")
ROLE = Path(__file__).resolve().parents[2] / "ansible/roles/preflight"


def run_task(folder: Path, task: str, zone: str = "UTC", **variables: object) -> tuple[bool, str]:
    """Run one task of the role on this computer; returns whether it passed, and what it said."""
    program = Path(sys.executable).parent / "ansible-playbook"
    if not program.is_file():
        pytest.skip("no ansible-playbook beside this Python")
    tasks = yaml.safe_load((ROLE / "tasks/main.yml").read_text())
    chosen = [one for one in tasks if one["name"] == task]
    assert len(chosen) == 1
    play = {"hosts": "localhost", "gather_facts": False, "tasks": chosen}
    (folder / "play.yml").write_text(yaml.safe_dump([play]))
    defaults = yaml.safe_load((ROLE / "defaults/main.yml").read_text())
    done = subprocess.run(
        [program, "--inventory", "localhost,", "--connection", "local",
         "--extra-vars", json.dumps(defaults | variables), folder / "play.yml"],
        env=os.environ | {"TZ": zone, "ANSIBLE_BECOME": "0", "ANSIBLE_NOCOLOR": "1"},
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip
    return done.returncode == 0, done.stdout


@pytest.mark.parametrize("zone", ["UTC", "America/New_York", "Asia/Kolkata"])
def test_a_clock_is_told_right_from_wrong_in_every_zone(tmp_path: Path, zone: str) -> None:
    now = int(time.time())
    task = "Refuse a wrong clock"
    assert run_task(tmp_path, task, zone, machine={"time": now})[0]
    for wrong in (-5 * 3600, 5 * 3600):
        passed, said = run_task(tmp_path, task, zone, machine={"time": now + wrong})
        assert not passed
        told = int(said.split("date --set=@")[1].split('"')[0].split()[0])
        assert 0 <= told - now < 60


def test_a_home_that_the_sandboxes_hide_is_refused(tmp_path: Path) -> None:
    task = "Refuse a home that the services may not see"
    assert run_task(tmp_path, task, qrobot_home="/var/lib/qrobot")[0]
    assert not run_task(tmp_path, task, qrobot_home="/home/qrobot")[0]


SSH = """#!{python}
import json, sys
open({told!r}, "w").write(json.dumps(sys.argv[1:]))
sys.exit({code})
"""


def log_in(
    folder: Path, code: int = 0, options: tuple[str, ...] = (), **variables: object
) -> tuple[int, str, list[str]]:
    """Run the role's trial of the key with a stand-in for ssh: the code, the text, its words."""
    program = Path(sys.executable).parent / "ansible-playbook"
    if not program.is_file():
        pytest.skip("no ansible-playbook beside this Python")
    programs, told = folder / "programs", folder / "words.json"
    programs.mkdir()
    (programs / "ssh").write_text(SSH.format(python=sys.executable, told=str(told), code=code))
    (programs / "ssh").chmod(0o755)
    tasks = [{"ansible.builtin.include_tasks": str(ROLE / "tasks/key.yml")}]
    (folder / "play.yml").write_text(
        json.dumps([{"hosts": "picker-1", "gather_facts": False, "tasks": tasks}])
    )
    hosts = {"picker-1": {"ansible_python_interpreter": sys.executable, **variables}}
    (folder / "inventory.json").write_text(json.dumps({"all": {"hosts": hosts}}))
    done = subprocess.run(
        [program, "--inventory", folder / "inventory.json", *options,
         folder / "play.yml"],
        env=os.environ | {"ANSIBLE_NOCOLOR": "1", "PATH": f"{programs}:{os.environ['PATH']}"},
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr, json.loads(told.read_text())


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ('-o ProxyCommand="ssh -W %h:%p -q jump"', ["-o", "ProxyCommand=ssh -W %h:%p -q jump"]),
        ("-o 'ProxyCommand ssh -W %h:%p jump'", ["-o", "ProxyCommand ssh -W %h:%p jump"]),
        (
            '-o "ProxyCommand=nc -X 5 -x proxy:1080 %h %p"',
            ["-o", "ProxyCommand=nc -X 5 -x proxy:1080 %h %p"],
        ),
        (
            "-o UserKnownHostsFile='/srv/my fleet/known_hosts' -4",
            ["-o", "UserKnownHostsFile=/srv/my fleet/known_hosts", "-4"],
        ),
        (
            "-o ProxyCommand='sh -c \"exec $HELPER %h\"'",
            ["-o", 'ProxyCommand=sh -c "exec $HELPER %h"'],
        ),
        ("-J me@jump:2222", ["-J", "me@jump:2222"]),
        ("", []),
    ],
)
@pytest.mark.parametrize("name", ["ansible_ssh_common_args", "ansible_ssh_extra_args"])
def test_arguments_of_ssh_may_be_quoted(
    tmp_path: Path, name: str, given: str, words: list[str]
) -> None:
    code, text, told = log_in(tmp_path, **{name: given})
    assert code == 0, text
    assert told[-2:] == ["picker-1", "true"]
    assert told[len(told) - 2 - len(words) : -2] == words


@pytest.mark.parametrize(
    ("variables", "words"),
    [
        ({"ansible_host": "10.0.0.4", "ansible_port": 2222, "ansible_user": "pi"},
         ["-p 2222", "-l pi", "10.0.0.4 true"]),
        ({"ansible_ssh_host": "10.0.0.5", "ansible_ssh_port": 23, "ansible_ssh_user": "me"},
         ["-p 23", "-l me", "10.0.0.5 true"]),
        ({"ansible_ssh_private_key_file": "/srv/my key"}, ["-i /srv/my key -o IdentitiesOnly=yes"]),
        ({"ansible_private_key_file": "/srv/key"}, ["-i /srv/key -o IdentitiesOnly=yes"]),
        ({}, ["-p 22", "picker-1 true"]),
    ],
)  # fmt: skip
def test_the_trial_logs_in_as_ansible_does(
    tmp_path: Path, variables: dict[str, object], words: list[str]
) -> None:
    code, text, told = log_in(tmp_path, **variables)
    assert code == 0, text
    for one in words:
        assert one in " ".join(told)


def test_the_command_line_names_the_user_and_the_key(tmp_path: Path) -> None:
    key = tmp_path / "key"
    options = ("--user", "me", "--private-key", str(key))
    code, text, told = log_in(tmp_path, options=options)
    assert code == 0, text
    assert f"-i {key} -o IdentitiesOnly=yes -l me picker-1 true" in " ".join(told)


def test_a_robot_that_no_key_opens_is_refused(tmp_path: Path) -> None:
    code, text, _ = log_in(tmp_path, code=255)
    assert code == 2
    assert "picker-1: no key logs in" in text
