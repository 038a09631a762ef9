"""Every check is right as the stack is, and wrong as soon as the stack is a little wrong."""

from __future__ import annotations

import importlib
import math
from functools import cache
from typing import Any

import pytest
from health.sabotage import ALSO, SABOTAGE, Spoil

from qrobot.health import Check, all_checks, difference

# What an SDK warns of when it is imported is not the question here.
pytestmark = pytest.mark.filterwarnings("ignore")

CHECKS = all_checks()


@cache
def numbers(check: Check) -> tuple[list[float], list[float]]:
    for module in check.imports:
        importlib.import_module(module)
    return check.answer(), check.expected()


@pytest.fixture(params=CHECKS)
def check(request: pytest.FixtureRequest) -> Check:
    return installed(request.param)


def installed(name: str) -> Check:
    found = CHECKS[name]
    absent = [part for part in found.distributions if part not in found.versions()]
    if absent:
        pytest.skip(f"{', '.join(absent)} not installed")
    return found


def test_the_stack_is_right_and_numbers_beyond_the_tolerance_are_wrong(check: Check) -> None:
    answer, expected = numbers(check)
    assert difference(answer, expected, check.tolerance) == ""
    for place in range(len(answer)):
        for wrong in (2.1 * check.tolerance, -2.1 * check.tolerance, math.nan, math.inf):
            other = [*answer[:place], answer[place] + wrong, *answer[place + 1 :]]
            assert f"number {place + 1} is" in difference(other, expected, check.tolerance)
    assert "numbers" in difference(answer[1:], expected, check.tolerance)
    assert all(map(math.isfinite, expected))


@pytest.mark.parametrize(
    ("name", "where", "spoil"), [*((name, *how) for name, how in SABOTAGE.items()), *ALSO]
)
def test_a_spoiled_stack_is_noticed(
    name: str, where: str, spoil: Spoil, monkeypatch: pytest.MonkeyPatch
) -> None:
    check = installed(name)
    _, expected = numbers(check)
    module, _, path = where.partition(":")
    owner: Any = importlib.import_module(module)
    *way, last = path.split(".")
    for part in way:
        owner = getattr(owner, part)
    monkeypatch.setattr(owner, last, spoil(getattr(owner, last)))
    assert difference(check.answer(), expected, check.tolerance)


def test_two_of_two_hundred_shots_of_the_atoms_may_differ_and_three_may_not() -> None:
    check = CHECKS["braket-ahs"]
    expected = check.expected()
    for place in range(3):
        for lost, noticed in ((2, False), (3, True)):
            answer = [*expected[:place], (200 - lost) / 200, *expected[place + 1 :]]
            assert bool(difference(answer, expected, check.tolerance)) == noticed


def test_every_check_has_its_sabotage() -> None:
    assert set(SABOTAGE) == set(CHECKS)
