"""``qrobot export``: files that other programs read back to the same energies."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import dimod
import numpy as np
import pytest
from dimod.serialization import coo

import qrobot
from qrobot.cli import main
from qrobot.models import build_model

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
QUESTION = EXAMPLES / "paper-4-items.json"

needs_docplex = pytest.mark.skipif(
    importlib.util.find_spec("docplex") is None,
    reason="docplex is not installed: pip install 'qrobot[docplex]'",
)


def code_of(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as done:
        main(["export", *(str(word) for word in words)])
    return int(done.value.code or 0)


def one_sentence(capsys: pytest.CaptureFixture[str]) -> str:
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert told.err.startswith("qrobot: ")
    return told.err


@pytest.mark.parametrize("name", ["model.bqm.json", "model.JSON"])
def test_json_is_read_by_dimod(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    assert code_of(QUESTION, path, "--json") == 0
    report = json.loads(capsys.readouterr().out)
    found = dimod.BinaryQuadraticModel.from_serializable(json.loads(path.read_text()))
    model = build_model(qrobot.read(QUESTION), penalties="safe")
    assert found == model.bqm
    assert report["path"] == str(path)
    assert report["format"] == "bqm"
    assert report["encoding"] == "compact"
    assert report["slack"] == "exact"
    assert report["variables"] == len(found.variables)
    assert report["couplings"] == found.num_interactions
    assert report["penalties"]["visit"] == model.penalties.visit


def test_coordinates_are_read_by_dimod_without_a_lost_digit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.coo"
    assert code_of(QUESTION, path, "--encoding", "reduced", "--slack", "paper") == 0
    assert "reduced: 48 variables" in capsys.readouterr().out
    text = path.read_text()
    found = coo.loads(text)
    model = build_model(qrobot.read(QUESTION), "reduced", "paper", "safe")
    comments = [line.split(maxsplit=3) for line in text.splitlines() if line.startswith("# var")]
    names = [words[3] for words in comments if words[1] == "variable"]
    assert names == model.variables
    offset = next(line for line in text.splitlines() if line.startswith("# offset="))
    found.offset = float(offset.partition("=")[2])
    assert found.relabel_variables(dict(enumerate(names)), inplace=False) == model.bqm
    bits = np.random.default_rng(0).integers(0, 2, (50, len(names)))
    np.testing.assert_array_equal(
        found.energies((bits, range(len(names)))), model.bqm.energies((bits, names))
    )


def test_what_the_lowest_energy_is_worth_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.coo"
    assert code_of(QUESTION, path) == 0
    told = capsys.readouterr().out
    assert "The lowest energy of this model is the best plan." in told
    assert "lack the constant" in told
    assert code_of(QUESTION, path, "--penalties", "measured") == 0
    assert "need not be a plan: --penalties safe" in capsys.readouterr().out
    assert code_of(QUESTION, path, "--encoding", "reduced", "--slack", "paper") == 0
    assert "need not be a plan" in capsys.readouterr().out


def test_a_circuit_beside_a_model_or_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = ("--robots", "1", "--capacity", "45")
    path = tmp_path / "plan.qasm"
    assert code_of(QUESTION, "--circuit", path, *small, "--json") == 0
    report = json.loads(capsys.readouterr().out)["circuit"]
    text = path.read_text()
    assert f"qubit[{report['qubits']}] q;" in text
    assert report["plans"] == 24
    assert code_of(QUESTION, tmp_path / "m.coo", "--circuit", path, *small) == 0
    assert "382 of them on two qubits" in capsys.readouterr().out
    assert code_of(QUESTION, "--circuit", path, *small, "--mixer", "blender") == 2
    assert "'blender' is not a mixer" in one_sentence(capsys)
    assert code_of(QUESTION) == 2
    assert "--circuit FILE" in capsys.readouterr().err


@needs_docplex
@pytest.mark.parametrize(
    ("options", "variables", "capacity"),
    [
        ((), 40, " <= 15"),
        (("--encoding", "full", "--robots", "1", "--capacity", "45"), 30, " <= 45"),
        (("--slack", "exact"), 48, " = 15"),
    ],
)
def test_lp_files(
    options: tuple[str, ...],
    variables: int,
    capacity: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / "model.lp"
    assert code_of(QUESTION, path, *options, "--json") == 0
    told = capfd.readouterr()
    report = json.loads(told.out)
    assert told.err == ""
    assert report["variables"] == variables
    assert report["penalties"] is None
    text = path.read_text()
    head, _, rest = text.partition("Subject To")
    rows = " ".join(rest.partition("Bounds")[0].split())
    assert rows.count(":") == report["constraints"]
    assert head.count("*") == report["couplings"]
    load = rows.partition("capacity_1:")[2].partition(":")[0]
    assert capacity in load
    assert len(rest.partition("Binaries")[2].split()) == variables + 1  # and "End"


@needs_docplex
def test_orders_in_csv(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "model.lp"
    words = (EXAMPLES / "orders.csv", path, "--layout", EXAMPLES / "layout.json", "--robots", "2")
    assert code_of(*words) == 0
    whole = capsys.readouterr().out
    assert " order_" in path.read_text()
    assert code_of(*words, "--split-orders") == 0
    assert capsys.readouterr().out != whole
    assert " order_" not in path.read_text()


@pytest.mark.parametrize(
    ("name", "options", "told"),
    [
        ("model.txt", (), "use .lp, .bqm.json, .bqm or .coo"),
        ("model", (), "use .lp, .bqm.json, .bqm or .coo"),
        ("no/folder.json", (), "does not exist"),
        pytest.param(
            "model.lp", ("--encoding", "compact"), "'compact' is unknown", marks=needs_docplex
        ),
        ("model.json", ("--encoding", "magic"), "encoding: 'magic' is unknown"),
        ("model.coo", ("--slack", "wide"), "slack: 'wide' is unknown"),
        pytest.param(
            "model.lp", ("--slack", "wide"), "slack: 'wide' is unknown", marks=needs_docplex
        ),
        ("model.json", ("--robots", "x"), "--robots"),
    ],
)
def test_bad_input_is_one_sentence(
    name: str,
    options: tuple[str, ...],
    told: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert code_of(QUESTION, tmp_path / name, *options) == 2
    assert told in one_sentence(capsys)
    assert not list(tmp_path.iterdir())


def test_the_input_is_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    question = tmp_path / "question.json"
    question.write_text(QUESTION.read_text())
    assert code_of(question, question) == 2
    assert "is an input" in one_sentence(capsys)
    assert question.read_text() == QUESTION.read_text()


def test_a_plan_that_cannot_be_is_infeasible(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert code_of(QUESTION, tmp_path / "model.coo", "--capacity", "1") == 1
    assert not list(tmp_path.iterdir())
    assert "no robot holds more than 1" in one_sentence(capsys)


def test_an_absent_extra_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in ("docplex", "docplex.mp", "docplex.mp.model"):
        monkeypatch.setitem(sys.modules, module, None)
    assert code_of(QUESTION, tmp_path / "model.lp") == 3
    assert "pip install 'qrobot[docplex]'" in one_sentence(capsys)
    assert not list(tmp_path.iterdir())


def test_an_absent_extra_is_told_before_anything_heavy_is_imported(tmp_path: Path) -> None:
    code = (
        "import sys\nsys.modules['docplex'] = None\nfrom qrobot.cli import main\n"
        f"try: main(['export', {str(QUESTION)!r}, {str(tmp_path / 'model.lp')!r}])\n"
        "except SystemExit as done: assert done.code == 3, done.code\n"
        "assert not {'numpy', 'dimod', 'pydantic'} & set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr


def test_an_old_file_stays_when_the_new_one_cannot_be_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.coo"
    path.write_text("old")
    assert code_of(QUESTION, path, "--capacity", "1") == 1
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["model.coo"]
    capsys.readouterr()
    if os.geteuid():  # root may write everything
        path.chmod(0o444)
        assert code_of(QUESTION, path) == 2


def test_help_has_examples_and_loads_nothing_heavy() -> None:
    code = (
        "import sys\nfrom qrobot.cli import main\n"
        "try: main(['export', '--help'])\nexcept SystemExit: pass\n"
        "assert not {'numpy', 'dimod', 'docplex', 'qiskit'} & set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    assert "qrobot export examples/paper-7-items.json picking.lp" in done.stdout
