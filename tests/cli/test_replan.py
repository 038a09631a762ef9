"""`qrobot state` and `qrobot replan`, from a plan to its successor."""

from __future__ import annotations

import json
from pathlib import Path

import started

MORNING = started.ROOT / "examples" / "morning.json"


def test_from_a_plan_to_its_successor(tmp_path: Path) -> None:
    plan, state = tmp_path / "plan.json", tmp_path / "state.json"
    new, left = tmp_path / "new.json", tmp_path / "open.json"
    run = started.run
    assert run("solve", MORNING, "--objective", "makespan", "-o", plan, "-q").returncode == 0
    told = run("state", plan, MORNING, "--now", 60, "-o", state)
    assert told.returncode == 0, told.stderr
    assert "on board" in told.stdout
    made = run(
        "replan", state, "--cancel", "G", "--missing", "H1", "--max-work", 10,
        "-o", new, "--open", left,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    assert "R1 brings its trip 1 home at" in made.stdout
    assert "order H goes without H1" in made.stdout
    assert "G" not in {order["id"] for order in json.loads(left.read_text())["orders"]}
    assert run("check", new, left).returncode == 0
    data = json.loads(run("replan", state, "--lost", "R2", "--max-work", 5, "--json").stdout)
    assert data["schema"] == "qrobot.replan/1"
    assert {trip["robot"] for trip in data["plan"]["trips"]} == {"R1"}


def test_new_orders_come_from_a_file_of_the_same_warehouse(tmp_path: Path) -> None:
    plan, state, more = (tmp_path / f"{name}.json" for name in ("plan", "state", "more"))
    run = started.run
    run("solve", MORNING, "--objective", "makespan", "-o", plan, "-q")
    run("state", plan, MORNING, "--now", 60, "-o", state)
    data = json.loads(MORNING.read_text())
    new = {"id": "N1", "weight": 1, "at": {"aisle": 2, "slot": 2}}
    more.write_text(json.dumps(data | {"items": [new], "orders": [{"id": "N", "items": ["N1"]}]}))
    made = run("replan", state, "--add", more, "--max-work", 10)
    assert made.returncode == 0, made.stderr
    assert "new N" in made.stdout
    data["warehouse"]["aisles"] += 1
    more.write_text(json.dumps(data | {"items": [new], "orders": [{"id": "N", "items": ["N1"]}]}))
    refused = run("replan", state, "--add", more)
    assert refused.returncode == 2
    assert "another warehouse" in refused.stderr
    for words, told in (
        (("--close", "x"), "'x' is not an aisle"),
        (("--close", "99"), "99"),
        (("--cancel", "nobody"), "'nobody'"),
        (("--lost", "R9"), "'R9'"),
        (("--stability", "-1"), "stability"),
    ):
        refused = run("replan", state, *words)
        assert refused.returncode == 2, words
        assert told in refused.stderr, words
