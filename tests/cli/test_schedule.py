"""``qrobot schedule``: formats, files, exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli.test_commands import QUESTION, one_sentence, qrobot


def test_a_table_files_and_a_picture(plan: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    csv, picture = tmp_path / "x.csv", tmp_path / "x.svg"
    done = qrobot("schedule", plan, QUESTION, "-o", csv, "-p", picture)
    assert (done.returncode, done.stderr) == (0, "")
    assert "R1     1 of 1     0 s" in done.stdout
    assert "all robots are back after" in done.stdout
    assert f"written: {csv}, {picture}" in done.stdout
    assert len(csv.read_text().splitlines()) == 1 + 7 + 2
    assert "</svg>" in picture.read_text()


def test_json_is_all_that_is_printed(plan: Path, tmp_path: Path) -> None:
    done = qrobot("schedule", plan, QUESTION, "--json", "-o", tmp_path / "x.json")
    assert json.loads(done.stdout) == json.loads((tmp_path / "x.json").read_text())
    assert json.loads(done.stdout)["schema"] == "qrobot.schedule/1"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-o", "x.txt"], "'x.txt' does not say the format; end it with .csv or .json"),
        (["-p", "x.html"], "'x.html' does not say the kind of picture; end it with .svg or .png"),
        (["-o", "x.csv", "-p", "./x.csv"], "x.csv"),
        (["--capacity", "14"], "the plan is not right for this instance"),
    ],
)
def test_bad_input_is_one_sentence(plan: Path, words: list[str], says: str, tmp_path: Path) -> None:
    done = qrobot("schedule", plan, QUESTION, *words, cwd=tmp_path)
    assert done.returncode == 2
    assert says in one_sentence(done)
    assert not list(tmp_path.iterdir())
