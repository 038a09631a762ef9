"""The benchmark: a row for every run, whatever happens in it."""

from __future__ import annotations

import csv
import dataclasses
import json
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from processes import HANG

import qrobot
from qrobot.errors import InputError
from qrobot.study import bench
from qrobot.study.bench import BenchRow, Task, find_instances, run_bench, tasks
from qrobot.study.bench_report import bench_csv, bench_markdown, bench_plot, summaries
from qrobot.study.bench_worker import run

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TINY = EXAMPLES / "paper-4-items.json"


def row(**values: Any) -> dict[str, Any]:
    base = {
        "instance": "A-n5-k2", "backend": "auto", "seed": 0, "cost": 10.0, "bound": 9.0,
        "reference": 10.0, "gap": 0.0, "proven": False, "feasible": True, "seconds": 1.0,
        "wall_seconds": 2.0, "peak_mb": 100.0, "trips": 2, "robots": 2, "sampler": None,
        "error": None, "reference_status": None,
    }  # fmt: skip
    return base | values


def report_of(*rows: dict[str, Any]) -> dict[str, Any]:
    machine = {
        "processor": "a chip", "cores": 2, "memory_gb": 8.0, "python": "3.11", "qrobot": "0",
        "packages": {"numpy": "2"},
    }  # fmt: skip
    return {"machine": machine, "started": "2026-01-01T00:00:00Z", "rows": list(rows)}


def test_instances_are_found_and_answers_are_not(tmp_path: Path) -> None:
    for name in ("b.vrp", "a.json", "c.csv", "a.sol", "index.json", "layout.json", "x.txt"):
        (tmp_path / name).write_text("{}")
    (tmp_path / "out.json").write_text('{\n "schema": "qrobot.bench/1"}')
    (tmp_path / "plan.json").write_text('{\n "schema": "qrobot.plan/1"}')
    assert [p.name for p in find_instances(tmp_path)] == ["a.json", "b.vrp", "c.csv"]
    assert [p.name for p in find_instances(tmp_path, "?.vrp")] == ["b.vrp"]
    with pytest.raises(InputError, match="holds no"):
        find_instances(tmp_path, "z")


def test_tasks_are_instances_by_backends_by_seeds(tmp_path: Path) -> None:
    index = [
        {"file": "sub/X-n9-k3.vrp", "value": 12, "source": "a paper"},
        {"file": "A-n5-k2.vrp", "value": None},
    ]
    (tmp_path / "index.json").write_text(json.dumps(index))
    paths = [tmp_path / "A-n5-k2.vrp", tmp_path / "X-n9-k3.vrp"]
    found = tasks(paths, ["auto", "exact"], 2, deadline=1.0, robots_for=["X-*=free", "A-n5*=7"])
    assert [(Path(t.path).stem, t.backend, t.seed) for t in found[:4]] == [
        ("A-n5-k2", "auto", 0), ("A-n5-k2", "auto", 1), ("A-n5-k2", "exact", 0),
        ("A-n5-k2", "exact", 1),
    ]  # fmt: skip
    assert {(Path(t.path).stem, t.robots, t.reference) for t in found} == {
        ("A-n5-k2", 7, None),
        ("X-n9-k3", "free", 12.0),
    }


HI = """\
NUM_AISLES : 2
NUM_CELLS : 4
DEPOT_AISLE : 0
DEPOT_LOCATION : top
DISTANCE_AISLE_TO_AISLE : 3
DISTANCE_CELL_TO_CELL : 1
DISTANCE_TOP_TO_CELL : 3
DISTANCE_BOTTOM_TO_CELL : 4
DISTANCE_TOP_OR_BOTTOM_TO_DEPOT : 0
PICKER_CAPACITY : 9
ARTICLE_SECTION
NUM_ARTICLES : 2
ID 0 WEIGHT 1
ID 1 WEIGHT 1
SKU_SECTION
NUM_SKUS : 2
ID 0 AISLE 0 CELL 3 QUANTITY 1 LEFT_RIGHT_HAND_SIDE left
ID 1 AISLE 1 CELL 1 QUANTITY 1 LEFT_RIGHT_HAND_SIDE left
ORDER_SECTION
NUM_ORDERS : 1
NUM_ARTICLES_IN_ORDER : 2
ID 0 QUANTITY 1
ID 1 QUANTITY 1
EOF
"""
VALUES = {
    "value": 26.0, "status": "optimal", "two_blocks": 20.0,
    "end_gap_1_5": {"value": 18.0, "proven": False},
}  # fmt: skip


