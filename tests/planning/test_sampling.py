"""Plans from samplers: what was found by itself, repair, polish, control, told apart."""

from __future__ import annotations

import dimod
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from processes import HANG
from strategies import instances

import qrobot
from qrobot.backends import Capabilities, Stop
from qrobot.backends.sampler import PickingSampler
from qrobot.planning.reads import ROUNDS
from qrobot.planning.run import plan_fits
from qrobot.planning.sampling import random_routes, repair_and_polish
from qrobot.problem import Instance


class Zeros(PickingSampler):
    """A sampler that only ever says no: everything in the plan is repair's work."""

    name = "neal"
    capabilities = Capabilities(kind="sampler")
    parameters = {"num_reads": [], "seed": []}  # noqa: RUF012
    properties = {}  # noqa: RUF012

    def sample(self, bqm, *, num_reads=1, seed=None):
        rows = np.zeros((num_reads, len(bqm.variables)), dtype=np.int8)
        return dimod.SampleSet.from_samples_bqm((rows, list(bqm.variables)), bqm)


def test_the_sampler_is_reported_apart_from_repair(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: Zeros())
    result = qrobot.solve(paper_shaped(6, 2, 0), backend="neal", max_work=4, control=True)
    assert result.sampler is not None
    assert result.sampler.reads == 4
    assert result.sampler.feasible_fraction == 0.0
    assert result.sampler.best is None
    assert result.sampler.mean is None
    assert result.sampler.polished_best == pytest.approx(result.cost)
    assert result.sampler.control_best is not None
    assert "no feasible read" in result.summary()
    assert "control" in result.summary()


def test_the_control_never_gives_the_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a control that finds the optimum, the plan must stay the sampler's own."""
    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: Zeros())
    instance = paper_shaped(6, 2, 0)
    made: list[float] = []

    def fake(_instance, start, _stop, _seed):
        routes = start if any(start) else [[v] for v in range(1, 7)]
        made.append(instance.length(routes))
        return routes if plan_fits(instance, routes) else [[1, 2, 3], [4, 5, 6]]

    monkeypatch.setattr("qrobot.planning.sampling.repair_and_polish", fake)
    instance = instance.with_robots(6)
    result = qrobot.solve(instance, backend="neal", max_work=2, control=True)
    assert result.cost == pytest.approx(instance.length([[v] for v in range(1, 7)]))


@pytest.mark.parametrize("backend", ["neal", "tabu"])
@pytest.mark.parametrize("encoding", ["compact", "reduced", "full"])
def test_every_sampler_and_encoding_gives_a_checked_plan(backend: str, encoding: str) -> None:
    instance = paper_shaped(5, 2, 3)
    expected = least_distance(instance)
    assert expected is not None
    result = qrobot.solve(instance, backend=backend, max_work=20, seed=1, encoding=encoding)
    assert qrobot.check(result.plan, instance).ok
    assert result.sampler is not None
    assert result.sampler.encoding == encoding
    assert result.cost >= expected[0] - 1e-6
    if result.sampler.best is not None:
        assert result.sampler.best >= expected[0] - 1e-6
        assert result.cost <= result.sampler.best + 1e-9
        assert result.sampler.mean is not None
        assert result.sampler.mean >= result.sampler.best - 1e-9


def test_one_seed_and_one_work_limit_give_one_plan() -> None:
    instance = paper_shaped(8, 2, 1)
    first, second = (
        qrobot.solve(instance, backend="neal", max_work=30, seed=5, control=True) for _ in range(2)
    )
    assert first.plan == second.plan
    assert first.sampler == second.sampler


def test_unknown_options_are_told() -> None:
    with pytest.raises(qrobot.InputError, match="takes no option colour"):
        qrobot.solve(paper_shaped(3, 1, 0), backend="neal", colour="red")
    with pytest.raises(qrobot.InputError, match="compact, reduced, full"):
        qrobot.solve(paper_shaped(3, 1, 0), backend="neal", encoding="nonsense")


def test_too_large_a_model_is_refused_before_it_is_built() -> None:
    with pytest.raises(qrobot.InputError, match=r"binary variables|variables"):
        qrobot.solve(paper_shaped(300, 2, 0), backend="neal", deadline=5)


def test_a_crashing_sampler_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    class Crash(Zeros):
        def sample(self, bqm, **parameters):
            raise RuntimeError("boom")

    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: Crash())
    with pytest.raises(qrobot.BackendError, match="backend neal failed: RuntimeError: boom"):
        qrobot.solve(paper_shaped(3, 1, 0), backend="neal", max_work=1)


def test_no_items_need_no_sampler() -> None:
    instance = paper_shaped(3, 1, 0)
    from dataclasses import replace

    result = qrobot.solve(replace(instance, items=(), orders=()), backend="neal")
    assert result.plan.trips == ()


@settings(max_examples=60)
@given(instances(min_items=1, max_items=7), st.integers(0, 1000), st.data())
def test_repair_makes_any_routes_valid(instance: Instance, seed: int, data: st.DataObject) -> None:
    """Left out, repeated, split, overloaded: repair gives a valid plan or none."""
    nodes = st.integers(1, instance.size)
    broken = data.draw(st.lists(st.lists(nodes, max_size=6), max_size=4))
    routes = repair_and_polish(instance, broken, Stop(), seed, rounds=5)
    if routes is None:
        return
    assert plan_fits(instance, routes)
    dealt = random_routes(instance, np.random.default_rng(seed))
    assert sorted(v for route in dealt for v in route) == list(range(1, instance.size + 1))


@pytest.mark.parametrize("backend", ["neal", "tabu", "descent"])
@pytest.mark.parametrize(
    ("items", "robots"),
    [(n, k) for k in (2, 3) for n in (2, 3)]
    + [pytest.param(n, k, marks=pytest.mark.slow) for k in (2, 3) for n in (4, 5)],
)
def test_every_annealer_gives_a_plan_by_itself(backend: str, items: int, robots: int) -> None:
    """Raw reads, nothing repaired; the lowest energy may be no plan at the first weights."""
    for seed in (200, 204, 208):
        instance = paper_shaped(items, robots, seed)
        expected = least_distance(instance)
        if expected is None:
            continue
        result = qrobot.solve(instance, backend=backend, deadline=HANG, seed=seed)
        report = result.sampler
        assert report.best is not None
        assert report.best >= expected[0] - 1e-6
        assert 1 <= report.rounds <= ROUNDS
        assert report.reads > 0
        assert report.feasible_fraction > 0


def test_weights_of_the_caller_are_kept() -> None:
    # An overload that is cheap: the lowest energy is no plan, and one round is all there is.
    instance = paper_shaped(3, 2, 204)
    result = qrobot.solve(
        instance, backend="tabu", deadline=HANG, penalties={"capacity": 1e-3}, num_reads=5
    )
    assert result.sampler.rounds == 1
    assert result.sampler.best is None
    assert qrobot.check(result.plan, instance).ok  # by repair, and the report says so
    again = qrobot.solve(instance, backend="tabu", deadline=HANG, num_reads=5)
    assert again.sampler.reads == 5 * again.sampler.rounds
