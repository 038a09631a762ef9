"""``auto`` and samplers are planners like the others, and keep the same rules."""

from __future__ import annotations

import pytest

from qrobot.backends import Planner, get, names
from qrobot.backends.sampler import PickingSampler
from qrobot.backends.testing import PlannerConformance
from qrobot.planning.solving import strategy_of


class TestAuto(PlannerConformance):
    def make(self) -> Planner:
        return strategy_of("auto")


class TestSampler(PlannerConformance):
    large = 12

    def make(self) -> Planner:
        pytest.importorskip("dwave.samplers")
        return strategy_of("descent")


def test_auto_is_in_the_registry_and_chooses_among_the_names() -> None:
    auto = get("auto")
    assert isinstance(auto, Planner)
    assert auto.name == "auto"
    assert "auto" not in names()


@pytest.mark.parametrize("name", ["auto", "exact", "batching", "statevector"])
def test_every_backend_runs_as_a_planner(name: str) -> None:
    strategy = strategy_of(name)
    assert isinstance(strategy, Planner)
    assert strategy.name == name
    assert (strategy.sampler is not None) == isinstance(get(name), PickingSampler)
