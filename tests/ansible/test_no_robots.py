"""Inventories that cannot be read or name nobody: every playbook and every make target refuses."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from fleet_house import ANSIBLE
from release_house import program
from started import Program, run

ROOT = ANSIBLE.parent
PLAYBOOKS = sorted(path.stem for path in ANSIBLE.glob("*.yml"))
SETTINGS = {
    "ANSIBLE_CONFIG": str(ANSIBLE / "ansible.cfg"), "ANSIBLE_HOME": "{folder}",
    "ANSIBLE_LOCAL_TEMP": "{folder}", "ANSIBLE_NOCOLOR": "1",
}  # fmt: skip
# As it is in a shell of that folder.
BY_HAND = Program("ansible-playbook", "playbook_program:main", environment=SETTINGS)
PLAY = Program(
    "play.py", "playbook_program:play", ("ansible.inventory.manager",), environment=SETTINGS
)
GOOD = "all:\n  hosts:\n    picker-1:\n    picker-2:\n  children:\n    empty:\n"
GOOD += "  vars: {ansible_connection: local}\n"
# Inventory, limit, and what play.py says.
CASES = {
    "YAML error": ({"hosts.yml": "all:\n  hosts:\n    a:\n   b: {x\n"}, "", "hosts.yml: line 4"),
    "tab": ({"hosts.yml": "all:\n\thosts:\n"}, "", "hosts.yml: line 2, column 1"),
    "YAML error in one of two": ({"a.yml": GOOD, "b.yml": "all: ["}, "", "b.yml: line 1"),
    "YAML error in variables": (
        {"hosts.yml": GOOD, "group_vars/all.yml": "x: 'a\n"}, "", "group_vars/all.yml: line",
    ),
    "not an inventory": ({"hosts.yml": "- a\n- b\n"}, "", "it cannot be read"),
    "not UTF-8": ({"hosts.yml": "all: {hosts: {m\udcfcller: }}\n"}, "", "is not UTF-8"),
    "empty file": ({"hosts.yml": ""}, "", "it names no robot"),
    "empty document": ({"hosts.yml": "---\n"}, "", "cannot be read"),
    "no hosts": ({"hosts.yml": "all:\n  hosts:\n"}, "", "it names no robot"),
    "empty folder": ({}, "", "it cannot be read"),
    "limit that matches nobody": ({"hosts.yml": GOOD}, "pikcer-1", "did you mean 'picker-1'?"),
    "limit of which a part matches nobody": (
        {"hosts.yml": GOOD}, "picker-1,lab", "'lab' is not a robot or a group",
    ),
    "limit that excludes nobody": ({"hosts.yml": GOOD}, "all:!lab", "'lab' is not a robot"),
    "limit to an empty group": ({"hosts.yml": GOOD}, "empty", "'empty' is not a robot or a group"),
    "limit that leaves nobody": ({"hosts.yml": GOOD}, "all:!all", "leaves no robot"),
    "limit that is this machine": ({"hosts.yml": GOOD}, "localhost", "leaves no robot"),
}  # fmt: skip


def lay(folder: Path, files: dict[str, str]) -> Path:
    inventory = folder / "inventory"
    inventory.mkdir()
    for name, text in files.items():
        path = inventory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", errors="surrogateescape")
    return inventory


def call(*command: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    settings = {**os.environ, "ANSIBLE_NOCOLOR": "1", "NO_COLOR": "1", **environment}
    return subprocess.run(
        command, env=settings, capture_output=True, text=True, check=False, timeout=300,
        stdin=subprocess.DEVNULL,
    )  # fmt: skip


@pytest.fixture
def playbook() -> str:
    """ansible-playbook beside this Python, as play.py looks for it."""
    path = Path(sys.executable).parent / "ansible-playbook"
    if not path.is_file():
        pytest.skip("no ansible-playbook beside this Python")
    return str(path)


# The check knows no playbook: one has all cases, the others one that the limit decides.
@pytest.mark.parametrize(
    ("name", "case"),
    [(PLAYBOOKS[0], case) for case in CASES]
    + [(name, "limit that leaves nobody") for name in PLAYBOOKS[1:]],
)
def test_play_says_in_one_sentence_what_is_wrong(
    playbook: str, tmp_path: Path, name: str, case: str
) -> None:
    files, limit, says = CASES[case]
    words = [name, "--inventory", lay(tmp_path, files), *(["--limit", limit] if limit else [])]
    done = run(*words, program=PLAY)
    assert done.returncode == 2
    assert done.stdout == ""
    assert re.sub(r"\n$", "", done.stderr).count("\n") == 0, done.stderr
    assert says in done.stderr


# What ansible.cfg refuses is refused before the playbook is read, the rest by each playbook.
BY_CONFIGURATION = (
    "YAML error", "YAML error in one of two", "limit that matches nobody",
    "limit of which a part matches nobody", "missing",
)  # fmt: skip
BY_PLAYBOOK = ("no hosts", "limit that leaves nobody")


@pytest.mark.parametrize(
    ("name", "case"),
    [(PLAYBOOKS[0], case) for case in BY_CONFIGURATION]
    + [(name, case) for name in PLAYBOOKS for case in BY_PLAYBOOK],
)
def test_a_playbook_run_by_hand_refuses_too(
    playbook: str, tmp_path: Path, name: str, case: str
) -> None:
    files, limit, _ = CASES.get(case, ({}, "", ""))
    inventory = lay(tmp_path, files) if case in CASES else tmp_path / "missing.yml"
    words = ["--inventory", inventory, ANSIBLE / f"{name}.yml"]
    words += ["--limit", limit] if limit else []
    done = run(*words, environment={"HOME": str(tmp_path)}, program=BY_HAND)
    assert done.returncode != 0
    assert "[ERROR]: " in done.stderr
    assert "PLAY [" not in done.stdout, "it began"


def targets() -> dict[str, str]:
    """Every make target that runs a playbook, with the playbook."""
    text = (ROOT / "Makefile").read_text()
    found = re.findall(r"^([a-z-]+):[^\n]*\n(?:\t[^\n]*\n)*?\t\$\(play\) (\w+) ", text, re.M)
    return dict(found)


def test_every_playbook_has_its_target_and_no_target_goes_another_way() -> None:
    assert sorted(targets().values()) == PLAYBOOKS
    text = (ROOT / "Makefile").read_text()
    recipes = [line for line in text.splitlines() if line.startswith("\t")]
    assert not [line for line in recipes if "ansible-playbook" in line]


# A limit that matches nobody is told only where both the inventory and the limit are handed on.
@pytest.mark.parametrize(
    ("target", "case"),
    [(target, "limit that matches nobody") for target in sorted(targets())]
    + [(min(targets()), case) for case in ("YAML error", "missing")],
)
def test_make_fails_with_the_sentence(
    playbook: str, tmp_path: Path, target: str, case: str
) -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    files, limit, says = CASES.get(case, ({}, "", "no such inventory"))
    inventory = lay(tmp_path, files) if case in CASES else tmp_path / "missing"
    venv = Path(sys.executable).parents[1]
    # The environment is taken as it is: -o says that its stamp is not to be made anew.
    command = ["make", "-C", ROOT, f"VENV={venv}", "-o", f"{venv}/.installed-provision", target]
    done = call(*command, f"INVENTORY={inventory}", f"LIMIT={limit}", MAKEFLAGS="", MAKELEVEL="")
    assert done.returncode == 2
    assert says in done.stderr


def test_a_good_inventory_is_taken_in_each_of_its_forms(playbook: str, tmp_path: Path) -> None:
    vault = "$ANSIBLE_VAULT;1.1;AES256\n3131: [\n"
    folder = lay(tmp_path, {"hosts.yml": GOOD, "group_vars/all/vault.yml": vault})
    (tmp_path / "hosts.ini").write_text("[pickers]\npicker-[1:3]\n")
    (tmp_path / "tags.yml").write_text("all: {hosts: {a: {x: !vault 'secret', y: !unsafe 'z'}}}\n")
    code = "from check_inventory import check\n"
    for inventory, limit in (
        (folder, ""), (folder, "picker-1"), (folder, "picker-*:!picker-2"), (folder, "~pick.*"),
        (tmp_path / "hosts.ini", "pickers"), (tmp_path / "tags.yml", ""), ("10.0.0.4,", ""),
        (ANSIBLE / "inventory.example", "lab_bench"),
    ):  # fmt: skip
        code += f"check([{str(inventory)!r}], {limit!r})\n"
    done = call(sys.executable, "-c", code, PYTHONPATH=f"{ANSIBLE / 'controller'}:{ROOT}")
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_exit_code_of_the_playbook_is_told_and_kept(playbook: str, tmp_path: Path) -> None:
    program("ssh")
    dead = "all: {hosts: {gone: {ansible_host: 127.0.0.1, ansible_port: 1}}}\n"
    folder = lay(tmp_path, {"hosts.yml": dead})
    play = [sys.executable, ANSIBLE / "controller/play.py", "rollback", "--inventory", str(folder)]
    done = call(*play, ANSIBLE_SSH_RETRIES="0")
    assert done.returncode == 4
    assert "rollback: exit code 4: a robot did not answer" in done.stderr
    assert "gone did not answer: " in done.stdout
    done = call(*play, "-e", "qrobot_profile=huge")
    assert done.returncode == 2
    assert "rollback: exit code 2: a robot failed" in done.stderr
    assert call(*play, "--nonsense").returncode == 2
    assert call(*play[:2], "provisoin").returncode == 2
