"""What the checker says, what it judges exactly, and what it may not import."""

from __future__ import annotations

import ast
from fractions import Fraction
from pathlib import Path

import pytest
from plans import restated

import qrobot.plan.checker
import qrobot.plan.ruler
from qrobot.plan import Plan, Trip, check
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot


def test_fractions_that_floats_would_misjudge() -> None:
    # 0.1 + 0.2 > 0.3 in floats; the exact load is just allowed.
    items = tuple(Item(f"i{k}", Fraction(k, 10), Point(k, 0)) for k in (1, 2))
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    instance = Instance(OpenFloor(), items, orders, (Robot("R1", Fraction(3, 10)),))
    assert check(Plan.from_routes(instance, [[1, 2]]), instance).ok


def test_problems_are_sentences_with_the_numbers() -> None:
    items = tuple(Item(f"i{k}", Fraction(1), Point(k, 0)) for k in range(9))
    orders = tuple(Order(i.id, (i.id,)) for i in items)
    instance = Instance(OpenFloor(), items, orders, (Robot("R1", Fraction(2)),))
    plan = restated(Plan((Trip("R1", (), ("i1", "i2", "i3"), 0, 0, 0),), 0), instance)
    report = check(plan, instance)
    assert {p.kind: str(p) for p in report.problems} == {
        "missing": "nobody collects items i0, i4, i5, i6, i7 and 1 more",
        "overload": "trip 1 carries 3, robot R1 holds 2",
    }
    assert str(report).startswith("missing: ")
    data = report.to_dict()
    assert data["ok"] is False
    assert data["distance"] == 6
    assert [p["kind"] for p in data["problems"]] == ["missing", "overload"]


def test_a_plan_of_nothing_is_right() -> None:
    instance = Instance(OpenFloor(), (), (), (Robot("R1", Fraction(1)),))
    report = check(Plan((), 0.0), instance)
    assert report.ok
    assert str(report) == "right: 0 trips, 0 stops, distance 0"


@pytest.mark.parametrize(
    "module",
    [getattr(qrobot.plan, one) for one in ("checker", "clock", "map_ruler", "ruler", "rules")],
    ids=lambda module: module.__name__,
)
def test_the_checker_imports_no_solver_and_no_numbers(module: object) -> None:
    tree = ast.parse(Path(module.__file__).read_text())
    imported, names = set(), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add(node.module)
            names |= {alias.name for alias in node.names}
    ours = {name for name in imported if name.startswith("qrobot")}
    assert ours <= {
        "qrobot.plan.clock",
        "qrobot.plan.map_ruler",
        "qrobot.plan.objective",
        "qrobot.plan.picks",
        "qrobot.plan.plan",
        "qrobot.plan.ruler",
        "qrobot.plan.rules",
        "qrobot.problem.entities",
        "qrobot.problem.instance",
        *(f"qrobot.problem.{file}" for file in ("aisles", "checks", "floor", "table", "warehouse")),
        *(f"qrobot.problem.{file}" for file in ("floor_map", "lane_network")),
    }
    assert not names & {"AisleGraph", "unusual", "coarse", "clear_line", "Network"}
    # Half a million cells are measured in arrays of its own.
    assert "numpy" not in imported or module is qrobot.plan.map_ruler
    assert not {name for name in imported if name.startswith("scipy")}
    used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    derived = {"distances", "distance_matrix", "graph", "weights", "capacities", "unit", "way"}
    derived |= {"free", "clear", "walkable", "cell_of", "planning_cell", "vertex"}
    assert not used & derived
