"""Counts of plans by distance against the enumerated plans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import paper_shaped
from strategies import instances

from qrobot.backends.gate import resources
from qrobot.backends.gate.counting import spectrum
from qrobot.backends.gate.feasible import feasible_set
from qrobot.backends.gate.state.subspace import SubspaceQAOA
from qrobot.errors import BackendError, InfeasibleError, InputError
from qrobot.problem import Instance, OpenFloor


def whole(instance: Instance) -> Instance:
    floor = instance.warehouse
    assert isinstance(floor, OpenFloor)
    return replace(instance, warehouse=replace(floor, rounding="nearest"))


@given(instances(max_items=5, max_robots=3, kinds=["floor"]), st.integers(0, 9))
def test_counts_equal_the_enumeration(instance: Instance, seed: int) -> None:
    instance = whole(instance)
    try:
        plans = feasible_set(instance)
    except InfeasibleError:
        with pytest.raises(InfeasibleError):
            spectrum(instance)
        return
    counted = spectrum(instance)
    levels, counts = np.unique(plans.costs, return_counts=True)
    assert counted.levels.tolist() == levels.tolist()
    assert counted.counts.tolist() == counts.tolist()
    assert (counted.size, counted.optimal) == (plans.size, len(plans.optimal))
    gammas, betas = np.random.default_rng(seed).normal(size=(2, 3))
    by_level = counted.qaoa().probabilities(gammas, betas)
    by_plan = SubspaceQAOA.of(plans, "grover").probabilities(gammas, betas)
    summed = np.bincount(np.searchsorted(levels, plans.costs), by_plan, len(levels))
    np.testing.assert_allclose(by_level, summed, atol=1e-12)


@pytest.mark.parametrize(("n", "robots"), [(7, 1), (8, 1), (6, 2), (7, 2)])
def test_counts_of_larger_rows(n: int, robots: int) -> None:
    instance = whole(paper_shaped(n, robots, 0))
    counted, plans = spectrum(instance), feasible_set(instance)
    levels, counts = np.unique(plans.costs, return_counts=True)
    assert counted.levels.tolist() == levels.tolist()
    assert counted.counts.tolist() == counts.tolist()


def test_twelve_items_are_counted_completely() -> None:
    assert spectrum(whole(paper_shaped(12, 1, 0))).size == 479_001_600


def test_what_cannot_be_counted_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="whole distances"):
        spectrum(paper_shaped(5, 1, 0))
    with pytest.raises(BackendError, match="more than the 15"):
        spectrum(whole(paper_shaped(16, 1, 0)))
    monkeypatch.setattr(resources, "available_memory", lambda: 1000)
    with pytest.raises(BackendError, match="1,000 bytes"):
        spectrum(whole(paper_shaped(5, 1, 0)))
