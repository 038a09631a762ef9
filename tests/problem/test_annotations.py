"""What the documentation says that constructors take, a type checker takes too."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from qrobot.errors import InputError
from qrobot.problem import Item, Node, Order, Robot

SNIPPET = """\
from decimal import Decimal
from fractions import Fraction
import qrobot
from qrobot.problem import DistanceTable, Instance, Item, Node, Order, Robot

items = (
    Item("a", 2.5, Node(0)),
    Item("b", 2, Node(0)),
    Item("c", "0.25", Node(0)),
    Item("d", Decimal("1.5"), Node(0)),
    Item(id="e", weight=Fraction(1, 3), place=Node(0)),
)
orders = (Order("A", ("a", "b")), Order("B", ["c", "d"]), Order(id="C", items=("e",)))
robots = (
    Robot("R1", 10), Robot("R2", 7.5, 2), Robot("R3", "8.5", speed=1.5, trips=2),
    Robot(id="R4", capacity=Decimal(3)), Robot("R5", Fraction(9, 2)),
)
one = Instance(DistanceTable(((0.0,),)), items, orders, robots)
total: Fraction = sum((item.weight for item in one.items), Fraction(0))
room: Fraction = one.robots[0].capacity
ids: tuple[str, ...] = one.orders[0].items
qrobot.read("x.vrp", capacity=2.5, robots=3, rounding="none")
"""
WRONG = "from qrobot.problem import Item, Node\nItem('a', None, Node(0))\n"


@pytest.mark.slow
def test_strict_type_checking(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "snippet.py").write_text(SNIPPET)
    (tmp_path / "wrong.py").write_text(WRONG)
    options = ["--strict", "--config-file=", f"--cache-dir={tmp_path}", "--follow-imports=silent"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, "snippet.py", "wrong.py"],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    *errors, _ = done.stdout.splitlines()
    assert done.returncode == 1, done.stdout
    assert [error.split(":")[0] for error in errors] == ["wrong.py"], done.stdout
    assert 'Argument 2 to "Item"' in errors[0]


def test_the_kept_values_are_exact() -> None:
    assert Item("a", 2.5, Node(0)).weight == Fraction(5, 2)
    assert Robot("R", "0.1").capacity == Fraction(1, 10)
    assert Order("o", ["a", "b"]).items == ("a", "b")
    with pytest.raises(InputError, match="'ab' is one text, not several ids"):
        Order("o", "ab")
