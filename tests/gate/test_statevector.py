"""The sampler: dimod's own tests, refusals, determinism, what it reports."""

from __future__ import annotations

from typing import ClassVar

import dimod
import numpy as np
import pytest

from qrobot import _jit as jit
from qrobot.backends.gate import resources
from qrobot.backends.gate.statevector import StatevectorSampler
from qrobot.backends.testing import SamplerConformance
from qrobot.errors import BackendError, InputError

COMPILED = pytest.mark.skipif(not jit.available(), reason="numba is not installed")
ENGINES = ["numpy", pytest.param("numba", marks=COMPILED)]


class TestStatevector(SamplerConformance):
    def make(self) -> StatevectorSampler:
        return StatevectorSampler()


@pytest.mark.slow
class TestStatevectorDeep(SamplerConformance):
    parameters: ClassVar[dict[str, object]] = {"layers": 3, "alpha": 0.2, "precision": "single"}

    def make(self) -> StatevectorSampler:
        return StatevectorSampler()


@pytest.fixture
def bqm() -> dimod.BinaryQuadraticModel:
    return dimod.generators.gnp_random_bqm(8, 0.6, "SPIN", random_state=1)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("precision", ["double", "single"])
def test_the_ground_is_found(bqm: dimod.BinaryQuadraticModel, engine: str, precision: str) -> None:
    found = StatevectorSampler().sample(
        bqm, seed=1, layers=2, alpha=0.2, engine=engine, precision=precision
    )
    least = dimod.ExactSolver().sample(bqm).first.energy
    assert found.first.energy == pytest.approx(least)
    assert len(found) == 1000
    info = found.info
    assert info["ground_energy"] == pytest.approx(least, rel=1e-5)
    assert info["ground_probability_uniform"] == 1 / 256
    assert info["ground_probability"] > 5 / 256
    hits = float(np.mean(found.record.energy <= least + 1e-9))
    assert hits == pytest.approx(info["ground_probability"], abs=0.06)
    assert set(info["timing"]) == {"build", "search", "run", "sample"}
    assert info["evaluations"] == len(info["history"]) <= 40


def test_one_seed_gives_one_set(bqm: dimod.BinaryQuadraticModel) -> None:
    first, again, other = (
        StatevectorSampler().sample(bqm, num_reads=50, seed=s).record.sample for s in (3, 3, 4)
    )
    assert (first == again).all()
    assert (first != other).any()


def test_given_angles_are_taken(bqm: dimod.BinaryQuadraticModel) -> None:
    found = StatevectorSampler().sample(bqm, evaluations=0, gammas=[0.1], betas=[-0.2])
    assert found.info["gammas"] == pytest.approx([0.1])
    assert found.info["betas"] == pytest.approx([-0.2])
    assert found.info["evaluations"] == 0


def test_options_are_checked(bqm: dimod.BinaryQuadraticModel) -> None:
    for options in (
        {"num_reads": 0},
        {"gammas": [0.1]},
        {"layers": 0},
        {"alpha": 2.0},
        {"engine": "abacus"},
        {"precision": "half"},
    ):
        with pytest.raises(InputError):
            StatevectorSampler().sample(bqm, **options)


def test_models_that_cannot_be_sampled_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    sampler = StatevectorSampler()
    with pytest.raises(InputError, match="not a finite number"):
        sampler.sample(dimod.BinaryQuadraticModel({"a": float("nan")}, {}, 0.0, "BINARY"))

    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("allocated before the refusal")

    monkeypatch.setattr(resources, "aligned", forbidden)
    big = dimod.BinaryQuadraticModel(dict.fromkeys(range(50), 1.0), {}, 0.0, "BINARY")
    with pytest.raises(BackendError, match=r"50 qubits.* bytes"):
        sampler.sample(big)


def test_a_constant_model_has_its_offset() -> None:
    empty = dimod.BinaryQuadraticModel({}, {}, 2.5, "SPIN")
    found = StatevectorSampler().sample(empty, num_reads=3)
    assert len(found) == 3
    assert set(found.record.energy) == {2.5}


def test_an_interrupt_ends_the_search_and_the_shots(bqm: dimod.BinaryQuadraticModel) -> None:
    asked = []

    def after_three() -> bool:
        asked.append(1)
        return len(asked) > 3

    found = StatevectorSampler().sample(bqm, layers=2, interrupt_function=after_three)
    assert found.info["evaluations"] == 3
    assert len(found) == 250
