"""config.txt and cmdline.txt: what qrobot_boot makes of them, and what it leaves alone."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "ansible/plugins/modules/qrobot_boot.py"
BOOTS = Path(__file__).parent / "fixtures" / "boot"
WORDS = ["cgroup_enable=memory", "cgroup_memory=1"]
LINES = ["arm_64bit=1", "dtparam=watchdog=on"]

pytest.importorskip("ansible", reason="ansible-core is not installed")


def load() -> ModuleType:
    spec = importlib.util.spec_from_file_location("qrobot_boot", PROGRAM)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


boot = load()

word = st.sampled_from(
    ["console=tty1", "console=serial0,115200", "root=PARTUUID=8a-02", "rootwait", "quiet", "splash",
     "cgroup_enable=cpuset", "cgroup_memory=0", "cgroup_disable=memory", "init=/x", "a.b-c=d;e=f"]
)  # fmt: skip
cmdline = st.builds(
    lambda words, space, end: space.join(words) + end,
    st.lists(word, min_size=1, max_size=8),
    st.sampled_from([" ", "  "]),
    st.sampled_from(["", "\n", "\r\n", "\n\n"]),
)
line = st.sampled_from(
    ["", "# a comment", "dtparam=audio=on", "[cm4]", "[cm5]", "[pi5]", "[all]", "[none]",
     "[gpio4=1]", "otg_mode=1", "dtoverlay=dwc2,dr_mode=host", "  spaced = 1 ", "arm_64bit=0",
     "überschrift=1", "include more.txt"]
)  # fmt: skip
config = st.builds(
    lambda lines, newline, end: newline.join(lines) + end,
    st.lists(line, max_size=14),
    st.sampled_from(["\n", "\r\n"]),
    st.sampled_from(["", "\n", "\r\n"]),
)


def settings_of(text: str) -> list[tuple[str, str]]:
    """Each setting with the section that it counts in, as the firmware reads them."""
    section, found = "[all]", []
    for one in text.splitlines():
        one = one.strip()
        if re.fullmatch(r"\[.*\]", one):
            section = one
        elif one and not one.startswith("#"):
            found.append((section, one))
    return found


@given(text=cmdline)
def test_a_command_line_gets_its_words_once_and_keeps_the_others(text: str) -> None:
    new = boot.cmdline_with(text, WORDS)
    assert boot.cmdline_with(new, WORDS) == new
    assert new.endswith("\n")
    assert new.count("\n") == 1
    found, before = new.split(), text.split()
    assert [found.count(one) for one in WORDS] == [1, 1]
    replaced = [one for one in before if one == "cgroup_memory=0"]
    assert [one for one in found if one not in WORDS] == [
        one for one in before if one not in [*WORDS, *replaced]
    ]


@given(text=cmdline.filter(lambda text: "cgroup_memory=0" not in text))
def test_absent_undoes_present_on_a_command_line(text: str) -> None:
    there = boot.cmdline_with(text, WORDS)
    assert boot.cmdline_with(there, WORDS, present=False).split() == text.split()


@given(text=config)
def test_a_config_counts_for_every_board_and_loses_nothing(text: str) -> None:
    new = boot.config_with(text, LINES)
    assert boot.config_with(new, LINES) == new
    assert new.startswith(text.rstrip("\n"))
    assert settings_of(new) == [*settings_of(text), *(("[all]", one) for one in LINES)]
    undone = boot.config_with(new, LINES, present=False)
    assert undone.rstrip("\n") == text.rstrip("\n")


@given(text=config, later=st.lists(line, max_size=5), other=st.sampled_from([LINES, ["x=1"]]))
def test_what_others_append_later_keeps_its_section(
    text: str, later: list[str], other: list[str]
) -> None:
    # raspi-config and people append to the end, which is under the block's [all].
    grown = boot.config_with(text, LINES) + "".join(f"{one}\n" for one in later)
    for present in (True, False):
        new = boot.config_with(grown, other, present=present)
        ours = {("[all]", one) for one in [*LINES, "x=1"]}
        theirs = [one for one in settings_of(grown) if one not in ours]
        assert [one for one in settings_of(new) if one not in ours] == theirs
        assert boot.config_with(new, other, present=present) == new


def program() -> Path:
    path = Path(sys.executable).parent / "ansible"
    if not path.is_file():
        pytest.skip("no program ansible beside this Python")
    return path


def run(folder: Path, *, check: bool = False, **more: Any) -> dict[str, Any]:
    """Run the module on a folder of this computer, by itself."""
    given = {"folder": str(folder), "cmdline": WORDS, "config": LINES} | more
    done = subprocess.run(
        [sys.executable, PROGRAM],
        input=json.dumps({"ANSIBLE_MODULE_ARGS": given | {"_ansible_check_mode": check}}),
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def run_by_ansible(folder: Path) -> dict[str, Any]:
    """Run the module as Ansible does."""
    given = {"folder": str(folder), "cmdline": WORDS, "config": LINES}
    done = subprocess.run(
        [program(), "localhost", "--inventory", "localhost,", "--connection", "local",
         "--extra-vars", json.dumps({"ansible_python_interpreter": sys.executable}),
         "--module-name", "qrobot_boot", "--args", json.dumps(given)],
        env=os.environ | {"ANSIBLE_LIBRARY": str(PROGRAM.parent), "ANSIBLE_BECOME": "0",
                          "ANSIBLE_NOCOLOR": "1", "ANSIBLE_LOAD_CALLBACK_PLUGINS": "1",
                          "ANSIBLE_STDOUT_CALLBACK": "ansible.builtin.minimal"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    answer: dict[str, Any] = json.loads(done.stdout.split("=> ", 1)[1])
    return answer


@pytest.mark.parametrize(
    ("name", "run"), [("trixie", run_by_ansible), ("bullseye", run), ("windows", run)]
)
def test_real_files_once_and_not_again(
    tmp_path: Path, name: str, run: Callable[[Path], dict[str, Any]]
) -> None:
    folder = tmp_path / "boot"
    shutil.copytree(BOOTS / name, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    first = run(folder)
    assert (first["changed"], sorted(first["files"])) == (True, ["cmdline.txt", "config.txt"])
    after = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert {f"{name}.before-qrobot": text for name, text in before.items()}.items() <= after.items()
    assert len(after) == 4
    assert after["config.txt"].startswith(before["config.txt"].rstrip(b"\n"))
    assert not run(folder)["changed"]
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == after


def test_a_check_changes_nothing_and_an_empty_command_line_is_refused(tmp_path: Path) -> None:
    shutil.copytree(BOOTS / "trixie", tmp_path, dirs_exist_ok=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert run(tmp_path, check=True)["changed"]
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    (tmp_path / "cmdline.txt").write_text("")
    refused = run(tmp_path)
    assert "cmdline.txt is empty: restore it" in refused["msg"]
    assert (tmp_path / "config.txt").read_bytes() == before["config.txt"]


def test_absent_leaves_what_the_owner_had_and_no_copies(tmp_path: Path) -> None:
    (tmp_path / "cmdline.txt").write_text(f"root=/dev/x {WORDS[0]}\n")
    (tmp_path / "config.txt").write_text("arm_64bit=1\n")
    before = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert run(tmp_path)["changed"]
    assert run(tmp_path, state="absent")["changed"]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == before
    assert not run(tmp_path, state="absent")["changed"]


def test_a_copy_that_a_cut_left_empty_is_made_again(tmp_path: Path) -> None:
    shutil.copytree(BOOTS / "trixie", tmp_path, dirs_exist_ok=True)
    first = (tmp_path / "cmdline.txt").read_bytes()
    (tmp_path / "cmdline.txt.before-qrobot").touch()
    assert run(tmp_path)["changed"]
    assert (tmp_path / "cmdline.txt.before-qrobot").read_bytes() == first
