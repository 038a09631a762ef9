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
