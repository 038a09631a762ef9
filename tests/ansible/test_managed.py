"""What the roles write is known to drift and to reset, and what they start is held to limits."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from test_links import ANSIBLE, module_of, tasks

yaml = pytest.importorskip("yaml")
UNITS = sorted(ANSIBLE.glob("roles/*/templates/*.service.j2"))


def owns(role: str) -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((ANSIBLE / f"roles/{role}/vars/owns.yml").read_text())
    return found[f"{role}_owns"]


def owned(*keys: str) -> dict[str, str]:
    """Return what the roles own, with the role."""
    found = {}
    for path in sorted(ANSIBLE.glob("roles/*/vars/owns.yml")):
        role = path.parts[-3]
        for key in keys:
            found.update(dict.fromkeys(owns(role).get(key, []), role))
    return found


def written() -> Iterator[tuple[str, str]]:
    """Every file that a task of the roles writes on the robot, with the task's role."""
    for place, task in tasks():
        module, given = module_of(task)
        if module not in ("copy", "template") or task.get("delegate_to") or "roles/" not in place:
            continue
        for item in task.get("loop") if isinstance(task.get("loop"), list) else [None]:
            dest = given["dest"].replace("{{ item }}", str(item))
            if "src" in given and dest.endswith("/"):
                continue  # of many files: the parts of qrobot-release have a test of their own
            if dest.startswith("/"):
                yield dest, place.split("/")[1]


def test_every_file_that_a_role_writes_is_its_own() -> None:
    known = owned("files", "shared", "stays", "uncompared")
    found = dict(written())
    assert len(found) > 12
    assert found == {path: known.get(path) for path in found}


def test_what_is_not_compared_is_secret_or_of_one_robot() -> None:
    """Everything else that is written is held against the other robots."""
    compared = owned("files", "shared", "stays")
    rest = {path for path, _ in written() if path not in compared}
    assert all(path.startswith("/etc/qrobot/") for path in rest)


def test_reset_removes_what_the_roles_own_and_says_why_something_stays() -> None:
    steps = yaml.safe_load((ANSIBLE / "roles/reset/tasks/main.yml").read_text())
    removed = next(step for step in steps if step["name"] == "Remove files and folders")
    assert removed["loop"] == "{{ reset_files + reset_ours.files | map(attribute='path') }}"
    stays = owned("stays")
    assert set(stays) == {"/etc/default/prometheus-node-exporter", "/etc/docker/daemon.json"}
    for role in set(stays.values()):
        assert all(len(reason.split()) > 3 for reason in owns(role)["stays"].values())


def test_the_program_of_the_releases_is_owned_whole() -> None:
    folder = ANSIBLE / "plugins/module_utils/qrobot_release"
    files = {Path(path).name for path in owned("files") if "/qrobot_release/" in path}
    assert files == {path.name for path in folder.glob("*.py")}


def test_every_unit_that_a_role_starts_is_looked_at() -> None:
    started: dict[str, Any] = {}
    for place, task in tasks():
        module, given = module_of(task)
        if module == "systemd_service" and given.get("enabled") is True:
            started[given["name"]] = place.split("/")[1]
    assert len(started) > 5
    units = owned("units")
    assert started == {name: units.get(name) for name in started}


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