def batches(folder: Path) -> Path:
    """Return a folder with folders in it, whose files share a name, and one index for all."""
    for name in ("a", "b", ".hidden"):
        (folder / name).mkdir()
        (folder / name / "x.txt").write_text(HI)
    (folder / "README.txt").write_text("two sets of files\n")
    index = [{"file": "a/x.txt", **VALUES}, {"file": "b/x.txt", "value": 1}]
    (folder / "index.json").write_text(json.dumps(index))
    return folder


def test_folders_are_descended_and_the_index_is_keyed_by_path(tmp_path: Path) -> None:
    root = batches(tmp_path)
    paths = find_instances(root)
    assert [p.relative_to(root).as_posix() for p in paths] == ["a/x.txt", "b/x.txt"]
    assert find_instances(root, "b/*") == find_instances(root, "b/") == paths[1:]
    found = tasks(paths, ["auto"], 1, deadline=1.0, root=root)
    assert [(t.name, t.reference, t.reference_status) for t in found] == [
        ("a/x", 26.0, "optimal"), ("b/x", 1.0, None),
    ]  # fmt: skip
    # A folder alone has the index above it, unless that is something else.
    (one,) = tasks(paths[:1], ["auto"], 1, deadline=1.0, root=root / "a")
    assert (one.name, one.reference) == ("x", 26.0)


def test_an_index_above_the_folder_may_be_something_else(tmp_path: Path) -> None:
    root = batches(tmp_path)
    (root / "index.json").write_text('{"pages": 3}')
    (one,) = tasks([root / "a" / "x.txt"], ["auto"], 1, deadline=1.0, root=root / "a")
    assert one.reference is None


@pytest.mark.parametrize(
    ("variant", "cost", "status"),
    [
        (None, 26.0, "optimal"),  # round both aisles: 2 (10 + 3)
        ("two_blocks", 20.0, "optimal"),  # round the back block, twice 2 to the last cell
        ("end_gap_1_5", 18.0, "best known"),  # round both aisles: 2 (6 + 3)
    ],
)
def test_variants_are_compared_with_their_own_values(
    tmp_path: Path, variant: str | None, cost: float, status: str
) -> None:
    root = batches(tmp_path)
    todo = tasks(find_instances(root, "a"), ["exact"], 1, deadline=5.0, root=root, variant=variant)
    (row,) = run_bench(todo)["rows"]
    assert row["instance"] == ("a/x" if variant is None else f"a/x {variant}")
    assert row["cost"] == pytest.approx(cost)
    assert row["gap"] == pytest.approx(0)
    assert row["reference_status"] == status
    assert (
        tasks(find_instances(root, "b"), ["exact"], 1, deadline=5.0, root=root, variant="x") == []
    )


def test_another_objective_is_compared_without_references(tmp_path: Path) -> None:
    instance = qrobot.read(TINY)
    robots = tuple(dataclasses.replace(robot, speed=2.0) for robot in instance.robots)
    path = tmp_path / "fast.json"
    best = qrobot.solve(instance).cost
    qrobot.write(dataclasses.replace(instance, robots=robots, reference=best), path)
    (tmp_path / "index.json").write_text(f'[{{"file": "fast.json", "value": {best}}}]')
    for objective, cost, gap in (("distance", best, 0.0), ("time", best / 2, None)):
        report = run_bench(tasks([path], ["auto"], 1, deadline=5.0, objective=objective))
        (row,) = report["rows"]
        assert report["objective"] == objective
        assert row["cost"] == pytest.approx(cost)
        assert row["bound"] == pytest.approx(cost)
        assert row["gap"] == (None if gap is None else pytest.approx(gap, abs=1e-9))
        assert row["proven"]
    assert "by the objective time" in bench_markdown(report, "here")


