"""The steps of the proof on the virtual Pi, with a stand-in for the machine."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from virtual_pi import prove

PLAYBOOKS = Path(__file__).resolve().parents[2] / "ansible"


class Pi:
    """A machine on which every run ends well and changes nothing; it keeps what it was told."""

    def __init__(self, seconds: float, changed: int = 0) -> None:
        self.seconds, self.changed = seconds, changed
        self.commands: list[str] = []

    def play(self, *_: str) -> Any:
        counts = {"changed": self.changed, "failed": 0, "unreachable": 0}
        return SimpleNamespace(code=0, counts=counts, seconds=self.seconds, tail=lambda: "")

    def ssh(self, command: str) -> str:
        self.commands.append(command)
        return ""

    def cut_during(self, *_: object) -> Any:
        return SimpleNamespace(ok=True, why="")

    def start(self, network: str = "") -> float:
        return 1.0

    def reset(self) -> None:
        """Do nothing."""


class Proof(dict[str, Any]):
    """What was measured, and what did not hold."""

    def __init__(self, **known: Any) -> None:
        super().__init__(known)
        self.failed: list[str] = []

    def hold(self, what: str, held: bool, why: str = "") -> None:
        self.failed += [] if held else [what]


@pytest.mark.parametrize("first", [None, 30.0, 1042.0])
def test_a_second_run_is_judged_by_its_changes_not_by_its_time(first: float | None) -> None:
    proof = Proof(**({} if first is None else {"provision_seconds": first}))
    prove.again(Pi(seconds=900.0), proof)
    assert proof.failed == []
    assert proof["second_seconds"] == 900.0
    proof = Proof(provision_seconds=1042.0)
    prove.again(Pi(seconds=1.0, changed=1), proof)
    assert proof.failed == ["second run", "check run after it"]


def test_the_cuts_find_the_program_of_the_releases() -> None:
    pi, proof = Pi(1.0), Proof()
    prove.cuts(pi, proof)
    assert proof.failed == []
    asked = [command for command in pi.commands if "qrobot-release" in command]
    assert len(asked) == len(prove.MOMENTS)
    assert all("sudo /usr/local/sbin/qrobot-release list" in command for command in asked)


def test_no_step_calls_a_program_of_sbin_by_its_name_alone() -> None:
    roles = PLAYBOOKS / "roles"
    ours = set(re.findall(r"/usr/local/sbin/([\w-]+)", "".join(
        path.read_text() for path in roles.glob("*/tasks/*.yml"))))  # fmt: skip
    assert "qrobot-release" in ours
    text = Path(prove.__file__).read_text()
    for name in ours:
        assert not re.search(rf"(?<!/usr/local/sbin/){re.escape(name)}\b", text), name


def test_what_a_step_waits_for_is_a_task_of_the_playbooks() -> None:
    for task, _ in prove.MOMENTS:
        role, _, name = task.partition(" : ")
        texts = [path.read_text() for path in (PLAYBOOKS / "roles" / role).glob("*/*.yml")]
        assert any(f"- name: {name}" in text for text in texts), task
