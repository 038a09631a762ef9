"""The paper's appendix: every one of its eleven steps has a role or a generator, and a check."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from qrobot.cli.main import COMMANDS
from qrobot.health import checks

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).resolve().parents[2]
ROLES = {path.name for path in (ROOT / "ansible/roles").iterdir()}
NAMES = {check.name for check in checks.choose()}


def rows() -> list[list[str]]:
    text = (ROOT / "docs/provisioning.md").read_text()
    table = text.partition("## The paper's appendix")[2].partition("\n## ")[0]
    lines = [line for line in table.splitlines() if re.match(r"\| \d+\. ", line)]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def words(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def owns(role: str) -> dict[str, Any]:
    text = (ROOT / f"ansible/roles/{role}/vars/owns.yml").read_text()
    found: dict[str, Any] = yaml.safe_load(text)[f"{role}_owns"]
    return found


STEPS: list[dict[str, Any]] = owns("stacks")["steps"]


def test_eleven_steps_each_with_a_role_or_a_generator_and_a_check() -> None:
    table = rows()
    assert [int(row[0].split(".")[0]) for row in table] == list(range(1, 12))
    for row in table:
        made = words(row[1])
        assert made, row
        for name in made:
            command = name.split()
            assert name in ROLES or (command[0] == "qrobot" and command[1] in COMMANDS), name
        proven = words(row[3])
        assert proven, row
        assert set(proven) <= NAMES, set(proven) - NAMES


def test_tags_of_the_table_are_tags_of_the_playbook() -> None:
    tags = {tag for role in ROLES for tag in owns(role)["tags"]}
    tags |= {tag for step in STEPS for tag in step["tags"]}
    for row in rows():
        for tag in words(row[2]):
            assert tag in tags, tag


def test_what_the_roles_ask_for_is_what_the_table_promises() -> None:
    asked = {name for step in STEPS for name in step["checks"]}
    promised = {name for row in rows() for name in words(row[3])}
    assert asked == promised


@pytest.mark.parametrize(("profile", "health"), [("solver",) * 2, ("edge",) * 2, ("lab", "full")])
def test_every_check_of_a_profile_is_asked_for_once(profile: str, health: str) -> None:
    asked = [name for step in STEPS if profile in step["profiles"] for name in step["checks"]]
    assert sorted(asked) == sorted(check.name for check in checks.choose(profile=health))
