"""The paper's appendix: every one of its eleven steps has a role or a generator, and a check."""

from __future__ import annotations

import re
from pathlib import Path

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


def steps() -> dict[str, list[str]]:
    found: dict[str, list[str]] = yaml.safe_load(
        (ROOT / "ansible/roles/stacks/defaults/main.yml").read_text()
    )["stacks_steps"]
    return found


def profiles() -> dict[str, list[str]]:
    found: dict[str, list[str]] = yaml.safe_load(
        (ROOT / "ansible/roles/stacks/defaults/main.yml").read_text()
    )["stacks_profiles"]
    return found


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
    play = yaml.safe_load((ROOT / "ansible/provision.yml").read_text())[0]
    tags = {tag for part in play["pre_tasks"] + play["roles"] for tag in part["tags"]}
    for row in rows():
        for tag in words(row[2]):
            assert tag in tags, tag


def test_what_the_roles_ask_for_is_what_the_table_promises() -> None:
    asked = {name for names in steps().values() for name in names}
    promised = {name for row in rows() for name in words(row[3])}
    assert asked == promised


@pytest.mark.parametrize(("profile", "health"), [("solver",) * 2, ("edge",) * 2, ("lab", "full")])
def test_every_check_of_a_profile_is_asked_for_once(profile: str, health: str) -> None:
    asked = [name for step in profiles()[profile] for name in steps()[step]]
    assert sorted(asked) == sorted(check.name for check in checks.choose(profile=health))
