"""Mixers against dense exponentials, the ansatz and its derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import paper_shaped

from qrobot.backends.gate import resources
from qrobot.backends.gate.feasible import FeasibleSet, feasible_set
from qrobot.backends.gate.state.subspace import (
    GroverMixer,
    Mixer,
    OneHotMixer,
    SubspaceQAOA,
    SwapMixer,
    expected_best,
    one_hot,
    transpositions,
)
from qrobot.errors import BackendError, InputError

GAMMAS, BETAS = np.array([0.02, 0.05]), np.array([-0.8, 0.6])


def exponential(hermitian: np.ndarray, beta: float) -> np.ndarray:
    values, vectors = np.linalg.eigh(hermitian)
    return (vectors * np.exp(-1j * beta * values)) @ vectors.conj().T


def random_state(size: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    state = rng.normal(size=size) + 1j * rng.normal(size=size)
    return state / np.linalg.norm(state)


@pytest.fixture(params=[(4, 1), (3, 2), (4, 2)], ids=lambda p: f"n{p[0]}K{p[1]}")
def plans(request: pytest.FixtureRequest) -> FeasibleSet:
    return feasible_set(paper_shaped(*request.param, 1))


@pytest.mark.parametrize("pairs", ["adjacent", "all"])
def test_swaps_are_exponentials_of_exchanges(plans: FeasibleSet, pairs: str) -> None:
    state = random_state(plans.size)
    expected = state
    for a, b in transpositions(plans.sequences.shape[1], pairs):
        exchange = np.eye(plans.size)[plans.swapped(a, b)]
        expected = exponential(exchange, 0.7) @ expected
    found = SwapMixer.of(plans, pairs).apply(state.copy(), 0.7)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_pairs_of_positions() -> None:
    assert transpositions(4) == [(0, 1), (2, 3), (1, 2)]
    assert len(transpositions(5, "all")) == 10


def test_grover_is_the_exponential_of_a_projector() -> None:
    start, state = random_state(20, 1), random_state(20, 2)
    expected = exponential(np.outer(start, start.conj()), 1.3) @ state
    np.testing.assert_allclose(GroverMixer(start).apply(state.copy(), 1.3), expected, atol=1e-12)


@pytest.mark.parametrize("nodes", [2, 3, 4])
def test_xy_is_a_product_of_hops_in_every_step(nodes: int) -> None:
    one = np.eye(nodes, dtype=complex)
    for a, b in OneHotMixer.pairs(nodes):
        hop = np.zeros((nodes, nodes))
        hop[a, b] = hop[b, a] = 1.0
        one = exponential(hop, 0.4) @ one
    state = random_state(nodes**2)
    found = OneHotMixer(nodes, 2).apply(state.copy(), 0.4)
    np.testing.assert_allclose(found, np.kron(one, one) @ state, atol=1e-12)


def ansatzes() -> list[SubspaceQAOA]:
    made = [SubspaceQAOA.of(feasible_set(paper_shaped(4, 2, 1)), m) for m in ("swap", "grover")]
    return [*made, one_hot(paper_shaped(4, 1, 2).distances, 30.0)[0]]


@pytest.mark.parametrize("kind", [0, 1, 2])
@pytest.mark.parametrize("alpha", [1.0, 0.4])
def test_derivatives_equal_differences(kind: int, alpha: float) -> None:
    qaoa = ansatzes()[kind]
    qaoa.alpha = alpha
    value, by_gamma, by_beta = qaoa.gradient(GAMMAS, BETAS)
    assert value == pytest.approx(qaoa.value(GAMMAS, BETAS))
    assert np.abs(qaoa.state(GAMMAS, BETAS) ** 2).sum() == pytest.approx(1.0, abs=1e-12)
    h = 1e-6
    for k, step in enumerate(h * np.eye(2)):
        up, down = qaoa.value(GAMMAS + step, BETAS), qaoa.value(GAMMAS - step, BETAS)
        assert by_gamma[k] == pytest.approx((up - down) / (2 * h), rel=1e-4, abs=1e-3)
        up, down = qaoa.value(GAMMAS, BETAS + step), qaoa.value(GAMMAS, BETAS - step)
        assert by_beta[k] == pytest.approx((up - down) / (2 * h), rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_every_mixer_undoes_itself(kind: int) -> None:
    mixer: Mixer = ansatzes()[kind].mixer
    state = random_state(len(ansatzes()[kind].costs))
    there = mixer.apply(state.copy(), 0.9)
    back, _, _ = mixer.slope(there, there.copy(), 0.9)
    np.testing.assert_allclose(back, state, atol=1e-12)


def test_one_hot_tours_cost_their_distance() -> None:
    instance = paper_shaped(4, 1, 3)
    qaoa, tours = one_hot(instance.distances, 50.0)
    plans = feasible_set(instance)
    assert tours.sum() == plans.size
    assert sorted(qaoa.costs[tours]) == pytest.approx(sorted(plans.costs))
    assert len(qaoa.costs) == 4**4


def test_the_expected_best_of_shots() -> None:
    rng = np.random.default_rng(0)
    costs, p = np.array([3.0, 1.0, 2.0, 1.0]), np.array([0.4, 0.1, 0.3, 0.2])
    drawn = rng.choice(costs, p=p, size=(200_000, 3)).min(axis=1).mean()
    assert expected_best(costs, p, 3) == pytest.approx(drawn, abs=0.01)
    assert expected_best(costs, p, 1) == pytest.approx(float(costs @ p))
    assert expected_best(costs, p, 10_000) == pytest.approx(1.0)


def test_options_are_checked() -> None:
    plans = feasible_set(paper_shaped(3, 1, 0))
    with pytest.raises(InputError, match="is not a mixer"):
        SubspaceQAOA.of(plans, "blender")
    with pytest.raises(InputError, match="alpha"):
        SubspaceQAOA.of(plans, alpha=2.0)


def test_states_that_do_not_fit_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    plans = feasible_set(paper_shaped(4, 1, 0))
    monkeypatch.setattr(resources, "available_memory", lambda: 1_000)
    with pytest.raises(BackendError, match="24 states"):
        SubspaceQAOA.of(plans)
    with pytest.raises(BackendError, match="256 states"):
        one_hot(paper_shaped(4, 1, 0).distances, 1.0)
    with pytest.raises(BackendError, match="24 sequences"):
        feasible_set(paper_shaped(4, 1, 0))
