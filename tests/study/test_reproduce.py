"""A quick reproduction: rows, files, pictures; optima and controls counted another way."""

from __future__ import annotations

import csv
import json
import math
import struct
import xml.etree.ElementTree as ET
from dataclasses import fields
from itertools import pairwise, permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles import least_distance
from reproductions import done, every_read, row_of, shortest

from qrobot.errors import InputError
from qrobot.models import build_model
from qrobot.study.reproduce import TARGETS, Settings, reproduce
from qrobot.study.reproduce.figures import FIGURES
from qrobot.study.reproduce.methods import methods_for
from qrobot.study.reproduce.paper import (
    FIGURE_WEIGHTS,
    figure_instance,
    penalty_model,
    table_instance,
)
from qrobot.study.reproduce.question import Outcome
from qrobot.study.reproduce.tables import fill_page


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    pytest.importorskip("matplotlib")
    folder = tmp_path_factory.mktemp("reproduce") / "new" / "folder"
    settings = Settings(reads=150, quick=True, rows="2-3")
    return folder, reproduce([*TARGETS], folder, settings)


@pytest.mark.slow
def test_rows_are_complete(quick: tuple[Path, dict[str, Any]]) -> None:
    _, report = quick
    for table in (1, 2, 3):
        for row in (row_of(table, 2), row_of(table, 3)):
            own = [x for x in report["lines"] if (x["table"], x["items"]) == (table, row.items)]
            assert [x["method"] for x in own] == [m.name for m, _ in methods_for(row, quick=True)]
            for line in own:
                assert line["qubits"] == row.qubits
                assert line["capacity"] == row.capacity
                assert line["paper_annealer_seconds"] == row.annealer
                assert line["paper_pennylane_seconds"] == row.seconds.get("pennylane")
                assert (line["status"] == "done") == (line["reason"] is None)
    for line in done(report):
        assert line["proven"]
        assert line["reads"] == 150
        assert 0 <= line["share"] <= line["feasible"] <= 1
        parts = [line[f"{part}_seconds"] for part in ("build", "search", "run")]
        assert line["seconds"] == pytest.approx(sum(parts))
        assert min(parts) >= 0 < line["run_seconds"]
        assert line["gap"] is None or line["gap"] >= -1e-9
        assert (line["share"] > 0) == (line["gap"] is not None and line["gap"] < 1e-9)
        assert line["plans_best"] >= line["optimum"] - 1e-9
    assert {(x["items"], x["method"]) for x in done(report) if x["table"] == 1} == {
        *((n, name) for n in (2, 3) for name in ("neal", "tabu", "descent")),
        (2, "penalty"),
        (3, "swap"),
    }


def test_tables_2_and_3_are_the_same_runs(quick: tuple[Path, dict[str, Any]]) -> None:
    _, report = quick
    two, three = ([x for x in report["lines"] if x["table"] == table] for table in (2, 3))
    changed = {"table", "paper_annealer_seconds"}
    for a, b in zip(two, three, strict=True):
        assert {k: v for k, v in a.items() if k not in changed} == {
            k: v for k, v in b.items() if k not in changed
        }


def test_the_optimum_is_brute_forces(quick: tuple[Path, dict[str, Any]]) -> None:
    for line in done(quick[1]):
        instance = table_instance(row_of(line["table"], line["items"]))
        assert line["optimum"] == pytest.approx(shortest(instance), rel=1e-12)


def test_csv_and_json_say_the_same(quick: tuple[Path, dict[str, Any]]) -> None:
    folder, report = quick
    saved = json.loads((folder / "reproduce.json").read_text())
    assert saved == json.loads(json.dumps(report))
    assert {"processor", "cores", "python"} <= set(saved["machine"])
    for table in (1, 2, 3):
        with (folder / f"table{table}.csv").open() as file:
            back = list(csv.DictReader(file))
        own = [line for line in report["lines"] if line["table"] == table]
        assert len(back) == len(own)
        for cells, line in zip(back, own, strict=True):
            assert set(cells) == {f.name for f in fields(Outcome)} - {"details"}
            for name, text in cells.items():
                value = line[name]
                assert text == ("" if value is None else str(value))


def test_markdown_says_whose_figures_and_places_these_are(
    quick: tuple[Path, dict[str, Any]],
) -> None:
    folder, _ = quick
    for name in ("table1.md", "table2.md", "table3.md", "figure4.md", "figure7.md"):
        text = (folder / name).read_text()
        assert "drawn with seed 7" in text
        assert "2021" in text
        tables = [line for line in text.splitlines() if line.startswith("|")]
        for head, mark in pairwise(tables):
            if set(mark) <= set("|-: "):
                assert head.count("|") == mark.count("|")
    text = (folder / "table2.md").read_text()
    assert "no repair, no polish" in text
    assert "left out by --quick" in text
    assert "| 2 | 15 | 10 | 11.2 |" in text
    assert "sampling alone" in (folder / "table3.md").read_text()


# -- controls, counted by enumeration ------------------------------------------------------


@pytest.mark.parametrize("table", [1, 2])
def test_the_random_control_is_the_share_of_all_bit_strings(
    table: int, quick: tuple[Path, dict[str, Any]]
) -> None:
    row = row_of(table, 2)
    _, distances = every_read(build_model(table_instance(row), row.encoding, slack="paper"))
    least = shortest(table_instance(row))
    line = next(x for x in done(quick[1]) if (x["table"], x["items"]) == (table, 2))
    assert line["control"] == "bit strings"
    assert line["control_feasible"] == np.isfinite(distances).mean()
    assert line["control_probability"] == (distances <= least * (1 + 1e-9)).mean()
    seen = 1 - (1 - line["control_probability"]) ** 150
    assert line["control_seen"] == pytest.approx(seen)


