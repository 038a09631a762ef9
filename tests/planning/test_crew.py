"""Helpers on other cores: they bring plans, and they end with their parent."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import psutil
import pytest
from oracles import paper_shaped
from processes import HANG, gone, until, with_our_modules

from qrobot.backends import Routes
from qrobot.plan.objective import TIME, Objective
from qrobot.planning.crew import Crew, spare_cores
from qrobot.planning.run import plan_fits

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def nothing_on_the_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """What we can import, a helper must, without help from outside."""
    monkeypatch.delenv("PYTHONPATH", raising=False)


@pytest.mark.parametrize("backend", ["pyvrp-plain", "batching"])
def test_helpers_bring_plans(backend: str) -> None:
    if backend != "batching":
        pytest.importorskip("pyvrp")
    instance = paper_shaped(30, 4, 1)
    crew = Crew(instance, backend, seed=1, seconds=None, max_work=40, helpers=2)
    found: list[Routes] = []
    crew.close(found.append, wait=HANG)
    assert found
    assert all(plan_fits(instance, plan) for plan in found)


@pytest.mark.parametrize("aim", [{}, {"objective": TIME}], ids=["distance", "time"])
def test_helpers_make_the_objective_small(aim: dict[str, Objective]) -> None:
    """One way by the slow robot is shorter, two by the fast one take less time."""
    pytest.importorskip("pyvrp")
    instance = paper_shaped(2, 1, 1)
    slow = replace(instance.robots[0], id="slow", speed=0.5)
    room = max(item.weight for item in instance.items)
    fast = replace(slow, id="fast", capacity=room, speed=2, trips=2)
    unlike = replace(instance, robots=(slow, fast))
    crew = Crew(unlike, "pyvrp", 1, seconds=None, max_work=200, helpers=1, aim=aim)
    found: list[Routes] = []
    crew.close(found.append, wait=HANG)
    assert len(found[-1]) == (2 if aim else 1)


@pytest.mark.parametrize("name", ["numpy", "json", "qrobot"])
def test_a_file_in_the_current_folder_is_not_run_by_helpers(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trap = tmp_path / "was run"
    (tmp_path / f"{name}.py").write_text(f"open({str(trap)!r}, 'w').close()\n")
    monkeypatch.chdir(tmp_path)
    crew = Crew(paper_shaped(30, 4, 1), "batching", seed=1, seconds=None, max_work=40, helpers=1)
    found: list[Routes] = []
    crew.close(found.append, wait=HANG)
    assert found
    assert not trap.exists()


def test_closing_ends_helpers_before_their_deadline() -> None:
    crew = Crew(paper_shaped(40, 4, 1), "batching", 0, seconds=1e6, max_work=None, helpers=1)
    pid = crew._processes[0].pid
    until(lambda: crew._latest[0], "the helper finds no plan")
    found: list[Routes] = []
    crew.close(found.append, wait=0.0)
    assert found
    assert not psutil.pid_exists(pid)


def test_helpers_end_when_their_parent_is_killed() -> None:
    code = (
        "import sys, time\n"
        "from oracles import paper_shaped\n"
        "from qrobot.planning.crew import Crew\n"
        "c = Crew(paper_shaped(40, 4, 1), 'batching', 0, 1e6, None, 1)\n"
        "while not c._latest[0]: time.sleep(0.02)\n"
        "print(c._processes[0].pid, flush=True); sys.stdin.read()\n"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=with_our_modules(),
    )  # fmt: skip
    assert parent.stdout is not None
    pid = int(parent.stdout.readline())
    parent.kill()
    parent.communicate()
    assert gone(pid)


def test_a_helper_that_fails_costs_nothing_but_its_plans() -> None:
    crew = Crew(paper_shaped(5, 2, 1), "no-such-backend", 0, 5, None, 1)
    found: list[Routes] = []
    crew.close(found.append, wait=HANG)
    assert found == []


def test_the_number_of_helpers_can_be_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QROBOT_HELPERS", "0")
    assert spare_cores() == 0
    monkeypatch.setenv("QROBOT_HELPERS", "2")
    assert spare_cores() == 2
    monkeypatch.delenv("QROBOT_HELPERS")
    assert 0 <= spare_cores() < max(2, os.cpu_count() or 1)
