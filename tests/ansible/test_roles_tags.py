"""The tags of provision.yml: each selects tasks, and a stack's tag that stack's step only."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

PLAYBOOKS = Path(__file__).resolve().parents[2] / "ansible"
STEPS = {
    "qiskit": "Step 5: Qiskit of the appendix",
    "pennylane": "Step 6: PennyLane of the appendix",
    "braket": "Step 7: Amazon Braket of the appendix",
    "dwave": "Step 11: D-Wave Ocean of the appendix",
    "science": "Step 3: TensorFlow and PySCF of the appendix",
}


@cache
def tasks() -> dict[str, set[str]]:
    """Tags of every task, by `role : task`, as ansible-playbook lists them."""
    program = Path(sys.executable).parent / "ansible-playbook"
    if not program.is_file():
        pytest.skip("no ansible-playbook beside this Python")
    done = subprocess.run(
        [program, "--inventory", "robot,", "--list-tasks", PLAYBOOKS / "provision.yml"],
        env=os.environ | {"ANSIBLE_CONFIG": str(PLAYBOOKS / "ansible.cfg")},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    rows = re.findall(r"^ +(.+?)\tTAGS: \[(.*)\]$", done.stdout, re.MULTILINE)
    return {name: set(tags.split(", ")) for name, tags in rows}


def promised() -> list[str]:
    """Tags that the head of the playbook names."""
    head = (PLAYBOOKS / "provision.yml").read_text().split("- name:")[0]
    text = " ".join(line.lstrip("# ") for line in head.splitlines())
    listed = re.search(r"Tags: (.*?)\. docs", text)
    assert listed
    words = re.findall(r"\b[a-z]+\d*\b", listed[1].replace("step4 ... step11", ""))
    plain = [word for word in words if word not in ("and", "for", "the", "paper", "s", "appendix")]
    return plain + [f"step{number}" for number in range(3, 12)]


def test_every_tag_that_is_promised_selects_tasks() -> None:
    names = promised()
    assert len(names) > 20
    for tag in names:
        selected = [name for name, tags in tasks().items()
                    if (tag in tags or (name.startswith(f"{tag} : ") and "always" in tags))
                    and "Validating arguments" not in name]  # fmt: skip
        assert selected, tag


def test_a_robot_is_looked_at_whatever_the_tag() -> None:
    looked = [tags for name, tags in tasks().items() if name.startswith("preflight : ")]
    assert looked
    assert all("always" in tags for tags in looked)


@pytest.mark.parametrize("tag", STEPS)
def test_the_tag_of_a_stack_selects_its_step_only(tag: str) -> None:
    steps = {f"stacks : {title}" for title in STEPS.values()}
    assert steps <= set(tasks())
    selected = {name for name in steps if tag in tasks()[name]}
    assert selected == {f"stacks : {STEPS[tag]}"}
