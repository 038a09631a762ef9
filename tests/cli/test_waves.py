"""``qrobot waves``: files, pick lists, progress, exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli.test_commands import one_sentence, qrobot

QUESTION = "examples/small-warehouse.json"
ROOT = Path(__file__).resolve().parents[2]
WORK = ("--size", "20", "--max-work", "20")


def test_plans_pick_lists_and_a_summary(tmp_path: Path) -> None:
    done = qrobot("waves", ROOT / QUESTION, "-o", tmp_path, *WORK, "--picklists", "csv")
    assert done.returncode == 0
    assert "24 orders in 3 waves" in done.stdout
    assert "no plan of the whole pool is below" in done.stdout
    assert f"written: {tmp_path / 'waves.json'}" in done.stdout
    summary = json.loads((tmp_path / "waves.json").read_text())
    assert summary["schema"] == "qrobot.waves/1"
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        ["waves.json"]
        + [f"wave-00{k}{end}" for k in (1, 2, 3) for end in (".json", ".plan.json", ".picks.csv")]
    )
    lines = [len((tmp_path / f"wave-00{k}.picks.csv").read_text().splitlines()) for k in (1, 2, 3)]
    assert sum(lines) - 3 == summary["items"]
    checked = qrobot("check", tmp_path / "wave-002.plan.json", tmp_path / "wave-002.json")
    assert checked.returncode == 0


def test_json_is_all_that_is_printed_and_resume_goes_on(tmp_path: Path) -> None:
    words = ("waves", ROOT / QUESTION, "-o", tmp_path, *WORK)
    first = qrobot(*words, "--json")
    assert (first.returncode, first.stderr) == (0, "")
    assert json.loads(first.stdout) == json.loads((tmp_path / "waves.json").read_text())
    again = qrobot(*words)
    assert again.returncode == 2
    assert "has waves already; go on with --resume" in one_sentence(again)
    (tmp_path / "wave-003.plan.json").unlink()
    last = qrobot(*words, "--json", "--resume", "--compare")
    assert last.returncode == 0
    before, after = json.loads(first.stdout), json.loads(last.stdout)
    assert [w["cost"] for w in before["waves"]] == [w["cost"] for w in after["waves"]]
    assert before["waves"][0]["seconds"] == after["waves"][0]["seconds"]
    assert after["compared"][0]["waves"] == [1, 2, 3]


@pytest.mark.parametrize(
    ("words", "says", "code"),
    [
        (["--by", "colour"], "by: 'colour' is no way to cut", 2),
        (["--size", "3000"], "size: 3000 is not 1 to 2500 stops", 2),
        (["--by", "zone", "--zones", "0-1"], "zones: aisle 2 is in no zone", 2),
        (["--capacity", "1"], "no robot holds more than 1", 1),
        (["-b", "nonsense"], "nonsense", 2),
    ],
)
def test_errors_are_one_sentence(words: list[str], says: str, code: int, tmp_path: Path) -> None:
    done = qrobot("waves", ROOT / QUESTION, "-o", tmp_path / "new", *WORK, *words)
    assert done.returncode == code
    assert says in one_sentence(done)
    assert not list(tmp_path.rglob("*.plan.json"))
