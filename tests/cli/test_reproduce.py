"""`qrobot reproduce` as people and programs meet it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import started

from qrobot.cli import main

ROOT = Path(__file__).resolve().parents[2]
QROBOT = [sys.executable, "-m", "qrobot"]
HEAVY = {"numpy", "dimod", "matplotlib", "numba", "qiskit", "pennylane", "braket", "dwave"}


def qrobot(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return started.run(*words)


def code_of(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as done:
        main([str(word) for word in words])
    return int(done.value.code or 0)


def test_help_has_examples_and_loads_nothing_heavy() -> None:
    code = (
        "import sys\nfrom qrobot.cli import main\n"
        "try: main(['reproduce', '--help'])\nexcept SystemExit: pass\nprint('#', *sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    text, _, modules = done.stdout.rpartition("#")
    assert "qrobot reproduce all --quick" in text
    assert "places are" in text
    assert not {name.split(".")[0] for name in modules.split()} & HEAVY


@pytest.mark.slow
def test_json_is_all_that_is_printed(tmp_path: Path) -> None:
    done = qrobot("reproduce", "table2", "--rows", "2", "--quick", "--reads", "20", "--json",
                  "--output", tmp_path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report == json.loads((tmp_path / "reproduce.json").read_text())
    assert report["schema"] == "qrobot.reproduce/1"
    lines = done.stderr.splitlines()
    ended = [line for line in lines if not line.endswith(" ...")]
    assert len(ended) == len(report["lines"]) == 7  # a line of progress each
    begun = [line for line in lines if line.endswith(" ...")]
    assert len(begun) == sum(line["status"] == "done" for line in report["lines"])
    assert "2, 10 qubits, neal" in done.stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["table1", "--rows", "2-20"], "beyond the tables"),
        (["table1", "--reads", "0"], "--reads"),
        (["table9"], "table9"),
        (["table1", "--docs", "/nowhere/page.md"], "/nowhere/page.md"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(
    words: list[str], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert code_of("reproduce", *words, "-o", tmp_path / "new") == 2
    told = capsys.readouterr().err
    assert says in told
    assert "Traceback" not in told
    assert not (tmp_path / "new").exists()


def test_a_folder_that_cannot_be_made_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert code_of("reproduce", "table1", "-o", tmp_path / "file" / "x") == 2
    assert "cannot be made" in capsys.readouterr().err


def test_a_backend_that_fails_is_code_3(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from qrobot.backends.annealing.samplers import DescentSampler
    from qrobot.errors import BackendError

    def fail(*_: object, **__: object) -> None:
        raise BackendError("the descent slipped")

    monkeypatch.setattr(DescentSampler, "sample", fail)
    words = ("table3", "--rows", "2", "--quick", "--reads", "10", "-o", tmp_path)
    assert code_of("reproduce", *words) == 3
    assert "descent: - (the descent slipped)" in capsys.readouterr().err


def test_an_interrupted_run_says_130_and_keeps_its_rows(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*QROBOT, "reproduce", "table2", "--rows", "4", "--reads", "2000", "-o", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert process.stderr is not None
    assert "n = 4, 24 qubits, neal ..." in process.stderr.readline()
    assert "n = 4, 24 qubits, neal: " in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    _, told = process.communicate()
    assert process.returncode == 130, told
    assert "lines are kept" in told
    report = json.loads((tmp_path / "reproduce.json").read_text())
    assert report["interrupted"]
    assert report["lines"][0]["method"] == "neal"
    assert report["lines"][0]["status"] == "done"
