"""The samplers neal and tabu: conformance, repeatability, refusals, and plans they find."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import ClassVar

import dimod
import numpy as np
import pytest
from oracles import least_distance, paper_shaped

from qrobot.backends import Capabilities, Planner, Routes, Search, Stop
from qrobot.backends.annealing.samplers import NealSampler, TabuSampler
from qrobot.backends.sampler import Parameter, PickingSampler
from qrobot.backends.testing import PlannerConformance, SamplerConformance, cases, verify
from qrobot.errors import InputError
from qrobot.models import build_model
from qrobot.problem import Instance

SAMPLERS = [NealSampler, TabuSampler]


class TestNeal(SamplerConformance):
    def make(self) -> PickingSampler:
        return NealSampler()


class TestTabu(SamplerConformance):
    parameters: ClassVar[dict[str, int]] = {"moves": 50, "num_restarts": 2}

    def make(self) -> PickingSampler:
        return TabuSampler()


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize(("items", "robots"), [(6, 1), (5, 2)])
def test_they_find_the_least_distance_by_themselves(
    sampler: type[PickingSampler], items: int, robots: int
) -> None:
    instance = paper_shaped(items, robots, 2)
    best = least_distance(instance)
    assert best is not None
    model = build_model(instance)
    one = sampler()
    defaults = one.picking_defaults(largest_distance=float(instance.distances.max()))
    samples = one.sample(model.bqm, seed=1, **defaults)
    feasible, distances = model.decode_all(samples)
    assert feasible.any()
    assert distances.min() == pytest.approx(best[0])


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_different_seeds_give_different_reads(sampler: type[PickingSampler]) -> None:
    model = build_model(paper_shaped(6, 1, 0))
    one, two = (sampler().sample(model.bqm, num_reads=5, seed=s).record.sample for s in (1, 2))
    assert not np.array_equal(one, two)


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_seeds_of_any_size_are_taken(sampler: type[PickingSampler]) -> None:
    bqm = dimod.BinaryQuadraticModel({"a": -1.0}, {}, 0.0, "BINARY")
    for seed in (0, 2**31 - 1, 2**31, 2**40):
        assert sampler().sample(bqm, seed=seed).first.sample == {"a": 1}


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_reads_start_where_they_are_told_to(sampler: type[PickingSampler]) -> None:
    bqm = dimod.BinaryQuadraticModel({"a": -1.0, "b": 1.0}, {"ab": 0.5}, 0.0, "BINARY")
    samples = sampler().sample(bqm, initial_states=[{"a": 1, "b": 0}, {"a": 0, "b": 1}], seed=1)
    assert len(samples) == 2
    with pytest.raises(InputError, match="initial states"):
        sampler().sample(
            bqm, initial_states=[{"a": 1, "b": 0}], initial_states_generator="none", num_reads=2
        )


@pytest.mark.parametrize(
    ("sampler", "wrong", "says"),
    [
        (NealSampler, {"beta_range": [1.0, -1.0]}, "beta_range: .* a list of 2 numbers, each of 0"),
        (NealSampler, {"beta_schedule_type": "wild"}, "beta_schedule_type: 'wild' is not one of"),
        (NealSampler, {"num_reads": 0}, "num_reads: 0 is not a whole number of 1 or more"),
        (NealSampler, {"num_reads": 1.5}, "num_reads: 1.5 is not a whole number"),
        (NealSampler, {"num_sweeps": 0}, "num_sweeps: 0 is not a whole number from 1 to 100000000"),
        (NealSampler, {"beta_range": [math.nan, 1]}, "beta_range: .nan, 1. is not a list"),
        (NealSampler, {"beta_range": [0.0, 1.0]}, "the annealer refused its parameters"),
        (TabuSampler, {"tenure": 99}, "the tabu search refused its parameters"),
        (TabuSampler, {"moves": "abc"}, "moves: 'abc' is not a whole number from 1"),
        (TabuSampler, {"moves": 0}, "moves: 0 is not a whole number from 1"),
        (TabuSampler, {"num_restarts": -1}, "num_restarts: -1 is not a whole number from 0"),
        (TabuSampler, {"timeout": -5}, "timeout: -5 is not a whole number from 1"),
        (TabuSampler, {"num_read": 5}, "takes no option num_read; did you mean num_reads[?]"),
    ],
)
def test_unusable_parameters_are_refused_in_a_sentence(
    sampler: type[PickingSampler], wrong: dict[str, object], says: str
) -> None:
    bqm = dimod.BinaryQuadraticModel({"a": -1.0, "b": 1.0}, {"ab": 0.5}, 0.0, "BINARY")
    with pytest.raises(InputError, match=says):
        sampler().sample(bqm, **wrong)


def test_a_refusal_names_the_coefficient() -> None:
    bqm = dimod.BinaryQuadraticModel({"a": 1.0, "b": 0.0}, {"ab": float("nan")}, 0.0, "BINARY")
    with pytest.raises(InputError, match=r"'[ab]' with '[ab]' is not a finite number"):
        NealSampler().sample(bqm)


def test_an_interrupt_keeps_the_reads_so_far() -> None:
    model = build_model(paper_shaped(6, 1, 0))
    asked: list[int] = []

    def enough() -> bool:
        asked.append(1)
        return len(asked) >= 3

    for sampler in SAMPLERS:
        asked.clear()
        samples = sampler().sample(model.bqm, num_reads=50, seed=1, interrupt_function=enough)
        assert len(samples) == 3


def test_tabu_takes_a_clock_when_asked() -> None:
    model = build_model(paper_shaped(6, 1, 0))
    samples = TabuSampler().sample(
        model.bqm, num_reads=2, timeout=50, num_restarts=10**6, moves=10**6
    )
    assert len(samples) == 2  # after 0.1 s; a million restarts of a million moves take days


def test_tabu_ends_at_a_threshold() -> None:
    model = build_model(paper_shaped(6, 1, 0))
    samples = TabuSampler().sample(
        model.bqm, num_reads=1, seed=1, energy_threshold=1e9, num_restarts=10**6
    )
    assert samples.record.num_restarts[0] == 0


# -- the suites catch what they are for ------------------------------------------------------


class Sloppy(NealSampler):
    """Takes anything, tells wrong energies, and never the same twice."""

    calls = 0

    def sample(self, bqm: dimod.BinaryQuadraticModel, **_: object) -> dimod.SampleSet:
        Sloppy.calls += 1
        rng = np.random.default_rng(Sloppy.calls)
        low = -1 if bqm.vartype is dimod.SPIN else 0
        states = np.where(rng.random((3, bqm.num_variables)) < 0.5, low, 1)
        return dimod.SampleSet.from_samples(
            (states, list(bqm.variables)), energy=[0.0] * 3, vartype=bqm.vartype
        )


@pytest.mark.parametrize(
    "check",
    [
        "test_energies_are_those_of_the_model",
        "test_passes_the_tests_of_dimod",
        "test_finds_the_ground_state_of_a_small_model",
        "test_takes_a_model_without_variables",
        "test_one_seed_gives_one_answer",
    ],
)
def test_the_sampler_suite_catches(check: str) -> None:
    class Suite(SamplerConformance):
        def make(self) -> PickingSampler:
            return Sloppy()

    with pytest.raises(AssertionError):
        getattr(Suite(), check)()


class Careless:
    """Looks at nothing that it is given: what a sampler without our base may do."""

    name = "careless"
    capabilities = Capabilities(kind="sampler")
    parameters: ClassVar[dict[str, list[str]]] = {"num_reads": [], "colour": []}
    accepts: ClassVar[dict[str, Parameter]] = {}

    def sample(self, _bqm: object, **_: object) -> dimod.SampleSet:
        return dimod.SampleSet.from_samples([{"a": 1}], energy=[0.0], vartype="BINARY")


@pytest.mark.parametrize(
    "check",
    [
        "test_says_what_its_parameters_take",
        "test_refuses_unknown_parameters_by_the_nearest_name",
        "test_refuses_values_of_the_wrong_type_or_out_of_range",
        "test_refuses_what_is_not_finite",
        "test_refuses_what_is_not_a_binary_quadratic_model",
    ],
)
def test_the_sampler_suite_catches_careless_ones(check: str) -> None:
    class Suite(SamplerConformance):
        def make(self) -> PickingSampler:
            return Careless()  # type: ignore[return-value]

    with pytest.raises(AssertionError):
        getattr(Suite(), check)()


class Liar:
    """Puts everything on one trip, calls it optimal, and is deaf."""

    name = "liar"
    capabilities = Capabilities(kind="planner", proves=True)
    calls = 0

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,
        on_best: Callable[..., None] | None = None,
    ) -> Search:
        Liar.calls += 1
        routes = [list(range(1, instance.size + 1))] if instance.size else []
        if start:
            start[0].reverse()
        if on_best:
            on_best(routes, 0.0)
        if instance.size > 20:
            time.sleep(1.2)
        return Search(routes=routes, bound=1e9, optimal=True, work=Liar.calls, infeasible="no")


@pytest.mark.parametrize(
    "check",
    [
        "test_plans_keep_to_all_rules_and_bounds_are_true",
        "test_never_calls_a_solvable_instance_infeasible",
        "test_tells_of_feasible_plans_only",
        "test_one_seed_and_one_limit_of_work_give_one_plan",
        "test_takes_a_start",
        "test_ends_when_asked_to",
    ],
)
def test_the_planner_suite_catches(check: str) -> None:
    class Suite(PlannerConformance):
        def make(self) -> Planner:
            return Liar()

    with pytest.raises(AssertionError):
        getattr(Suite(), check)()


def test_the_rules_of_a_plan() -> None:
    whole = next(case.instance for case in cases() if case.name == "whole orders")
    assert verify(whole, [[4, 1, 2, 3], [5, 6]]) == pytest.approx(
        whole.length([[4, 1, 2, 3], [5, 6]])
    )
    for routes, fault in (
        ([[1, 4, 2, 3], [5]], "items collected"),
        ([[1, 4, 2, 3, 3], [5, 6]], "items collected"),
        ([[1, 2, 3, 5], [4, 6]], "split"),
        ([[1, 4], [2, 3], [5, 6]], "3 trips for 2"),
        ([[1, 4, 2, 3, 5, 6]], "a load of 15"),
    ):
        with pytest.raises(AssertionError, match=fault):
            verify(whole, routes)


def test_the_cases_have_the_optima_of_another_programme() -> None:
    for case in cases():
        expected = least_distance(case.instance)
        assert (case.best is None) == (expected is None), case.name
        if expected is not None:
            assert case.best == pytest.approx(expected[0]), case.name
