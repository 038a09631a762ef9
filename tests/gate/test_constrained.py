"""Constraint-preserving QAOA as a backend: every read is a plan, and the reads tell the truth."""

from __future__ import annotations

import pytest
from oracles import least_distance, paper_shaped

import qrobot
from qrobot.backends.gate.constrained import GroverPlanner, SwapPlanner
from qrobot.backends.testing import PlannerConformance


class TestSwap(PlannerConformance):
    def make(self):
        return SwapPlanner()


class TestGrover(PlannerConformance):
    def make(self):
        return GroverPlanner()


@pytest.mark.parametrize("backend", ["qaoa-swap", "qaoa-grover"])
@pytest.mark.parametrize(("items", "robots"), [(2, 2), (3, 2), (4, 2), (5, 2), (3, 3), (5, 3)])
def test_several_robots_raw_reads_are_plans(backend: str, items: int, robots: int) -> None:
    instance = paper_shaped(items, robots, 4)
    expected = least_distance(instance)
    if expected is None:
        pytest.skip("this instance has no plan")
    result = qrobot.solve(instance, backend=backend, deadline=3600)
    report = result.sampler
    assert report.feasible_fraction == 1.0
    assert report.best == pytest.approx(result.cost)  # nothing was repaired or polished
    assert report.best >= expected[0] - 1e-6
    # The control: as many uniformly random plans.
    assert report.random_feasible_fraction == 1.0
    assert report.random_best >= expected[0] - 1e-6
    assert "as many random plans" in result.summary()
    told = report.details
    # Where every plan is optimal there is nothing to gain.
    assert told["ground_probability"] >= told["ground_probability_uniform"] - 1e-9
    if result.is_optimal:
        # A thousand reads of the state that was said to be there.
        share = min(told["ground_probability"], 1.0)
        spread = (share * (1 - share) / report.reads) ** 0.5
        assert abs(report.optimal_fraction - share) < 5 * spread + 1e-9


def test_too_many_plans_are_refused() -> None:
    with pytest.raises(qrobot.BackendError, match=r"sequences|plans"):
        qrobot.solve(paper_shaped(14, 1, 0), backend="qaoa-swap", deadline=5)
