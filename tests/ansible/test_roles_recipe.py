"""The role of the recipe on a bare Debian machine: QROBOT_ROLES=1, as root, some minutes.

The tests of this file are one story in their sequence.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from machine import Machine
from recipe_house import follow

FILE = "/etc/lldpd.d/qrobot.conf"


@pytest.fixture(scope="module")
def playbooks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return follow(tmp_path_factory.mktemp("checkout"))


def test_its_tag_installs_and_starts_it_and_a_second_run_changes_nothing(
    machine: Machine, playbooks: Path
) -> None:
    options = (str(playbooks / "provision.yml"), "--tags", "lldp")
    foretold = machine.playbook(*options, "--check", "--diff", qrobot_lldp=True)
    assert foretold.code == 0, foretold.text[-4000:]
    done = machine.playbook(*options, qrobot_lldp=True, lldp_place="aisle 7")
    assert done.code == 0, done.text[-4000:]
    assert 'description "aisle 7"' in machine.root(f"cat {FILE}")
    assert machine.root("systemctl is-enabled lldpd.service").strip() == "enabled"
    again = machine.playbook(*options, qrobot_lldp=True, lldp_place="aisle 7")
    assert (again.code, again.changed) == (0, 0), f"{again.changes} {again.text[-4000:]}"


def test_drift_sees_its_file_and_its_unit(machine: Machine, playbooks: Path) -> None:
    machine.playbook(str(playbooks / "drift.yml"))
    (seen,) = json.loads((machine.folder / "fetched/inventory.json").read_text())["robots"]
    digest = machine.root(f"sha256sum {FILE}").split()[0]
    assert seen["inventory"]["files"][FILE] == digest
    assert seen["inventory"]["units"]["lldpd.service"]["enabled"] == "enabled"


def test_reset_takes_it_away(machine: Machine, playbooks: Path) -> None:
    done = machine.playbook(str(playbooks / "reset.yml"), reset_confirm="robot")
    assert done.code == 0, done.text[-4000:]
    assert machine.ssh(f"test -e {FILE}").returncode == 1
