"""Files and their options on the command line: the same question in every command."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from qrobot.cli.main import cli
from qrobot.errors import InputError

VRP = """\
NAME : own-n4-k1
TYPE : CVRP
DIMENSION : 4
EDGE_WEIGHT_TYPE : EUC_2D
CAPACITY : 20
NODE_COORD_SECTION
1 0 0
2 0.3 0.4
3 0 0.9
4 0.1 0.1
DEMAND_SECTION
1 0
2 4
3 5
4 2
DEPOT_SECTION
1
-1
"""
LAYOUT = {
    "schema": "qrobot.instance/1",
    "warehouse": {"kind": "floor"},
    "robots": {"count": 1, "capacity": 9},
}


def run(*words: str | Path) -> Any:
    done = CliRunner().invoke(cli, [*map(str, words)])
    if isinstance(done.exception, InputError):
        return done.exception
    assert done.exit_code in (0, 1), done.output
    return done


def test_rounding_is_the_same_question_in_every_command(tmp_path: Path) -> None:
    question, plan = tmp_path / "x.vrp", tmp_path / "plan.json"
    question.write_text(VRP)
    done = run("solve", question, "--rounding", "none", "--json", "-o", plan)
    found = json.loads(done.stdout)
    assert not found["distance"].is_integer()
    assert found["result"]["notes"] == []
    assert run("check", plan, question, "--rounding", "none").exit_code == 0
    assert run("check", plan, question).exit_code == 1
    rounded = json.loads(run("solve", question, "--json").stdout)
    assert rounded["distance"].is_integer()
    assert "rounded to whole numbers" in rounded["result"]["notes"][0]
    texts = []
    for rounding in ("none", "nearest"):
        model = tmp_path / f"{rounding}.bqm.json"
        run("export", question, model, "--rounding", rounding)
        texts.append(model.read_text())
    assert texts[0] != texts[1]
    said = run("solve", question, "--rounding", "half")
    assert "rounding: 'half' is not a rounding; use one of none, nearest, up, down" in str(said)


def test_columns_that_are_not_ours(tmp_path: Path) -> None:
    (tmp_path / "layout.json").write_text(json.dumps(LAYOUT))
    orders, plan = tmp_path / "x.csv", tmp_path / "plan.json"
    orders.write_text("order,item,weight,x,y,note,customer\nA,p,1,3,4,fragile,Ann\n")
    assert "give --ignore-columns note" in str(run("solve", orders))
    run("solve", orders, "--ignore-columns", "note, customer", "-q", "-o", plan)
    done = run("check", plan, orders, "--ignore-columns", "note", "--ignore-columns", "customer")
    assert done.exit_code == 0


@pytest.mark.parametrize("value", ["1,000", "1_000", "１２", "nan", "2.5"])
def test_numbers_on_the_command_line_are_plain(tmp_path: Path, value: str) -> None:
    (tmp_path / "x.vrp").write_text(VRP)
    assert "is not a number of robots" in str(run("solve", tmp_path / "x.vrp", "--robots", value))
    if value != "2.5":
        said = str(run("solve", tmp_path / "x.vrp", "--capacity", value))
        assert f"capacity: {value} is not a finite number; " in said


def test_a_forbidden_way_in_every_output(tmp_path: Path) -> None:
    table = [[None, 1, None], [None, None, 1], [1, None, None]]
    question, plan = tmp_path / "x.json", tmp_path / "plan.json"
    question.write_text(
        json.dumps(
            LAYOUT
            | {
                "warehouse": {"kind": "matrix", "matrix": table},
                "items": [
                    {"id": "a", "weight": 1, "at": {"node": 1}},
                    {"id": "b", "weight": 1, "at": {"node": 2}},
                ],
            }
        )
    )
    picture = tmp_path / "plan.svg"
    done = run("solve", question, "--json", "-o", plan, "-p", picture)
    assert json.loads(done.stdout, parse_constant=pytest.fail)["distance"] == 3
    assert picture.stat().st_size > 1000
    data = json.loads(plan.read_text(), parse_constant=pytest.fail)
    data["trips"][0]["stops"].reverse()
    plan.write_text(json.dumps(data))
    done = run("check", plan, question, "--json")
    report = json.loads(done.stdout, parse_constant=pytest.fail)
    assert (done.exit_code, report["distance"]) == (1, None)
    assert report["problems"][0]["kind"] == "unreachable"
    docplex = importlib.util.find_spec("docplex") is not None
    for name in ("x.coo", "x.bqm.json", *(["x.lp"] if docplex else [])):
        run("export", question, tmp_path / name)
        assert not re.search(r"\b(inf|infinity|nan)\b", (tmp_path / name).read_text().lower())
