"""Who follows the recipe of a role has one that is selected, installed, compared, reset, linted."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fleet_house import ANSIBLE
from recipe_house import PAGE, follow
from release_house import program

yaml = pytest.importorskip("yaml")


@pytest.fixture(scope="module")
def playbooks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return follow(tmp_path_factory.mktemp("checkout"))


def run(playbooks: Path, *command: str | Path) -> subprocess.CompletedProcess[str]:
    settings = os.environ | {
        "ANSIBLE_CONFIG": str(playbooks / "ansible.cfg"), "ANSIBLE_NOCOLOR": "1",
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }  # fmt: skip
    return subprocess.run(
        command, cwd=playbooks, env=settings, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def owned(playbooks: Path) -> dict[str, Any]:
    """What the roles make of their facts on a robot with the new role, and on one without."""
    (drift,) = yaml.safe_load((playbooks / "drift.yml").read_text())
    (look,) = [task["qrobot_inventory"] for task in drift["tasks"] if "qrobot_inventory" in task]
    asked = dict.fromkeys(("on", "off"), "{{ base_packages | to_json }}")
    asked["compared"] = (
        f"{{{{ [{look['files'].strip('{} ')}, {look['units'].strip('{} ')}] | to_json }}}}"
    )
    asked["removed"] = "{{ reset_files | to_json }}"
    copies = [
        {"ansible.builtin.copy": {"content": expression, "dest": f"{{{{ playbook_dir }}}}/{name}"},
         "delegate_to": "localhost", "become": False, "vars": {"qrobot_lldp": name == "on"}}
        for name, expression in asked.items()
    ]  # fmt: skip
    machine = {"codename": "trixie", "swap_managed": False}
    files = [str(playbooks / f"roles/{role}/defaults/main.yml")
             for role in ("base", "qrobot", "reset")]  # fmt: skip
    one = {"hosts": "all", "gather_facts": False, "vars_files": files, "tasks": copies}
    (playbooks / "ask.yml").write_text(json.dumps([one]))
    done = run(
        playbooks, program("ansible-playbook"), "--inventory", "robot,", "--connection", "local",
        "--extra-vars", json.dumps({"machine": machine}), "ask.yml",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return {name: json.loads((playbooks / name).read_text()) for name in asked}


@pytest.mark.slow
def test_it_is_selected_by_its_tag_with_what_it_needs(playbooks: Path) -> None:
    done = run(
        playbooks, program("ansible-playbook"), "--inventory", "robot,", "--list-tasks",
        "--tags", "lldp", "provision.yml",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "lldp : Say where the robot stands" in done.stdout
    assert "base : Install Debian's packages" in done.stdout
    assert "release : Install the release" not in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("switched", [True, False])
def test_its_packages_are_installed_where_it_is_switched_on(
    owned: dict[str, Any], switched: bool
) -> None:
    asked = owned["on" if switched else "off"]
    assert ("lldpd" in asked) == switched
    assert "libgomp1" in asked


@pytest.mark.slow
def test_its_file_and_unit_are_compared_and_its_file_is_removed(owned: dict[str, Any]) -> None:
    files, units = owned["compared"]
    assert "/etc/lldpd.d/qrobot.conf" in files
    assert "lldpd.service" in units
    assert "/etc/lldpd.d/qrobot.conf" in owned["removed"]


@pytest.mark.parametrize(
    ("file", "text"),
    [("vars/owns.yml", "  files: [/etc/lldpd.d/qrobot.conf]\n"), ("vars/owns.yml", "lldp_owns:"),
     ("vars/owns.yml", "  units: [lldpd.service]\n")],
)  # fmt: skip
def test_it_passes_the_check_which_fails_where_a_part_of_the_recipe_is_left_out(
    playbooks: Path, file: str, text: str
) -> None:
    check = (sys.executable, ANSIBLE / "controller/check_roles.py", playbooks)
    assert run(playbooks, *check).returncode == 0
    path = playbooks / "roles/lldp" / file
    whole = path.read_text()
    path.write_text(whole.replace(text, "x:" if text.endswith(":") else ""))
    try:
        done = run(playbooks, *check)
    finally:
        path.write_text(whole)
    assert done.returncode == 1
    assert "lldp" in done.stderr


@pytest.mark.slow
def test_it_passes_lint(playbooks: Path) -> None:
    done = run(playbooks, program("yamllint"), "--strict", "roles/lldp", "provision.yml")
    assert (done.returncode, done.stdout) == (0, "")
    # The playbook without its other roles, which `make lint` lints and the recipe does not change.
    whole = (playbooks / "provision.yml").read_text()
    head, roles, _ = re.split(r"^(  roles:\n.*?)(?=^  post_tasks:)", whole, flags=re.M | re.S)
    entries = re.split(r"^(?=    - role: )", roles, flags=re.M)
    (ours,) = [entry for entry in entries if entry.startswith("    - role: lldp\n")]
    (playbooks / "alone.yml").write_text(f"{head.partition('  pre_tasks:')[0]}{entries[0]}{ours}")
    done = run(playbooks, program("ansible-lint"), "-q", "--nocolor", "alone.yml", "roles/lldp")
    assert (done.returncode, done.stdout) == (0, ""), done.stderr


def test_the_page_names_every_key_of_a_role() -> None:
    keys = {
        key
        for path in ANSIBLE.glob("roles/*/vars/owns.yml")
        for key in yaml.safe_load(path.read_text())[f"{path.parts[-3]}_owns"]
    }
    table = PAGE.read_text().partition("The keys of `owns.yml`")[2]
    # These are for one role each.
    assert {key for key in keys if f"| `{key}` |" not in table} == {"steps", "kernel_words"}