def test_the_control_of_plans_is_the_share_of_all_plans(
    quick: tuple[Path, dict[str, Any]],
) -> None:
    line = next(x for x in done(quick[1]) if x["method"] == "swap")
    instance = table_instance(row_of(1, 3))
    d, least = instance.distances, shortest(instance)
    lengths = [d[0, a] + d[a, b] + d[b, c] + d[c, 0] for a, b, c in permutations((1, 2, 3))]
    share = np.mean(np.array(lengths) <= least * (1 + 1e-9))
    assert line["control"] == "plans"
    assert line["control_probability"] == line["plans_probability"] == share
    assert line["control_best"] >= least - 1e-9


def test_the_penalty_rows_probability_is_that_of_the_state(
    quick: tuple[Path, dict[str, Any]],
) -> None:
    """The state once more, by plain matrices over all bit strings."""
    line = next(x for x in done(quick[1]) if x["method"] == "penalty" and x["table"] == 2)
    instance = table_instance(row_of(2, 2))
    model = penalty_model(instance)
    bits, distances = every_read(model)
    energies = model.bqm.energies((bits, model.variables))
    assert energies.min() == pytest.approx(shortest(instance))  # the lowest energy is a plan
    (gamma,), (beta,) = line["details"]["gammas"], line["details"]["betas"]
    state = np.exp(-1j * gamma / energies.std() * energies) / math.sqrt(len(energies))
    turn = np.array(
        [[math.cos(beta), -1j * math.sin(beta)], [-1j * math.sin(beta), math.cos(beta)]]
    )
    state = state.reshape((2,) * 10)
    for axis in range(10):
        state = np.moveaxis(np.tensordot(turn, state, (1, axis)), 0, axis)
    optimal = distances <= shortest(instance) * (1 + 1e-9)
    p = float((np.abs(state.reshape(-1)) ** 2)[optimal].sum())
    assert line["probability"] == pytest.approx(p, rel=1e-6)
    assert abs(line["share"] - p) < 5 * math.sqrt(p * (1 - p) / 150)


# -- pictures ------------------------------------------------------------------------------


def test_pictures_are_whole_and_show_both_sides(quick: tuple[Path, dict[str, Any]]) -> None:
    folder, report = quick
    for path in folder.glob("*.svg"):
        ET.parse(path)
    for path in folder.glob("*.png"):
        data = path.read_bytes()
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        assert data[-8:-4] == b"IEND"
        assert min(struct.unpack(">II", data[16:24])) > 500
    for table in (1, 2, 3):
        text = (folder / f"table{table}.svg").read_text()
        for gid in ("paper-paper_annealer_seconds", "ours-neal", "ours-penalty"):
            assert f'id="{gid}"' in text
        assert "no speed-up" in text
    assert [figure["figure"] for figure in report["figures"]] == ["figure4", "figure7"]
    for figure in report["figures"]:
        for file in figure["files"]:
            assert (folder / file).is_file()


def test_figures_show_proven_plans_with_as_many_robots_as_are_needed(
    quick: tuple[Path, dict[str, Any]],
) -> None:
    folder, report = quick
    for figure in report["figures"]:
        items, robots, capacities = FIGURES[figure["figure"]]
        total = sum(FIGURE_WEIGHTS[:items])
        assert f"the items weigh {total} together" in figure["note"]
        assert "one robot is always optimal" in (folder / f"{figure['figure']}.md").read_text()
        assert [panel["capacity"] for panel in figure["panels"]] == list(capacities)
        assert [panel["robots_used"] for panel in figure["panels"]] == [1, 2, 3]
        for panel in figure["panels"]:
            instance = figure_instance(items, robots, panel["capacity"])
            found = least_distance(instance)
            assert found is not None
            assert panel["proven"]
            assert panel["distance"] == pytest.approx(found[0])
            assert panel["robots_used"] == found[1]
            assert all(trip["load"] <= panel["capacity"] for trip in panel["trips"])
            stops = sorted(int(stop) for trip in panel["trips"] for stop in trip["stops"])
            assert stops == list(range(1, items + 1))
            text = (folder / panel["files"][0]).read_text()
            colours = ("#d62839", "#1d63c9", "#f2b705")  # red, blue, yellow: the paper's
            assert [colour in text for colour in colours] == [
                k < panel["robots_used"] for k in range(3)
            ]
            if panel["robots_used"] > 1:
                fewer = figure_instance(items, panel["robots_used"] - 1, panel["capacity"])
                assert least_distance(fewer) is None
                assert "cannot" in panel["fewer_robots"]


def test_a_page_is_filled_between_its_markers(
    quick: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    folder, _ = quick
    page = tmp_path / "page.md"
    page.write_text(
        "before\n<!-- reproduce:table2 -->\nold\n<!-- end of table2 -->\nbetween\n"
        "<!-- reproduce:figure4 -->\n<!-- end of figure4 -->\nafter\n"
    )
    assert fill_page(page, folder) == ["figure4", "table2"]
    once = page.read_text()
    assert "old" not in once
    assert "| 2 | 15 | 10 | 11.2 |" in once
    assert "![" not in once
    assert [word in once for word in ("before\n", "\nbetween\n", "\nafter\n")] == [True] * 3
    fill_page(page, folder)
    assert page.read_text() == once
    page.write_text("nothing\n")
    with pytest.raises(InputError, match="no place"):
        fill_page(page, folder)