@pytest.mark.parametrize("text", ["{", "[1]", '[{"value": 3}]', '[{"file": "a", "value": "x"}]'])
def test_a_broken_index_is_named(text: str, tmp_path: Path) -> None:
    (tmp_path / "index.json").write_text(text)
    with pytest.raises(InputError, match=r"index\.json"):
        tasks([tmp_path / "a.vrp"], ["auto"], 1, deadline=1.0)


@pytest.mark.parametrize("value", ["0", "-5", "1e300", "1e-300"])
def test_an_index_value_that_no_gap_can_be_told_against_is_passed_over(
    value: str, tmp_path: Path
) -> None:
    (tmp_path / "index.json").write_text(f'[{{"file": "a.vrp", "value": {value}}}]')
    (task,) = tasks([tmp_path / "a.vrp"], ["auto"], 1, deadline=1.0)
    assert task.reference is None


@pytest.mark.parametrize("value", ["NaN", "Infinity", '1, "value": 2'])
def test_an_index_that_is_not_json_is_named(value: str, tmp_path: Path) -> None:
    (tmp_path / "index.json").write_text(f'[{{"file": "a.vrp", "value": {value}}}]')
    with pytest.raises(InputError, match=r"index\.json: line 1, column \d+: "):
        tasks([tmp_path / "a.vrp"], ["auto"], 1, deadline=1.0)


VRP = """\
NAME : own-n4-k2
TYPE : CVRP
DIMENSION : 4
EDGE_WEIGHT_TYPE : EUC_2D
CAPACITY : 10
NODE_COORD_SECTION
1 0 0
2 3.3 4
3 0 5
4 1 1
DEMAND_SECTION
1 0
2 4
3 5
4 2
DEPOT_SECTION
1
-1
"""


@pytest.mark.slow
def test_no_reference_breaks_the_report(tmp_path: Path) -> None:
    costs = {"a": "nan", "b": "inf", "c": "-5", "d": "0", "e": "12.5", "f": "1e-320"}
    for name, cost in costs.items():
        (tmp_path / f"{name}.vrp").write_text(VRP)
        (tmp_path / f"{name}.sol").write_text(f"Route #1: 1 2 3\nCost {cost}\n")
    saved = tmp_path / "out" / "report.json"
    saved.parent.mkdir()
    for rounding in (None, "none"):
        todo = tasks(
            find_instances(tmp_path), ["exact"], 1, deadline=None, max_work=100, rounding=rounding
        )
        report = run_bench(todo, save=saved)
        rows = json.loads(saved.read_text(), parse_constant=pytest.fail)["rows"]
        assert [row["error"] for row in rows] == [None] * 6
        assert [row["reference"] for row in rows] == [None, None, None, None, 12.5, None]
        assert len({row["cost"] for row in rows}) == 1
        assert rows[0]["cost"].is_integer() == (rounding is None)
        assert "nan" not in bench_markdown(report, "title").splitlines()[-1]


def test_a_run_has_a_process_of_its_own_and_its_memory(tmp_path: Path) -> None:
    ballast = bytearray(300_000_000)  # ours: it must not show in the worker's peak
    ballast[::4096] = b"x" * len(ballast[::4096])
    saved = tmp_path / "out.json"
    seen: list[tuple[int, BenchRow]] = []
    todo = tasks([EXAMPLES / "tiny.vrp"], ["auto"], 1, deadline=5.0)
    report = run_bench(todo, save=saved, on_row=lambda n, r: seen.append((n, r)))
    (only,) = report["rows"]
    assert only["cost"] == only["reference"] is not None
    assert only["gap"] == 0
    assert only["feasible"]
    assert only["proven"]
    assert 20 < only["peak_mb"] < 300
    assert 0 < only["seconds"] <= only["wall_seconds"]
    assert only["robots"] <= only["trips"]
    assert seen[0][0] == 1
    assert json.loads(saved.read_text()) == json.loads(json.dumps(report))
    assert {"processor", "cores", "python", "qrobot", "packages"} <= set(report["machine"])
    del ballast


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("kill -SEGV $$", "ended with code -11"),
        ("echo oh dear >&2; exit 7", "ended with code 7: oh dear"),
        ("echo '{'", "ended with code 0"),
        ("exec sleep 60", "did not end within"),
    ],
)
def test_whatever_a_worker_does_is_a_row(
    script: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = tmp_path / "worker"
    worker.write_text(f"#!/bin/sh\n{script}\n")
    worker.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(worker))
    monkeypatch.setattr(bench, "GRACE", 0.5 if "sleep" in script else HANG)
    report = run_bench([Task(str(TINY), "auto", 0, 0.1)] * 2)
    assert len(report["rows"]) == 2
    for found in report["rows"]:
        assert says in found["error"]
        assert not found["feasible"]
        assert found["cost"] is found["gap"] is None


