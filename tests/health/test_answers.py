"""Every check is right as the stack is, and wrong as soon as the stack is a little wrong."""

from __future__ import annotations

import importlib
import math
from functools import cache
from typing import Any

import pytest
from health.sabotage import SABOTAGE

from qrobot.health import Check, all_checks, difference

# What an SDK warns of when it is imported is not the question here.
pytestmark = pytest.mark.filterwarnings("ignore")

CHECKS = all_checks()


@cache
def numbers(check: Check) -> tuple[list[float], list[float]]:
    for module in check.imports:
        importlib.import_module(module)
    return list(map(float, check.answer())), list(map(float, check.expected()))


@pytest.fixture(params=CHECKS)
def check(request: pytest.FixtureRequest) -> Check:
    found = CHECKS[request.param]
    absent = [name for name in found.distributions if name not in found.versions()]
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


def test_a_spoiled_stack_is_noticed(check: Check, monkeypatch: pytest.MonkeyPatch) -> None:
    _, expected = numbers(check)
    where, spoil = SABOTAGE[check.name]
    module, _, path = where.partition(":")
    owner: Any = importlib.import_module(module)
    *way, name = path.split(".")
    for part in way:
        owner = getattr(owner, part)
    monkeypatch.setattr(owner, name, spoil(getattr(owner, name)))
    assert difference(list(map(float, check.answer())), expected, check.tolerance)


def test_every_check_has_its_sabotage() -> None:
    assert set(SABOTAGE) == set(CHECKS)
