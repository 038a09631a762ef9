"""The tags of provision.yml: each selects tasks, and a stack's tag that stack's step only."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from fleet_house import LOCAL, play

yaml = pytest.importorskip("yaml")
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
    """Tags that the roles own, and the steps of the paper's appendix."""
    owned: set[str] = set()
    for path in PLAYBOOKS.glob("roles/*/vars/owns.yml"):
        owns = yaml.safe_load(path.read_text())[f"{path.parts[-3]}_owns"]
        owned.update(owns["tags"], *(step["tags"] for step in owns.get("steps", [])))
    return sorted(owned | {f"step{number}" for number in range(1, 12)})


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


def steps_run(folder: Path, *options: str, profile: str = "lab", without: str = "") -> list[str]:
    """Steps that the role stacks asks for, of a robot whose report has every check but one."""
    owns = yaml.safe_load((PLAYBOOKS / "roles/stacks/vars/owns.yml").read_text())["stacks_owns"]
    names = {name for step in owns["steps"] for name in step["checks"]} - {without}
    checks = [{"name": name, "status": "pass"} for name in sorted(names)]
    (folder / "r1.json").write_text(json.dumps({"checks": checks}))
    variables = {"stacks_tags": "{{ lookup('qrobot_owns', 'selected_by', by_role=true).stacks }}"}
    role = {"role": str(PLAYBOOKS / "roles/stacks"), "tags": "{{ stacks_tags }}"}
    one = {"hosts": "all", "gather_facts": False, "vars": variables, "roles": [role]}
    (folder / "play.yml").write_text(json.dumps([one]))
    done = play(
        folder, folder / "play.yml", {"robot": LOCAL}, *options, qrobot_profile=profile,
        qrobot_reports=str(folder), qrobot_fetched=str(folder / "fetched"),
        release_installed={"id": "r1"},
    )  # fmt: skip
    assert (done.returncode == 0) == (not without), done.stdout + done.stderr
    assert f"robot: {without} did not pass; the report is " in done.stdout or not without
    return re.findall(r"^TASK \[\S*stacks : ((?:Step|Planners).*)\]", done.stdout, re.MULTILINE)


@pytest.mark.parametrize(
    "tag", ["qiskit", *(pytest.param(t, marks=pytest.mark.slow) for t in STEPS if t != "qiskit")]
)
def test_the_tag_of_a_stack_selects_its_step_only(tag: str, tmp_path: Path) -> None:
    assert steps_run(tmp_path, "--tags", tag) == [STEPS[tag]]


@pytest.mark.slow
def test_a_profile_has_its_steps_and_a_check_that_did_not_pass_is_named(tmp_path: Path) -> None:
    assert len(steps_run(tmp_path)) == 9
    assert steps_run(tmp_path, "--tags", "stacks", profile="solver") == [
        "Step 3: Python of the appendix", "Planners",
    ]  # fmt: skip
    assert steps_run(tmp_path, "--tags", "step10") == []
    assert steps_run(tmp_path, "--tags", "qiskit", without="aer") == [STEPS["qiskit"]]
