"""What every sampler must keep to."""

# The names of the tests say what they check.
# ruff: noqa: D102

from __future__ import annotations

import inspect
import itertools
import math
import unittest
import warnings
from collections.abc import Mapping
from typing import Any, ClassVar

import dimod
import dimod.testing
import numpy as np

from qrobot.backends.sampler import COMMON, Parameter, PickingSampler
from qrobot.errors import BackendError, InputError

__all__ = ["SamplerConformance"]

CLOSE = 1e-6


def wrong_values(parameter: Parameter) -> list[Any]:
    """Return values that a parameter must refuse: of other types, and just out of its range."""
    if parameter.kind == "any":
        return []
    values: list[Any] = [object(), b"abc"]
    if parameter.kind in ("whole", "number"):
        values += ["abc", "1", True, math.nan, math.inf, -math.inf, [1]]
        if parameter.least is not None:
            values.append(parameter.least if parameter.above else parameter.least - 1)
        if parameter.most is not None:
            values.append(parameter.most + 1)
        if parameter.kind == "whole":
            values += [(parameter.least or 0) + 0.5, math.pi * 1e6]
    elif parameter.kind in ("numbers", "pairs"):
        values += ["abc", 1, [math.nan], ["1", "2"], {"a": 1}, [[1, math.inf]]]
    elif parameter.kind == "choice":
        values += ["no such word", 1, "", [parameter.choices[0]]]
    elif parameter.kind in ("flag", "names", "text"):
        values += [5, ["abc"], 0.5]
    elif parameter.kind == "function":
        values += [5, "abc"]
    if not parameter.optional:
        values.append(None)
    return [value for value in values if not isinstance(value, parameter.also)]


