"""Many machines beside each other: who differs, from whom, in what."""

from __future__ import annotations

import json
import random
from dataclasses import replace

import pytest
from health import samples

from qrobot.health import Report
from qrobot.health.reports import FleetHealth, fleet, fleet_html


def fifty() -> list[Report]:
    machines = [samples.report(f"pi-{number}") for number in range(1, 51)]
    random.Random(1).shuffle(machines)
    return machines


def columns(found: FleetHealth) -> dict[tuple[str, str], dict[str, list[str]]]:
    return {(c.kind, c.name): c.different for c in found.columns}


def test_equal_machines_have_no_columns_and_natural_sequence() -> None:
    found = fleet(fifty())
    assert list(found.machines) == [f"pi-{number}" for number in range(1, 51)]
    assert not found.columns
    assert not found.notes
    assert not found.unhealthy
    assert {row[4] for row in found.table().rows} == {"0"}
    assert set(found.pace.values()) == {1.0}
    assert "Nothing: all machines are alike" in fleet_html(found)


def test_every_planted_difference_is_found_and_no_other() -> None:
    planted = {report.host: report for report in fifty()}
    planted["pi-4"] = samples.changed(planted["pi-4"], "qiskit", status="error")
    planted["pi-7"] = samples.changed(planted["pi-7"], "numpy", versions={"numpy": "2.0"})
    planted["pi-8"] = samples.changed(planted["pi-8"], "numpy", versions={"numpy": "2.0"})
    planted["pi-9"] = replace(planted["pi-9"], python="3.13.5")
    planted["pi-10"] = samples.found(planted["pi-10"], "throttled", status="good")
    planted["pi-11"] = samples.changed(planted["pi-11"], "dimod", versions={})
    planted["pi-12"] = samples.found(planted["pi-12"], "temperature", value=79.0)  # of the moment
    found = fleet(list(planted.values()))
    assert columns(found) == {
        ("status", "qiskit"): {"error": ["pi-4"]},
        ("status", "throttled"): {"good": ["pi-10"]},
        ("machine", "python"): {"3.13.5": ["pi-9"]},
        ("version", "dimod"): {"-": ["pi-11"]},
        ("version", "numpy"): {"2.0": ["pi-7", "pi-8"]},
    }
    assert {c.majority for c in found.columns} == {"pass", "warning", "3.11.2", "1.2.3"}
    assert found.unhealthy == ["pi-4"]
    assert found.bad_lines() == ["pi-4 is unhealthy: qiskit error: why qiskit is pass"]
    assert found.differences("pi-7") == 1
    assert found.differences("pi-1") == 0
    (sentence,) = [c.sentence() for c in found.columns if c.name == "numpy"]
    assert sentence == "version numpy: 1.2.3 on 48; 2.0 on pi-7, pi-8"
    table = found.table()
    odd = {(table.rows[row][0], table.heads[column]) for row, column in table.odd}
    assert odd == {
        ("pi-4", "qiskit"), ("pi-7", "numpy"), ("pi-8", "numpy"), ("pi-9", "python"),
        ("pi-10", "throttled"), ("pi-11", "dimod"),
    }  # fmt: skip
    json.dumps(found.to_dict(), allow_nan=False)


def test_the_newest_report_of_a_machine_counts_whatever_its_zone() -> None:
    early = replace(samples.report(), made="2026-11-20T09:30:00+02:00", python="3.11.1")
    late = replace(samples.report(), made="2026-11-20T08:00:00+00:00")
    for reports in ([early, late], [late, early]):
        found = fleet(reports)
        assert found.machines == {"pi-01": late}
        assert found.notes == ("pi-01: 2 reports, the newest (2026-11-20T08:00:00+00:00) counts",)


def test_machines_of_one_name_stay_apart() -> None:
    one = samples.report("raspberrypi")
    other = replace(one, machine_id="another", python="3.13.5")
    none = replace(one, machine_id=None)
    found = fleet([one, other, none])
    assert sorted(found.machines) == [
        "raspberrypi (anothe)", "raspberrypi (id-ras)",
        "raspberrypi (no id, aarch64, Raspberry Pi 4 Model B Rev 1.4)",
    ]  # fmt: skip
    assert found.notes == ("raspberrypi: 3 machines have this name; give each its own",)


