"""Pictures that are refused, and settings that change nothing."""

from __future__ import annotations

import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from scenes import CASES, shared

from qrobot._numbers import number
from qrobot.errors import InputError, MissingExtraError
from qrobot.problem import Robot
from qrobot.report import plot

pytest.importorskip("matplotlib")


@pytest.mark.parametrize("name", ["plan.jpg", "plan", "plan.svg.gz", ".svg"])
def test_another_suffix_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"end it with \.svg or \.png"):
        plot(shared(CASES["table"]), tmp_path / name, CASES["table"])
    assert list(tmp_path.iterdir()) == []


def test_a_plan_needs_its_own_instance(tmp_path: Path) -> None:
    path = tmp_path / "plan.svg"
    plan = shared(CASES["aisles"])
    with pytest.raises(InputError, match="give its instance too"):
        plot(plan, path)
    with pytest.raises(InputError, match="item 'i4' is not in the instance"):
        plot(plan, path, CASES["there and back"])
    with pytest.raises(InputError, match="robot 'R4' is not in the instance"):
        plot(shared(CASES["many"], 4), path, replace(CASES["many"], robots=plan_robots(3)))
    assert not path.exists()


def plan_robots(count: int) -> tuple[Robot, ...]:
    return CASES["many"].robots[:count]


def test_without_matplotlib_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'qrobot\[plot\]'"):
        plot(shared(CASES["table"]), tmp_path / "plan.svg", CASES["table"])


def test_settings_of_the_user_change_nothing(tmp_path: Path) -> None:
    import matplotlib

    instance = CASES["table"]
    plot(shared(instance), tmp_path / "one.svg", instance)
    with matplotlib.rc_context({"lines.linewidth": 9, "font.family": "monospace"}):
        before = dict(matplotlib.rcParams)
        plot(shared(instance), tmp_path / "two.svg", instance)
        assert dict(matplotlib.rcParams) == before
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (12.0, "12"), (12.5, "12.5"), (1234.567, "1234.57"), (0.012345, "0.0123"),
     (98765.4, "98765"), (Fraction(1, 4), "0.25")],
)  # fmt: skip
def test_numbers_are_written_for_people(value: float, text: str) -> None:
    assert number(value) == text
