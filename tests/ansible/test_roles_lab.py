"""The largest profile on a bare Debian machine: JupyterLab and the desktop, each for who may.

QROBOT_ROLES_LAB=1 switches it on, for root: it fetches more than a gigabyte of wheels once.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable

import pytest
from machine import RELEASE, Machine, Run
from processes import until

pytestmark = pytest.mark.skipif(
    os.environ.get("QROBOT_ROLES_LAB") != "1", reason="QROBOT_ROLES_LAB=1 switches it on: 1.5 GB"
)
DESKTOP = RELEASE == "trixie"  # Debian's bookworm has no labwc
ASK = """python3 - <<'END'
import urllib.error, urllib.request
token = open("/etc/qrobot/jupyter.token").read().strip().partition("=")[2]
for given in ("", "wrong", token):
    head = {"Authorization": f"token {given}"} if given else {}
    asked = urllib.request.Request("http://127.0.0.1:8888/api/contents", headers=head)
    try:
        print(urllib.request.urlopen(asked).status)
    except urllib.error.HTTPError as error:
        print(error.code)
END"""


@pytest.fixture(scope="module")
def provisioned(provision: Callable[..., Run]) -> Run:
    done = provision(qrobot_profile="lab", qrobot_desktop=DESKTOP)
    if done.code:
        pytest.fail(done.text[-6000:])
    return done


def test_every_check_of_the_lab_passes(machine: Machine, provisioned: Run) -> None:
    report = json.loads((machine.folder / "fetched/robot.json").read_text())
    checks = {check["name"]: check["status"] for check in report["checks"]}
    assert {name for name, status in checks.items() if status != "pass"} == set()
    assert {"tensorflow", "pyscf", "litert", "jupyter"} <= set(checks)


def test_jupyter_answers_its_token_on_the_loopback_only(machine: Machine, provisioned: Run) -> None:
    listens = "ss -Hlnt sport = :8888 | grep -q ."
    until(lambda: machine.ssh(listens).returncode == 0, "Jupyter listens")
    assert machine.root(ASK).split() == ["403", "403", "200"]
    sockets = [line.split()[3] for line in machine.root("ss -Hlnt").splitlines()]
    assert [one for one in sockets if one.endswith(":8888")] == ["127.0.0.1:8888"]
    token = machine.root("cat /etc/qrobot/jupyter.token").strip().partition("=")[2]
    assert len(token) == 48
    assert token not in machine.root("cat /proc/[0-9]*/cmdline | tr '\\0' ' '")
    assert token not in machine.root("journalctl --no-pager")


@pytest.mark.skipif(not DESKTOP, reason="Debian's bookworm has no labwc")
def test_the_desktop_runs_as_a_user_who_has_no_tokens(machine: Machine, provisioned: Run) -> None:
    assert machine.root("systemctl is-active qrobot-desktop.service").strip() == "active"
    users = machine.root("ps -o user:20= -C labwc,wayvnc,foot").split()
    assert set(users) == {"qrobot-desktop"}
    read = "setpriv --reuid qrobot-desktop --regid qrobot-desktop --clear-groups"
    assert "denied" in machine.root(f"{read} ls /var/lib/qrobot 2>&1 || true")
    assert "denied" in machine.root(f"{read} cat /etc/qrobot/jupyter.token 2>&1 || true")


def test_a_second_run_changes_nothing(provisioned: Run, provision: Callable[..., Run]) -> None:
    again = provision(qrobot_profile="lab", qrobot_desktop=DESKTOP)
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"
