"""``qrobot solve --each-robot``: central batches, own sequences."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli.test_commands import QUESTION, one_sentence, qrobot


def test_each_robot_plans_its_own_sequences(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    words = ("--each-robot", "neal", "--reads", "20", "--max-work", "20", "-o", plan)
    done = qrobot("solve", QUESTION, *words)
    assert done.returncode == 0, done.stderr
    assert "each robot's own sequences by neal: 84.11, the central plan 84.11" in done.stdout
    assert "central 52.97, own 52.97 (neal by itself" in done.stdout
    assert qrobot("check", plan, QUESTION).returncode == 0
    told = json.loads(plan.read_text())["result"]["each_robot"]
    assert (told["backend"], told["price"], len(told["trips"])) == ("neal", 0.0, 2)
    assert told["trips"][0]["sampler"]["reads"] == 20


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--each-robot", "nobody"], "nobody"),
        (["--each-robot", "exact", "--reads", "5"], "backend exact takes no option num_reads"),
        (["--each-robot", "neal", "--dry-run"], "--each-robot: --dry-run makes no plan yet"),
    ],
)
def test_each_robot_refuses_what_it_cannot_do(words: list[str], says: str) -> None:
    done = qrobot("solve", QUESTION, *words)
    assert done.returncode == 2
    assert says in one_sentence(done)
