"""What the roles write is known to drift and to reset, and what they start is held to limits."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from test_links import ANSIBLE, leaves, module_of, tasks

yaml = pytest.importorskip("yaml")
UNITS = sorted(ANSIBLE.glob("roles/*/templates/*.service.j2"))
# Not held against other robots: secret, made while it provisions, or another one on every robot.
OWN = ("/etc/qrobot/", "/run/", "/opt/qrobot/bin/uv")
# What reset leaves, and why: its docs say so.
STAYS = {
    "/etc/default/prometheus-node-exporter": "without it node_exporter would listen on the network",
    "/etc/docker/daemon.json": "Debian's package stays, with small logs and closed ports",
}


def written() -> Iterator[tuple[str, str]]:
    """Every file that a task of the roles writes on the robot, with where it does."""
    for place, task in tasks():
        module, given = module_of(task)
        if module not in ("copy", "template") or task.get("delegate_to") or "roles/" not in place:
            continue
        for item in task.get("loop") if isinstance(task.get("loop"), list) else [None]:
            dest = given["dest"].replace("{{ item }}", str(item))
            dest = dest.replace("{{ qrobot_root }}", "/opt/qrobot")
            if "src" in given and dest.endswith("/"):
                continue  # of many files: the parts of qrobot-release have a test of their own
            if dest.startswith("/"):
                yield dest, place


def managed() -> tuple[str, ...]:
    source = (ANSIBLE / "plugins/modules/qrobot_inventory.py").read_text()
    space: dict[str, Any] = {}
    exec(source[source.index("PROGRAM =") : source.index("BOOT =")], space)
    return tuple(space["MANAGED"])


def test_every_file_that_a_role_writes_is_held_against_other_robots() -> None:
    found = dict(written())
    assert len(found) > 12
    missing = {path: place for path, place in found.items()
               if path not in managed() and not path.startswith(OWN)}  # fmt: skip
    assert missing == {}


def test_every_file_that_a_role_writes_is_removed_by_reset() -> None:
    """Or stays, for a reason."""
    steps = yaml.safe_load((ANSIBLE / "roles/reset/tasks/main.yml").read_text())
    units = yaml.safe_load((ANSIBLE / "roles/reset/defaults/main.yml").read_text())["reset_units"]
    removed = " ".join(text for step in steps for _, text in leaves(step))
    removed += " ".join(f"'/etc/systemd/system/{unit}'" for unit in units)
    removed += " '/etc/qrobot' '/opt/qrobot'"  # whole, by the names of their variables
    for name in ("zram-generator.conf", "nftables.conf"):  # where they are ours
        removed += f" '/etc/{name}' '/etc/systemd/{name}'" if name in removed else ""
    for path, place in written():
        gone = any(f"'{part}'" in removed for part in (path, *map(str, Path(path).parents)))
        assert gone != (path in STAYS), (path, place)


def test_every_unit_that_a_role_starts_is_looked_at() -> None:
    source = (ANSIBLE / "plugins/modules/qrobot_inventory.py").read_text()
    space: dict[str, Any] = {}
    exec(source[source.index("UNITS =") : source.index("def said")], space)
    started = set()
    for place, task in tasks():
        module, given = module_of(task)
        if module == "systemd_service" and given.get("enabled") is True:
            started.add(given["name"])
        assert place
    assert started
    assert started <= set(space["UNITS"])


@pytest.mark.parametrize("path", UNITS, ids=lambda path: path.name)
def test_a_service_of_ours_is_held_to_a_memory_limit_and_ends_first(path: Path) -> None:
    """A check or a notebook that eats the memory must not take the robot with it."""
    text = path.read_text()
    role = path.parents[1]
    limit = re.search(r"^MemoryMax=\{\{ (\w+) \}\}$", text, re.MULTILINE)
    assert limit
    value = yaml.safe_load((role / "defaults/main.yml").read_text())[limit[1]]
    assert re.fullmatch(r"[1-9]\d%", value)
    score = re.search(r"^OOMScoreAdjust=(\d+)$", text, re.MULTILINE)
    assert score
    assert 0 < int(score[1]) <= 1000
    if "qrobot health" in text:  # one check that is ended is told by the report of the others
        assert "\nOOMPolicy=continue\n" in text
