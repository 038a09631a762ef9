"""``qrobot picklist``: formats, files, exit codes."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest
from cli.test_commands import EXAMPLES, QUESTION, one_sentence, qrobot


def test_the_terminal_gets_a_table(plan: Path) -> None:
    done = qrobot("picklist", plan, QUESTION)
    assert (done.returncode, done.stderr) == (0, "")
    assert "R1, trip 1 of 1: 4 picks, 4 baskets, load 15 of 15" in done.stdout
    assert len(done.stdout.splitlines()) == 2 * 3 + 7 + 1


def test_the_ending_of_the_output_says_the_format(plan: Path, tmp_path: Path) -> None:
    for name in ("x.csv", "x.json"):
        done = qrobot("picklist", plan, QUESTION, "-o", tmp_path / name)
        assert (done.returncode, done.stdout) == (
            0, f"written: {tmp_path / name} (2 lists, 7 picks)\n",
        )  # fmt: skip
    rows = list(csv.DictReader(io.StringIO((tmp_path / "x.csv").read_text())))
    data = json.loads((tmp_path / "x.json").read_text())
    assert [row["item"] for row in rows] == [
        pick["item"] for trip in data["trips"] for pick in trip["picks"]
    ]
    done = qrobot("picklist", plan, QUESTION, "-o", tmp_path / "x.txt", "--format", "csv")
    assert (tmp_path / "x.txt").read_text() == (tmp_path / "x.csv").read_text()


def test_json_is_all_that_is_printed(plan: Path, tmp_path: Path) -> None:
    whole = json.loads(qrobot("picklist", plan, QUESTION, "--json").stdout)
    assert whole["schema"] == "qrobot.picklist/1"
    done = qrobot("picklist", plan, QUESTION, "--json", "--robot", "R2", "-o", tmp_path / "x.csv")
    assert json.loads(done.stdout)["trips"] == whole["trips"][1:]
    assert len((tmp_path / "x.csv").read_text().splitlines()) == 1 + 3
    done = qrobot("picklist", plan, QUESTION, "--format", "csv")
    assert len(list(csv.reader(io.StringIO(done.stdout)))) == 1 + 7


def test_json_stays_json_on_a_terminal_without_letters(tmp_path: Path) -> None:
    question, plan = tmp_path / "q.json", tmp_path / "p.json"
    document = json.loads(QUESTION.read_text())
    document["items"][0]["article"] = "Schräubchen \u4e2d"
    question.write_text(json.dumps(document))
    assert qrobot("solve", question, "-o", plan).returncode == 0
    for words in (["--json"], ["--format", "json"]):
        done = qrobot("picklist", plan, question, *words, env={"PYTHONIOENCODING": "ascii"})
        articles = {
            pick["article"] for trip in json.loads(done.stdout)["trips"] for pick in trip["picks"]
        }
        assert "Schräubchen \u4e2d" in articles


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--robot", "R9"], "'R9' is not a robot here; use one of: R1, R2"),
        (["-o", "x.txt"], "does not say the format"),
        (["--json", "--format", "csv"], "--json contradicts --format csv"),
        (["--paper", "a5"], "add --format html"),
        (["-o", "no/such/x.csv"], "does not exist"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(plan: Path, words: list[str], sentence: str) -> None:
    done = qrobot("picklist", plan, QUESTION, *words)
    assert done.returncode == 2
    assert sentence in one_sentence(done)


def test_a_plan_of_another_question_is_refused(plan: Path) -> None:
    done = qrobot("picklist", plan, EXAMPLES / "paper-4-items.json")
    assert done.returncode == 2
    assert "not in the instance" in one_sentence(done)
    done = qrobot("picklist", plan, QUESTION, "--capacity", "12")
    assert done.returncode == 2
    assert "the plan is not right for this instance" in one_sentence(done)