def test_infeasible_and_unreadable_are_rows_with_the_reason(tmp_path: Path) -> None:
    infeasible = run(
        {"path": str(TINY), "robots": None, "backend": "auto", "deadline": 1.0, "max_work": None,
         "seed": 0}
    )  # fmt: skip
    assert "error" not in infeasible
    broken = tmp_path / "broken.vrp"
    broken.write_text("nonsense")
    (found,) = run_bench([Task(str(broken), "auto", 0, 1.0)])["rows"]
    assert "broken.vrp" in found["error"]


def test_an_interrupt_keeps_what_is_done(tmp_path: Path) -> None:
    saved = tmp_path / "out.json"

    def interrupt(_n: int, _row: BenchRow) -> None:
        raise KeyboardInterrupt

    report = run_bench([Task(str(TINY), "auto", 0, 1.0)] * 3, save=saved, on_row=interrupt)
    assert report["interrupted"]
    assert len(report["rows"]) == 1
    assert json.loads(saved.read_text())["interrupted"]


def test_summaries_tell_sets_apart() -> None:
    rows = [
        row(seconds=1.0, proven=True),
        row(seed=1, seconds=3.0, cost=11.0, gap=0.1),
        row(instance="X-n9-k3", cost=None, gap=None, feasible=False, seconds=None, error="no"),
        row(backend="pyvrp", cost=9.0, gap=-0.1),
    ]
    first, second, *parts = summaries(rows)
    assert (first["backend"], first["set"], first["runs"], first["feasible"]) == (
        "auto",
        None,
        3,
        2,
    )
    assert (first["matched"], first["referenced"], first["proven"]) == (1, 2, 1)
    assert first["mean_gap"] == pytest.approx(0.05)
    assert (first["median_seconds"], first["worst_seconds"]) == (2.0, 3.0)
    assert second["matched"] == 1  # better than the reference
    assert [(p["set"], p["backend"], p["runs"]) for p in parts] == [
        ("A", "auto", 2), ("A", "pyvrp", 1), ("X", "auto", 1),
    ]  # fmt: skip
    assert len(summaries([row(instance="a"), row(instance="b", backend="exact")])) == 2


def test_markdown_csv_and_plot(tmp_path: Path) -> None:
    report = report_of(row(), row(backend="pyvrp", gap=0.02, cost=10.2), row(cost=None, error="no"))
    text = bench_markdown(report, "a title")
    assert "## a title" in text
    assert "a chip" in text
    tables = [line for line in text.splitlines() if line.startswith("|")]
    assert {line.count("|") for line in tables} == {11, 10}
    assert "| pyvrp | 1 | 1 | 0 | 0 of 1 | 2.00 % |" in text
    assert "| instance |" not in bench_markdown(report, "a title", rows=False)
    bench_csv(report, tmp_path / "out.csv")
    with (tmp_path / "out.csv").open() as file:
        back = list(csv.DictReader(file))
    assert [r["backend"] for r in back] == ["auto", "pyvrp", "auto"]
    assert back[1]["gap"] == "0.02"
    assert back[2]["error"] == "no"
    pytest.importorskip("matplotlib")
    for rows in ([], report["rows"], [row(gap=None, reference=None)]):
        bench_plot(report_of(*rows), tmp_path / "out.svg")
        ET.fromstring((tmp_path / "out.svg").read_text())
