"""The paper's rows and our methods one by one; what cannot run, and what is cut short."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from reproductions import blank, done, row_of, shortest
from stacks.stacks import needs

from qrobot.backends import registry
from qrobot.backends.annealing.samplers import NealSampler
from qrobot.backends.gate import resources
from qrobot.errors import InputError, MissingExtraError
from qrobot.models import build_model
from qrobot.study.reproduce import Settings, reproduce
from qrobot.study.reproduce.methods import METHODS, methods_for
from qrobot.study.reproduce.paper import (
    FIGURE_WEIGHTS,
    PaperRow,
    paper_rows,
    penalty_model,
    table_instance,
)
from qrobot.study.reproduce.question import Outcome, Question

# Typed from the paper's tables, not taken from our copy of them.
FULL = [18, 26, 36, 48, 62, 78, 96, 116, 138, 162, 188]
REDUCED = [10, 16, 24, 34, 46, 60, 76, 94, 115, 137, 161]
ALL_ROWS = [row for table in (1, 2, 3) for row in paper_rows(table)]


# -- the paper's rows ----------------------------------------------------------------------


def test_the_rows_are_the_papers() -> None:
    for table, qubits in ((1, FULL), (2, REDUCED), (3, REDUCED)):
        rows = paper_rows(table)
        assert [row.items for row in rows] == list(range(2, 13))
        assert [row.qubits for row in rows] == qubits
        assert {row.robots for row in rows} == {1}
        small, large = (45, 45) if table == 1 else (15, 25)
        assert [row.capacity for row in rows] == [small] * 8 + [large] * 3
        assert all(row.annealer for row in rows)
    assert sum(len(row.seconds) for row in ALL_ROWS) == 33 + 4 + 6 + 6
    assert row_of(1, 12).annealer == 63.45
    assert row_of(2, 4).seconds["ibmq_qasm_simulator"] == 537.46
    assert row_of(3, 12).annealer == 195.60
    assert "pennylane" not in row_of(2, 5).seconds


@pytest.mark.parametrize("row", ALL_ROWS, ids=lambda row: f"table{row.table}-{row.items}")
@pytest.mark.parametrize("seed", [7, 8])
def test_our_qubits_are_the_papers(row: PaperRow, seed: int) -> None:
    instance = table_instance(row, seed)
    model = build_model(instance, row.encoding, slack="paper")
    assert model.num_variables == row.qubits
    assert penalty_model(instance, row.encoding).num_variables == row.qubits
    assert (instance.size, len(instance.robots)) == (row.items, row.robots)
    assert instance.robots[0].capacity == row.capacity  # M as printed
    assert sum(item.weight for item in instance.items) <= row.capacity


def test_weights_are_those_of_the_captions() -> None:
    heavy = sorted(item.weight for item in table_instance(row_of(1, 7)).items)
    assert heavy == sorted(FIGURE_WEIGHTS)
    light = sorted(item.weight for item in table_instance(row_of(2, 7)).items)
    assert light == sorted(math.ceil(weight / 3) for weight in FIGURE_WEIGHTS)


def test_another_number_of_qubits_is_refused() -> None:
    with pytest.raises(Exception, match="has 10 qubits, the paper's 11"):
        Question.of(replace(row_of(2, 2), qubits=11), 7)


# -- methods ------------------------------------------------------------------------------


@pytest.mark.parametrize(("items", "method"), [(6, "swap"), (10, "grover")])
def test_mixers_that_keep_the_constraints_read_what_the_state_says(items: int, method: str) -> None:
    row, reads = row_of(2, items), 4000
    question = Question.of(row, 7)
    line = METHODS[method].run(blank(row, method), question, reads, 3)
    assert line.states == math.factorial(items)
    assert line.feasible == line.control_feasible == 1.0
    assert line.qubits == row.qubits
    p, uniform = line.probability, line.control_probability
    assert p is not None
    assert uniform is not None
    assert uniform == question.plans.optimal / math.factorial(items)
    assert p > 5 * uniform
    assert abs((line.share or 0) - p) < 5 * math.sqrt(p * (1 - p) / reads) + 1e-12
    assert line.best is not None
    assert line.best >= question.optimum - 1e-9


def test_a_seed_gives_the_same_reads() -> None:
    row = row_of(2, 4)
    question = Question.of(row, 7)
    first, again, other = (
        METHODS["neal"].run(blank(row, "neal"), question, 60, seed) for seed in (1, 1, 2)
    )
    assert (first.share, first.feasible, first.best) == (again.share, again.feasible, again.best)
    assert (first.share, first.feasible) != (other.share, other.feasible)
    assert question.optimum == pytest.approx(shortest(question.instance))


@needs("qiskit")
def test_a_variational_row() -> None:
    row = row_of(2, 2)
    method = METHODS["qiskit-vqe"]
    method.warm()
    line = method.run(blank(row, "qiskit-vqe"), Question.of(row, 7), 200, 7)
    assert line.states == 1024
    assert line.share is not None
    assert line.search_seconds is not None
    assert line.search_seconds > 0
    assert line.details["evaluations"] > 0
    assert line.share <= (line.feasible or 0)


# -- what cannot run, and what is cut short ------------------------------------------------


def test_an_absent_sdk_is_an_empty_cell_with_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = registry.available
    monkeypatch.setattr(registry, "available", lambda name: name[-3:] != "vqe" and known(name))
    report = reproduce(["table2"], tmp_path, Settings(reads=20, rows="2"))
    for sdk in ("qiskit", "pennylane", "braket"):
        (line,) = [x for x in report["lines"] if x["method"] == f"{sdk}-vqe"]
        assert line["status"] == "skipped"
        assert f"pip install 'qrobot[{sdk}]'" in line["reason"]
        assert line["seconds"] is line["share"] is line["best"] is None
        assert f"- `{sdk}-vqe` at n = 2: {line['reason']}." in (tmp_path / "table2.md").read_text()
    assert {x["method"] for x in done(report)} == {"neal", "tabu", "descent", "penalty"}


def test_a_figure_that_cannot_be_drawn_is_noted_beside_tables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def absent(*_: Any) -> None:
        raise MissingExtraError("drawing pictures", "plot")

    monkeypatch.setattr("qrobot.study.reproduce.runner.draw_figure", absent)
    settings = Settings(reads=20, rows="2", quick=True)
    report = reproduce(["table1", "figure4"], tmp_path, settings)
    (note,) = [note for note in report["notes"] if note.startswith("figure4 is left out")]
    assert note in json.loads((tmp_path / "reproduce.json").read_text())["notes"]
    with pytest.raises(MissingExtraError):
        reproduce(["figure4"], tmp_path, settings)


def test_a_failing_backend_is_a_line_without_its_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise RuntimeError("planted-secret")

    monkeypatch.setattr(NealSampler, "sample", fail)
    report = reproduce(["table2"], tmp_path, Settings(reads=20, rows="2", quick=True))
    assert report["lines"][0]["status"] == "failed"
    assert report["lines"][0]["reason"] == "neal failed (RuntimeError)"
    assert len(done(report)) == 3
    for file in tmp_path.iterdir():
        assert b"planted-secret" not in file.read_bytes()


def test_a_state_that_does_not_fit_is_refused_with_its_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The real limit may be higher: what matters is that 26 qubits are tried only when asked.
    plain, large = (dict(methods_for(row_of(1, 3), large=asked)) for asked in (False, True))
    assert "--large" in (plain[METHODS["penalty"]] or "")
    assert large[METHODS["penalty"]] is None
    assert METHODS["penalty"] not in dict(methods_for(row_of(1, 4), large=True))
    row = row_of(2, 3)
    question = Question.of(row, 7)
    monkeypatch.setattr(resources, "available_memory", lambda: 100_000)
    with pytest.raises(Exception, match=r"16 qubits needs 1,572,864 bytes .* available"):
        METHODS["penalty"].run(blank(row, "penalty"), question, 10, 0)


def test_an_interrupted_run_keeps_its_lines_and_can_be_resumed(tmp_path: Path) -> None:
    seen: list[Outcome] = []

    def interrupt(line: Outcome) -> None:
        seen.append(line)
        if len(seen) == 2:
            raise KeyboardInterrupt

    settings = Settings(reads=20, rows="2", quick=True)
    report = reproduce(["table2", "figure4"], tmp_path, settings, on_line=interrupt)
    assert report["interrupted"]
    saved = json.loads((tmp_path / "reproduce.json").read_text())
    assert saved["interrupted"]
    assert [line["method"] for line in saved["lines"]] == ["neal", "tabu"]
    assert len((tmp_path / "table2.csv").read_text().splitlines()) == 3
    assert "interrupted" in (tmp_path / "table2.md").read_text()
    assert not list(tmp_path.glob(".qrobot*"))

    more = reproduce(["table2"], tmp_path, settings, resume=True)
    assert not more["interrupted"]
    assert more["lines"][:2] == saved["lines"]  # the very times: they did not run again
    assert len(done(more)) == 4
    with pytest.raises(InputError, match="another seed"):
        reproduce(["table2"], tmp_path, replace(settings, seed=8), resume=True)
    (tmp_path / "reproduce.json").write_text("{}")
    with pytest.raises(InputError, match="not a report of ours"):
        reproduce(["table2"], tmp_path, settings, resume=True)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (Settings(rows="1-3"), "beyond the tables"),
        (Settings(rows="2-13"), "beyond the tables"),
        (Settings(rows="two"), "names no rows"),
        (Settings(rows="3-2"), "no row is left"),
        (Settings(largest=1), "no row is left"),
        (Settings(rows="5-6", quick=True), "no row is left"),
        (Settings(reads=0), "too small"),
        (Settings(seed=-1), "too small"),
    ],
)
def test_settings_out_of_range_are_refused(
    settings: Settings, message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        reproduce(["table1"], tmp_path, settings)
    assert not list(tmp_path.iterdir())


def test_rows_and_largest_choose() -> None:
    assert Settings(rows="2,4, 10-12").items() == [2, 4, 10, 11, 12]
    assert Settings(largest=4).items() == [2, 3, 4]
    assert Settings(quick=True).items() == [2, 3, 4]