def test_machines_without_an_id_are_told_apart_by_their_kind() -> None:
    pi = samples.report("vm", machine_id=None)
    server = replace(pi, machine="x86_64", model=None)
    found = fleet([pi, server, replace(server, machine="riscv64")])
    assert {report.machine for report in found.machines.values()} == {
        "aarch64", "x86_64", "riscv64",
    }  # fmt: skip
    assert "vm (no id, x86_64)" in found.machines
    assert found.notes == ("vm: 3 machines have this name; give each its own",)


def test_reports_that_cannot_be_told_apart_are_said_to_be_so() -> None:
    one = samples.report("vm", machine_id=None)
    late = replace(one, made="2026-11-21T08:00:00+00:00", python="3.13.5")
    found = fleet([late, one])
    assert found.machines == {"vm": late}
    assert found.notes[1:] == (
        "vm has no machine id: reports of several machines of this name cannot be told apart",
    )
    assert len(fleet([one, samples.report("b")]).notes) == 0  # one report is of one machine


def test_ids_that_begin_alike_lose_no_machine() -> None:
    machines = [samples.report("pi", machine_id=f"0123456789{k}") for k in "ab"]
    assert set(fleet(machines).machines) == {"pi (012345)", "pi (0123456789b)"}


@pytest.mark.parametrize("digits", ["9" * 5000, "0" * 5000, "\u0663\u0664", "\u00b2"])
def test_numbers_of_any_length_are_sorted(digits: str) -> None:
    names = ["pi-9", "pi-010", "pi-11", f"pi-{digits}", "pi"]
    found = list(fleet([samples.report(name) for name in names]).machines)
    assert [name for name in found if digits not in name] == ["pi", "pi-9", "pi-010", "pi-11"]
    if digits.startswith("9"):
        assert found[-1] == f"pi-{digits}"


def test_a_tie_has_no_majority() -> None:
    found = fleet([samples.report("a"), replace(samples.report("b"), python="3.13.5")])
    (column,) = found.columns
    assert column.majority is None
    assert column.sentence() == "machine python: no majority; 3.11.2 on a; 3.13.5 on b"
    assert found.differences("a") == found.differences("b") == 0


def test_what_was_not_looked_at_does_not_differ() -> None:
    quick = samples.report("quick")
    quick = replace(quick, checks=quick.checks[:1], system=())
    found = fleet([samples.report("a"), samples.report("b"), quick])
    assert not found.columns


def test_an_absent_stack_differs_in_its_version_too() -> None:
    absent = samples.changed(samples.report("c"), "qiskit", status="absent", versions={})
    found = fleet([samples.report("a"), samples.report("b"), absent])
    assert columns(found) == {
        ("status", "qiskit"): {"absent": ["c"]},
        ("version", "qiskit"): {"-": ["c"]},
    }
    assert found.unhealthy == []


def test_times_are_held_against_the_median() -> None:
    machines = [samples.report(f"pi-{number}") for number in range(1, 6)]
    slow = machines[4]
    for name in ("numpy", "qiskit", "dimod"):
        slow = samples.changed(slow, name, import_seconds=1.0, run_seconds=0.5)
    machines[4] = samples.changed(slow, "qiskit", run_seconds=29.0)
    machines[0] = samples.changed(machines[0], "numpy", status="fail", run_seconds=900.0)
    found = fleet(machines)
    assert found.pace["pi-5"] == pytest.approx(2.0)  # 1.5 s where the median takes 0.75 s
    assert found.pace["pi-1"] == 1.0  # a wrong answer has no time
    assert found.slow["pi-5"] == {"qiskit": 40.0}
    assert found.slow_lines() == ["pi-5 is slow: qiskit 40.0 × the median"]


def test_one_machine_alone_has_nothing_to_be_held_against() -> None:
    found = fleet([samples.report()])
    assert found.pace == {"pi-01": None}
    assert not found.columns
    assert "pi-01" in fleet_html(found)
