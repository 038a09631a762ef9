"""The search for angles and the two optimisers below it."""

from __future__ import annotations

from collections.abc import Callable

import dimod
import numpy as np
import pytest

from qrobot.backends.gate.algorithms import bfgs, nelder_mead
from qrobot.backends.gate.ansatz import ramp
from qrobot.backends.gate.form import Form
from qrobot.backends.gate.optimisers import Evaluations, Found
from qrobot.backends.gate.state.diagonal import DiagonalQAOA
from qrobot.backends.gate.tune import sharpen, tune
from qrobot.errors import InputError


def valley(x: np.ndarray) -> float:
    return float((x[0] - 1) ** 2 + 10 * (x[1] - x[0] ** 2) ** 2)


def slope(x: np.ndarray) -> tuple[float, np.ndarray]:
    rest = x[1] - x[0] ** 2
    return valley(x), np.array([2 * (x[0] - 1) - 40 * x[0] * rest, 20 * rest])


def by_simplex(value: Callable[[np.ndarray], float], budget: int) -> Found:
    start = np.array([-1.0, 1.5])
    with Evaluations(value, start, budget=budget) as runs:
        nelder_mead(runs.value, start, np.array([0.3, 0.3]))
    return runs.found


def by_gradients(slope: Callable[[np.ndarray], object], budget: int, **more: float) -> Found:
    start = np.array([-1.0, 1.5])
    with Evaluations(valley, start, budget=budget, slope=slope) as runs:
        bfgs(runs.slope, start, **more)
    return runs.found


def test_both_optimisers_walk_down_a_valley() -> None:
    assert by_simplex(valley, 300).parameters == pytest.approx([1, 1], abs=1e-2)
    found = by_gradients(slope, 100, tolerance=1e-12)
    assert found.parameters == pytest.approx([1, 1], abs=1e-4)
    assert found.value == min(found.history) == valley(found.parameters)


@pytest.mark.parametrize("budget", [1, 2, 3, 7, 20])
def test_budgets_are_kept(budget: int) -> None:
    calls = []

    def counted(x: np.ndarray) -> float:
        calls.append(x)
        return valley(x)

    found = by_simplex(counted, budget)
    assert len(calls) == len(found.history) <= budget
    assert len(by_gradients(slope, budget).history) <= budget


def test_a_flat_function_ends_at_once() -> None:
    assert len(by_gradients(lambda x: (3.0, np.zeros_like(x)), 99).history) == 1
    assert len(by_simplex(lambda _: 3.0, 99).history) == 3


@pytest.fixture
def qaoa() -> DiagonalQAOA:
    bqm = dimod.generators.gnp_random_bqm(8, 0.6, "SPIN", random_state=2)
    return DiagonalQAOA(Form.from_bqm(bqm))


def test_more_layers_are_better(qaoa: DiagonalQAOA) -> None:
    values = [tune(qaoa, p, evaluations=80).value for p in (1, 2, 4)]
    assert values[0] > values[1] > values[2]
    assert values[0] < qaoa.form.mean


def test_one_layer_beats_a_grid(qaoa: DiagonalQAOA) -> None:
    found = tune(qaoa, 1)
    for g in np.linspace(0.1, 3, 12):
        for b in np.linspace(-np.pi / 2, np.pi / 2, 24):
            assert found.value <= qaoa.value(np.array([g / qaoa.spread]), np.array([b])) + 1e-3


@pytest.mark.parametrize("layers", [1, 3])
@pytest.mark.parametrize("budget", [0, 1, 5, 17])
def test_evaluations_are_a_limit(qaoa: DiagonalQAOA, layers: int, budget: int) -> None:
    before = qaoa.runs
    found = tune(qaoa, layers, evaluations=budget)
    # A ramp needs one look at least, to have anything to return.
    assert qaoa.runs - before <= max(budget, 5 if layers > 1 else 0)
    assert len(found.gammas) == len(found.betas) == layers
    assert found.evaluations == len(found.history)


def test_a_start_is_taken(qaoa: DiagonalQAOA) -> None:
    found = tune(qaoa, 2, evaluations=0, start=([0.1, 0.2], [-0.3, -0.1]))
    assert found.gammas == pytest.approx((0.1, 0.2))
    assert found.betas == pytest.approx((-0.3, -0.1))
    with pytest.raises(InputError, match="do not make"):
        tune(qaoa, 2, start=([0.1], [0.2]))
    with pytest.raises(InputError, match="too few"):
        tune(qaoa, 0)


def test_a_ramp_rises_and_falls() -> None:
    gammas, betas = ramp(4, 0.8, -0.4)
    assert gammas == pytest.approx([0.1, 0.3, 0.5, 0.7])
    assert betas == pytest.approx([-0.35, -0.25, -0.15, -0.05])


def test_sharpening_finds_the_optimum_more_often(qaoa: DiagonalQAOA) -> None:
    def ground(gammas: tuple[float, ...], betas: tuple[float, ...]) -> float:
        qaoa.run(gammas, betas)
        return float(qaoa.probabilities(qaoa.ground).sum())

    mean, sharp = tune(qaoa, 2), sharpen(qaoa, 2)
    assert ground(sharp.gammas, sharp.betas) >= ground(mean.gammas, mean.betas)
    assert qaoa.alpha == 1.0
    assert sharp.evaluations > mean.evaluations