class SamplerConformance:
    """What every sampler must keep to. Override `make`; adjust the rest where needed."""

    parameters: ClassVar[Mapping[str, Any]] = {}
    """Passed to every call: settings that make the sampler quick enough for a test."""

    max_variables: ClassVar[int | None] = None
    """Largest model that the sampler takes, when that is fewer than six variables."""

    finds_ground_states: ClassVar[bool] = True
    """Whether the least energy of a model of six variables must be among the reads."""

    def make(self) -> PickingSampler:
        """Return a sampler."""
        raise NotImplementedError

    def sample(self, bqm: dimod.BinaryQuadraticModel, **more: Any) -> dimod.SampleSet:
        """Sample with `parameters` and a seed where the sampler takes one."""
        sampler = self.make()
        given = {**self.parameters, **more}
        if "seed" in sampler.parameters:
            given.setdefault("seed", 7)
        return sampler.sample(bqm, **given)

    def small(self, vartype: str, seed: int = 0) -> dimod.BinaryQuadraticModel:
        """Return a random model with fields, couplings and an offset."""
        rng = np.random.default_rng(seed)
        size = 6 if self.max_variables is None else min(6, self.max_variables)
        names = [f"v{k}" for k in range(size)]
        return dimod.BinaryQuadraticModel(
            {name: float(rng.normal()) for name in names},
            {pair: float(rng.normal()) for pair in itertools.combinations(names, 2)},
            1.25,
            vartype,
        )

    def test_is_a_dimod_sampler(self) -> None:
        dimod.testing.assert_sampler_api(self.make())

    def test_declares_itself(self) -> None:
        sampler = self.make()
        assert isinstance(sampler.name, str)
        assert sampler.name
        assert sampler.capabilities.kind == "sampler"
        assert sampler.capabilities.max_size is None or sampler.capabilities.max_size > 0

    def test_documents_its_parameters(self) -> None:
        sampler = self.make()
        signature = inspect.signature(sampler.sample).parameters
        open_end = any(p.kind is p.VAR_KEYWORD for p in signature.values())
        text = f"{type(sampler).__doc__} {type(sampler).sample.__doc__}"
        for name in sampler.parameters:
            assert open_end or name in signature, f"sample() does not take {name}"
            assert open_end or name in text, f"no word about the parameter {name}"

    def test_passes_the_tests_of_dimod(self) -> None:
        def factory() -> PickingSampler:
            return self.make()

        case = type("Dimod", (unittest.TestCase,), {})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", dimod.testing.sampler.TestCaseOverloadWarning)
            dimod.testing.load_sampler_bqm_tests(factory, self.max_variables)(case)
        result = unittest.TestResult()
        unittest.defaultTestLoader.loadTestsFromTestCase(case).run(result)
        assert result.testsRun
        faults = [text for _, text in result.errors + result.failures]
        assert not faults, faults[0]

    def test_energies_are_those_of_the_model(self) -> None:
        for vartype in ("BINARY", "SPIN"):
            bqm = self.small(vartype)
            samples = self.sample(bqm)
            assert len(samples) > 0
            assert samples.vartype is bqm.vartype
            assert set(samples.variables) == set(bqm.variables)
            dimod.testing.assert_sampleset_energies(samples, bqm, precision=5)

    def test_finds_the_ground_state_of_a_small_model(self) -> None:
        if not self.finds_ground_states:
            return
        reads = {"num_reads": 50} if "num_reads" in self.make().parameters else {}
        for vartype in ("BINARY", "SPIN"):
            bqm = self.small(vartype, seed=1)
            least = dimod.ExactSolver().sample(bqm).first.energy
            found = self.sample(bqm, **{**reads, **self.parameters}).first.energy
            assert abs(found - least) < CLOSE, f"{found} instead of {least}"

    def test_takes_a_model_without_variables(self) -> None:
        for vartype in ("BINARY", "SPIN"):
            samples = self.sample(dimod.BinaryQuadraticModel({}, {}, 2.5, vartype))
            assert not list(samples.variables)
            assert all(energy == 2.5 for energy in samples.record.energy)

    def test_takes_a_model_without_coefficients(self) -> None:
        samples = self.sample(dimod.BinaryQuadraticModel({"a": 0.0}, {}, 2.5, "BINARY"))
        assert list(samples.variables) == ["a"]
        assert all(energy == 2.5 for energy in samples.record.energy)

    def test_refuses_what_is_not_finite(self) -> None:
        for value in (math.nan, math.inf, -math.inf):
            for bqm in (
                dimod.BinaryQuadraticModel({"a": value}, {}, 0.0, "BINARY"),
                dimod.BinaryQuadraticModel({"a": 1.0, "b": 0.0}, {"ab": value}, 0.0, "SPIN"),
                dimod.BinaryQuadraticModel({"a": 1.0}, {}, value, "BINARY"),
            ):
                refusal = ""
                try:
                    self.sample(bqm)
                except (BackendError, InputError) as error:
                    refusal = str(error)
                assert refusal, f"a model with {value} was sampled"
                assert "\n" not in refusal, "a refusal is one sentence"

    def test_one_seed_gives_one_answer(self) -> None:
        sampler = self.make()
        if not (sampler.capabilities.deterministic and "seed" in sampler.parameters):
            return
        bqm = self.small("BINARY", seed=2)
        first, second = self.sample(bqm, seed=11), self.sample(bqm, seed=11)
        assert list(first.variables) == list(second.variables)
        assert np.array_equal(first.record.sample, second.record.sample)
        assert np.array_equal(first.record.energy, second.record.energy)

    def test_leaves_the_model_as_it_is(self) -> None:
        bqm = self.small("BINARY", seed=3)
        before = bqm.copy()
        self.sample(bqm)
        assert bqm == before
        assert bqm.vartype is before.vartype

    def test_says_what_its_parameters_take(self) -> None:
        sampler = self.make()
        unknown = set(sampler.parameters) - {*COMMON, *sampler.accepts}
        assert not unknown, f"`accepts` does not say what {', '.join(sorted(unknown))} take"

    def test_refuses_unknown_parameters_by_the_nearest_name(self) -> None:
        known = self.make().parameters
        for name in known:
            mistyped = f"{name[:-1]}_"
            assert mistyped not in known
            refusal = self.refusal_of(self.small("BINARY"), **{mistyped: None})
            assert mistyped in refusal, f"{mistyped} is not named: {refusal}"
            assert name in refusal, f"{name} is not named for {mistyped}: {refusal}"

    def test_refuses_values_of_the_wrong_type_or_out_of_range(self) -> None:
        sampler = self.make()
        for name, parameter in {**COMMON, **sampler.accepts}.items():
            if name not in sampler.parameters:
                continue
            for value in wrong_values(parameter):
                refusal = self.refusal_of(self.small("BINARY"), **{name: value})
                assert name in refusal, f"{name}={value!r} is not refused by its name: {refusal}"

    def test_refuses_what_is_not_a_binary_quadratic_model(self) -> None:
        others: tuple[Any, ...] = (
            dimod.ConstrainedQuadraticModel(),
            dimod.QuadraticModel(),
            {},
            None,
        )
        for other in others:
            assert "binary quadratic model" in self.refusal_of(other)

    def refusal_of(self, bqm: Any, **parameters: Any) -> str:
        """Return the sentence of the `InputError` that a sample ends with."""
        try:
            self.make().sample(bqm, **{**self.parameters, **parameters})
        except InputError as error:
            refusal = str(error)
            assert "\n" not in refusal, "a refusal is one sentence"
            return refusal
        except Exception as error:
            raise AssertionError(f"{parameters}: {error!r} instead of an InputError") from error
        raise AssertionError(f"{type(bqm).__name__} with {parameters} was sampled")

    def test_ends_when_interrupted(self) -> None:
        if "interrupt_function" not in self.make().parameters:
            return
        reads = {"num_reads": 40} if "num_reads" in self.make().parameters else {}
        given = {**self.parameters, **reads, "interrupt_function": lambda: True}
        samples = self.sample(self.small("BINARY"), **given)
        assert 0 < int(samples.record.num_occurrences.sum()) < 40

    def test_knows_its_own_defaults(self) -> None:
        sampler = self.make()
        defaults = sampler.picking_defaults(largest_distance=100.0)
        assert set(defaults) <= set(sampler.parameters)
