"""The examples are what their script makes, and what they say they are."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

import qrobot
from qrobot._formats import is_beside
from qrobot.problem.formats.vrp import read_solution

EXAMPLES = Path(__file__).parents[2] / "examples"
INSTANCES = sorted(
    p for p in EXAMPLES.iterdir() if p.suffix in (".json", ".csv", ".vrp") and not is_beside(p.name)
)


def test_the_script_makes_the_committed_files(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, EXAMPLES / "make_examples.py", tmp_path],
        check=True,
        cwd=EXAMPLES.parent,
        env={"PYTHONPATH": str(EXAMPLES.parent)},
    )
    made = sorted(p.name for p in tmp_path.iterdir())
    assert made == sorted(
        p.name for p in EXAMPLES.iterdir() if p.suffix in (".json", ".csv", ".vrp", ".sol")
    )
    for name in made:
        assert (tmp_path / name).read_bytes() == (EXAMPLES / name).read_bytes(), name


def test_the_script_of_the_maps_makes_the_committed_files(tmp_path: Path) -> None:
    folder = EXAMPLES / "maps"
    subprocess.run(
        [sys.executable, folder / "make_maps.py", tmp_path],
        check=True,
        cwd=EXAMPLES.parent,
        env={"PYTHONPATH": str(EXAMPLES.parent)},
    )
    made = sorted(p.name for p in tmp_path.iterdir())
    assert made == sorted(p.name for p in folder.iterdir() if p.suffix != ".py")
    for name in made:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
        assert f"`{name}`" in (EXAMPLES / "README.md").read_text(), name


@pytest.mark.parametrize("path", INSTANCES, ids=lambda p: p.name)
def test_every_example_is_read_and_owns_up(path: Path) -> None:
    one = qrobot.read(path)
    assert one.size
    assert "ours" in one.comment or "our own" in one.comment
    assert "seed" in one.comment
    assert one.notes == ()
    assert one.weights.sum() <= one.vehicle_capacities.sum()
    assert one.order_weights.max() <= one.capacities.max()


def test_every_example_is_listed() -> None:
    listed = (EXAMPLES / "README.md").read_text()
    for path in EXAMPLES.iterdir():
        if path.is_file() and path.name != "README.md":
            assert f"`{path.name}`" in listed, path.name


def test_the_small_warehouse_is_realistic() -> None:
    one = qrobot.read(EXAMPLES / "small-warehouse.json")
    warehouse = one.warehouse
    assert isinstance(warehouse, qrobot.problem.AisleWarehouse)
    assert (warehouse.aisles, warehouse.blocks, warehouse.slots) == (10, 2, 12)
    assert len(one.orders) == 24
    assert {len(o.items) for o in one.orders} == {1, 2, 3, 4}
    assert one.whole_orders
    assert any(i.weight.denominator > 1 for i in one.items)
    assert len(one.robots) == 3
    full = sum(i.weight for i in one.items) / sum(r.capacity for r in one.robots)
    assert Fraction("0.84") < full < Fraction("0.86")


def test_the_papers_weights() -> None:
    four = qrobot.read(EXAMPLES / "paper-4-items.json")
    seven = qrobot.read(EXAMPLES / "paper-7-items.json")
    assert [int(i.weight) for i in four.items] == [8, 8, 3, 3]
    assert [int(i.weight) for i in seven.items] == [8, 8, 3, 3, 1, 2, 4]
    for one in (four, seven):
        assert one.weights.sum() > one.capacities.max()  # two robots are needed
        captions = qrobot.read(EXAMPLES / f"{one.name}-m45.json")
        assert captions.items == one.items
        assert {int(r.capacity) for r in captions.robots} == {45}


def test_the_tiny_solution_is_right() -> None:
    one = qrobot.read(EXAMPLES / "tiny.vrp")
    routes, cost = read_solution(EXAMPLES / "tiny.sol")
    assert one.length(routes) == cost == one.reference
    assert len(one.robots) == 2


def test_the_csv_example_has_one_article_in_several_orders() -> None:
    one = qrobot.read(EXAMPLES / "orders.csv")
    assert any("/" in item.id for item in one.items)
    assert [r.id for r in one.robots] == ["cart", "lift"]
