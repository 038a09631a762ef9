"""The QAOA state: objective, derivatives, shots, precision, refusals."""

from __future__ import annotations

import dimod
import numpy as np
import pytest

from qrobot import _jit as jit
from qrobot.backends.gate import ansatz, resources
from qrobot.backends.gate.form import Form, diagonal
from qrobot.backends.gate.state.diagonal import DiagonalQAOA
from qrobot.errors import BackendError, InputError

COMPILED = pytest.mark.skipif(not jit.available(), reason="numba is not installed")
ENGINES = ["numpy", pytest.param("numba", marks=COMPILED)]
GAMMAS, BETAS = np.array([0.3, 0.7, 0.2]), np.array([-0.4, 0.9, 0.1])


def form_of(n: int, seed: int = 0, vartype: str = "BINARY") -> Form:
    bqm = dimod.generators.gnp_random_bqm(n, 0.7, vartype, random_state=seed)
    bqm.offset = 2.5
    return Form.from_bqm(bqm)


@pytest.mark.parametrize("n", [1, 2, 5, 9])
def test_one_layer_has_a_closed_form(n: int) -> None:
    form = form_of(n, n, "SPIN")
    qaoa = DiagonalQAOA(form)
    for gamma, beta in ((0.3, 0.2), (-0.7, 1.1), (2.0, -0.5)):
        expected = ansatz.expectation(form, gamma, beta)
        assert qaoa.value(np.array([gamma]), np.array([beta])) == pytest.approx(expected, abs=1e-9)
    gamma, beta, value = ansatz.best_layer(form)
    grid = [
        ansatz.expectation(form, g / form.spread, b)
        for g in np.linspace(-3, 3, 25)
        for b in np.linspace(-np.pi / 2, np.pi / 2, 25)
    ]
    assert value <= min(grid) + 1e-9
    assert value == pytest.approx(ansatz.expectation(form, gamma, beta), abs=1e-9)


def test_a_constant_needs_no_angles() -> None:
    assert ansatz.best_layer(Form.from_bqm(dimod.BinaryQuadraticModel("BINARY")))[:2] == (0, 0)


@pytest.mark.parametrize("alpha", [1.0, 0.3])
@pytest.mark.parametrize("engine", ENGINES)
def test_derivatives_equal_differences(alpha: float, engine: str) -> None:
    qaoa = DiagonalQAOA(form_of(6, 1), alpha=alpha, engine=engine)
    value, by_gamma, by_beta = qaoa.gradient(GAMMAS, BETAS)
    assert value == pytest.approx(qaoa.value(GAMMAS, BETAS))
    h = 1e-5
    for k, step in enumerate(h * np.eye(3)):
        by_difference = (
            (qaoa.value(GAMMAS + step, BETAS) - qaoa.value(GAMMAS - step, BETAS)) / (2 * h),
            (qaoa.value(GAMMAS, BETAS + step) - qaoa.value(GAMMAS, BETAS - step)) / (2 * h),
        )
        assert (by_gamma[k], by_beta[k]) == pytest.approx(by_difference, abs=1e-6)


@pytest.mark.parametrize("alpha", [0.02, 0.3, 0.9, 1.0])
def test_the_tail_is_that_of_the_sorted_distribution(alpha: float) -> None:
    form = form_of(9, 4)
    qaoa = DiagonalQAOA(form)
    qaoa.run(GAMMAS, BETAS)
    p, costs = np.abs(qaoa.vector()) ** 2, diagonal(form)
    order = np.argsort(costs)
    left, expected = alpha, 0.0
    for k in order:
        part = min(left, p[k])
        expected += part * costs[k]
        left -= part
    assert qaoa.cvar(alpha) == pytest.approx(expected / alpha, abs=1e-4)
    assert qaoa.expectation() == pytest.approx(float(p @ costs), abs=1e-9)


def test_shots_follow_the_probabilities() -> None:
    qaoa = DiagonalQAOA(form_of(5, 2))
    qaoa.run(GAMMAS, BETAS)
    shots = qaoa.sample(200_000, np.random.default_rng(1))
    p = qaoa.probabilities(np.arange(32))
    expected = 200_000 * p
    chi = ((np.bincount(shots, minlength=32) - expected) ** 2 / expected).sum()
    assert chi < 70  # 31 degrees of freedom: about one in 20,000
    assert (
        qaoa.sample(50, np.random.default_rng(3)) == qaoa.sample(50, np.random.default_rng(3))
    ).all()
    assert len(np.unique(np.diff(shots[:100]) > 0)) == 2  # in random sequence, not sorted


def test_shots_reach_every_chunk() -> None:
    qaoa = DiagonalQAOA(form_of(18, 5))
    qaoa.run([0.0], [0.0])
    shots = qaoa.sample(4_000, np.random.default_rng(0))
    assert set(shots >> 16) == {0, 1, 2, 3}
    assert np.unique(shots).size > 3_900


def test_single_precision_says_the_same() -> None:
    form = form_of(12, 6)
    double, single = (DiagonalQAOA(form, precision=p) for p in ("double", "single"))
    assert single.value(GAMMAS, BETAS) == pytest.approx(double.value(GAMMAS, BETAS), rel=1e-4)
    assert single.re.dtype == np.float32
    assert (single.ground == double.ground).all()
    assert single.lowest == pytest.approx(double.lowest, rel=1e-5)


def test_all_lowest_assignments_are_found() -> None:
    bqm = dimod.BinaryQuadraticModel({}, {(k, k + 1): 1.0 for k in range(5)}, 1e6, "SPIN")
    for precision in ("double", "single"):
        qaoa = DiagonalQAOA(Form.from_bqm(bqm), precision=precision)
        assert qaoa.ground.tolist() == [0b010101, 0b101010]


def test_a_state_that_does_not_fit_is_refused_before_it_is_made(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(resources, "available_memory", lambda: 10**9)
    with pytest.raises(BackendError) as refused:
        DiagonalQAOA(form_of(30))
    text = str(refused.value)
    assert "30 qubits" in text
    assert f"{24 << 30:,} bytes" in text
    assert "1,000,000,000 bytes" in text
    monkeypatch.setattr(resources, "available_memory", lambda: 20 << 20)
    DiagonalQAOA(form_of(20), precision="single")
    with pytest.raises(BackendError, match="precision 'single'"):
        DiagonalQAOA(form_of(20))


def test_sizes_are_readable() -> None:
    assert resources.readable(1000) == "1000 bytes"
    assert resources.readable(3 << 29) == "1.5 GiB"
    assert resources.readable(24 << 160) == "10^49 bytes"
    assert resources.available_memory() > 0


@pytest.mark.parametrize(
    ("options", "field"),
    [({"precision": "half"}, "precision"), ({"alpha": 0.0}, "alpha"), ({"alpha": 1.5}, "alpha")],
)
def test_options_out_of_range_are_refused(options: dict, field: str) -> None:
    with pytest.raises(InputError, match=field):
        DiagonalQAOA(form_of(2), **options)


def test_angles_must_be_layers() -> None:
    qaoa = DiagonalQAOA(form_of(2))
    for gammas, betas in (([0.1], []), ([], []), ([float("nan")], [0.1])):
        with pytest.raises(InputError):
            qaoa.run(gammas, betas)
