"""Drift and health of a bare Debian machine, over real SSH: `QROBOT_ROLES=1`, as root, two minutes.

The tests of this file are one story in their sequence.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from machine import Machine, Run


def look(machine: Machine) -> tuple[Run, dict[str, Any], dict[str, Any]]:
    """Run drift.yml: its answer, what is told of the machine, and what was seen."""
    done = machine.playbook("drift.yml")
    folder = machine.folder / "fetched"
    assert (folder / "drift.json").exists(), done.text[-4000:]
    (told,) = json.loads((folder / "drift.json").read_text())["robots"]
    (seen,) = json.loads((folder / "inventory.json").read_text())["robots"]
    return done, told, seen["inventory"]


def test_a_bare_machine_has_no_release_and_no_health(machine: Machine) -> None:
    done, told, seen = look(machine)
    assert told["drift"] == ["no release is in use"]
    assert done.code == 2
    assert done.counts["changed"] == 0
    assert seen["codename"] == machine.root(". /etc/os-release; echo $VERSION_CODENAME").strip()
    done = machine.playbook("health.yml")
    assert done.code == 2
    assert "robot sent no report" in done.why()


def test_a_machine_just_provisioned_has_no_drift(
    machine: Machine, provision: Callable[..., Run]
) -> None:
    done = provision()
    assert done.code == 0, done.text[-6000:]
    done, told, seen = look(machine)
    assert done.code == 0, (told, done.text[-3000:])
    assert told["state"] == "same"
    assert told["release"]["in_use"] == told["release"]["wanted"]
    site = "/opt/qrobot/current/lib/python3*/site-packages"
    listed = machine.root(f"ls -d {site}/*.dist-info | wc -l")
    assert len(seen["packages"]) == int(listed) > 20
    hashed = machine.root("sha256sum /etc/nftables.conf").split()[0]
    assert seen["files"]["/etc/nftables.conf"] == hashed
    assert seen["units"]["qrobot-health.timer"] == {"enabled": "enabled", "active": "active"}


def test_what_a_hand_changed_is_named(machine: Machine) -> None:
    machine.root(
        "cd /opt/qrobot/current/lib/python3*/site-packages"
        " && mv click-*.dist-info click-0.1.dist-info"
        " && sed -i 's/^Version: .*/Version: 0.1/' click-0.1.dist-info/METADATA"
        " && touch /run/reboot-required"
    )
    done, told, _ = look(machine)
    assert done.code == 2
    assert told["packages"]["other"]["click"]["has"] == "0.1"
    assert any("damaged" in line for line in told["drift"])
    assert told["notes"][0] == "restart: asked for by a package"


def test_a_machine_sends_a_new_report_each_time(machine: Machine) -> None:
    made = []
    for _ in range(2):
        done = machine.playbook("health.yml", health_poll=2)
        found = json.loads((machine.folder / "fetched/fleet.json").read_text())
        assert found["notes"] == [], done.text[-4000:]
        assert done.code == (0 if found["machines"][0]["healthy"] else 2)
        made.append(found["machines"][0]["made"])
    assert made[0] < made[1]
