"""Two reports against each other: every change is found, and none that is not there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from health import samples

from qrobot.health.reports import compare
from qrobot.health.reports.compare import RANK

ONE = samples.report()


def changes(other: Any) -> list[tuple[str, str, str, str, bool]]:
    found = compare(ONE, other)
    return [(c.kind, c.name, c.before, c.after, c.worse) for c in found.changes]


def test_nothing_differs_from_itself() -> None:
    found = compare(ONE, replace(ONE, made="2026-11-21T08:00:00+00:00", seconds=99.0))
    assert not found.changes
    assert not found.worse
    assert not found.drift
    assert "0 changes, 0 for the worse" in found.headline()


@pytest.mark.parametrize("before", RANK)
@pytest.mark.parametrize("after", RANK)
def test_a_status_gets_worse_or_better(before: Any, after: Any) -> None:
    old = samples.changed(ONE, "qiskit", status=before)
    new = samples.changed(ONE, "qiskit", status=after)
    found = [change for change in compare(old, new).changes if change.kind == "status"]
    assert len(found) == (before != after)
    worse = {("pass", "absent"), ("pass", "fail"), ("pass", "error"), ("absent", "fail"),
             ("absent", "error")}  # fmt: skip
    assert bool(compare(old, new).worse) == ((before, after) in worse)


def test_versions_changed_new_and_gone() -> None:
    other = samples.changed(ONE, "numpy", versions={"numpy": "2.0"})
    other = samples.changed(other, "dimod", versions={"dimod": "1.2.3", "extra": "1"})
    other = samples.changed(other, "qiskit", versions={})
    other = replace(other, qrobot="0.2.0")
    assert changes(other) == [
        ("version", "extra", "-", "1", False),
        ("version", "numpy", "1.2.3", "2.0", False),
        ("version", "qiskit", "1.2.3", "-", False),
        ("version", "qrobot", "0.1.0", "0.2.0", False),
    ]
    assert not compare(ONE, other).worse
    assert len(compare(ONE, other).drift) == 4


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [
        (0.25, False),
        (0.749, False),  # not 0.5 s more
        (0.76, True),  # 1.26 s after 0.75 s
        (9.0, True),
        (0.0, False),  # 0.5 s after 0.75 s: by the factor, but only 0.25 s less
    ],
)
def test_times_are_shown_beyond_a_factor_and_a_floor(seconds: float, shown: bool) -> None:
    other = samples.changed(ONE, "numpy", run_seconds=seconds)
    assert [change[0] for change in changes(other)] == ["time"] * shown
    assert not compare(ONE, other).worse
    assert not compare(ONE, other).drift


def test_a_time_below_the_factor_is_not_shown() -> None:
    old = samples.changed(ONE, "numpy", run_seconds=100.0)
    new = samples.changed(ONE, "numpy", run_seconds=149.0)
    assert not compare(old, new).changes
    assert compare(old, samples.changed(ONE, "numpy", run_seconds=152.0)).changes


def test_faster_is_shown_too() -> None:
    old = samples.changed(ONE, "numpy", run_seconds=9.0)
    assert [c.after for c in compare(old, ONE).changes] == ["0.8 s"]


@pytest.mark.parametrize(("peak", "shown"), [(129.0, False), (131.0, True), (None, False)])
def test_memory(peak: float | None, shown: bool) -> None:
    other = samples.changed(ONE, "numpy", peak_mb=peak)
    assert [change[0] for change in changes(other)] == ["memory"] * shown


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        ((1.0, 2.0 + 9e-10), []),
        ((1.0, 2.0 + 2e-9), ["number 2: 2.000000002"]),
        ((1.1, 2.2), ["number 2: 2.2"]),
        ((1.0, None), ["number 2: not finite"]),
        ((1.0,), ["1 numbers"]),
    ],
)
def test_answers(answer: tuple[float | None, ...], expected: list[str]) -> None:
    other = samples.changed(ONE, "numpy", answer=answer)
    assert [change[3] for change in changes(other)] == expected
    assert len(compare(ONE, other).drift) == len(expected)


def test_facts_of_the_machine() -> None:
    other = samples.found(ONE, "cpu-features", value=("neon", "crc32", "lse"))
    other = samples.found(other, "temperature", value=85.0, status="warning")
    other = samples.found(other, "memory", value=3791)  # another kernel, the same board
    other = replace(other, python="3.13.5")
    assert changes(other) == [
        ("status", "temperature", "good", "warning", False),
        ("machine", "python", "3.11.2", "3.13.5", False),
        ("machine", "cpu-features", "neon crc32", "neon crc32 lse", False),
    ]


def test_a_new_fault_is_worse() -> None:
    other = samples.found(ONE, "memory", status="fault")
    assert [change.name for change in compare(ONE, other).worse] == ["memory"]
    assert not compare(other, ONE).worse


@pytest.mark.parametrize(
    ("before", "after", "strict", "plain"),
    [("good", "warning", 0, 0), ("warning", "good", 0, 0), ("good", "fault", 1, 1),
     ("unknown", "warning", 0, 0), ("fault", "good", 0, 0)],
)  # fmt: skip
def test_the_weather_is_no_drift_unless_it_is_a_fault(
    before: Any, after: Any, strict: int, plain: int
) -> None:
    for name in ("temperature", "memory-available", "clock-synchronised"):
        one = samples.found(ONE, name, status=before)
        found = compare(one, samples.found(ONE, name, status=after))
        assert [change.name for change in found.changes] == [name]  # it is shown
        assert (len(found.drift), len(found.worse)) == (strict, plain)


def test_a_steady_finding_that_changed_is_drift() -> None:
    other = samples.found(ONE, "memory", status="warning")
    assert [change.name for change in compare(ONE, other).drift] == ["memory"]
    assert [change.name for change in compare(other, ONE).drift] == ["memory"]
    assert not compare(ONE, other).worse


def test_what_only_one_of_them_ran_is_named_and_forgiven() -> None:
    other = replace(ONE, checks=(*ONE.checks[1:], samples.check("scipy", "fail")), system=())
    found = compare(ONE, other)
    assert found.apart == ("numpy", "scipy")
    assert not found.changes
    assert "in one of them only: numpy, scipy" in found.headline()


def test_the_table_and_the_json_hold_every_change() -> None:
    other = samples.changed(ONE, "numpy", status="fail")
    found = compare(ONE, other)
    assert found.table().rows == (("numpy", "status", "pass", "fail", "worse"),)
    data = found.to_dict()
    assert data["worse"] == data["drift"] == 1
    assert data["changes"][0]["name"] == "numpy"
