"""Layers against dense matrix exponentials, compiled against plain, norm, inverse."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot import _jit as jit
from qrobot.backends.gate.state.engine import LayerEngine, make_engine, thread_count
from qrobot.errors import InputError, MissingExtraError

COMPILED = pytest.mark.skipif(not jit.available(), reason="numba is not installed")
ENGINES = ["numpy", pytest.param("numba", marks=COMPILED)]
angles = st.floats(-7.0, 7.0)


def dense_layer(state: np.ndarray, diagonal: np.ndarray, gamma: float, beta: float) -> np.ndarray:
    """Return one layer by the eigenvectors of the sum of all X, a dense matrix."""
    n = state.size.bit_length() - 1
    mixer = np.zeros((state.size, state.size))
    for q in range(n):
        mixer[np.arange(state.size), np.arange(state.size) ^ (1 << q)] += 1.0
    values, vectors = np.linalg.eigh(mixer)
    turned = vectors.T @ (np.exp(-1j * gamma * diagonal) * state)
    return vectors @ (np.exp(-1j * beta * values) * turned)


def arrays(n: int, seed: int, dtype: type = np.float64) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    re, im, diagonal = rng.normal(size=(3, 1 << n))
    norm = np.sqrt((re**2 + im**2).sum())
    return tuple((a).astype(dtype) for a in (re / norm, im / norm, 20 * diagonal))


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("n", range(7))
def test_layers_equal_dense_exponentials(name: str, n: int) -> None:
    engine = make_engine(name)
    re, im, diagonal = arrays(n, n)
    engine.begin(re, im, diagonal, 0.7, -0.4)
    expected = dense_layer(np.full(1 << n, 2 ** (-n / 2) + 0j), diagonal, 0.7, -0.4)
    np.testing.assert_allclose(re + 1j * im, expected, atol=1e-12)
    for gamma, beta in ((-0.3, 2.9), (5.1, 0.2)):
        engine.layer(re, im, diagonal, gamma, beta)
        expected = dense_layer(expected, diagonal, gamma, beta)
    np.testing.assert_allclose(re + 1j * im, expected, atol=1e-12)


@pytest.mark.parametrize("name", ENGINES)
@given(n=st.integers(0, 13), gamma=angles, beta=angles, seed=st.integers(0, 9))
def test_norm_is_kept_and_undo_undoes(
    name: str, n: int, gamma: float, beta: float, seed: int
) -> None:
    engine = make_engine(name)
    re, im, diagonal = arrays(n, seed)
    before = re + 1j * im
    engine.layer(re, im, diagonal, gamma, beta)
    mass, energy = engine.moments(re, im, diagonal)
    assert mass == pytest.approx(1.0, abs=1e-12)
    assert energy == pytest.approx(float((re**2 + im**2) @ diagonal), abs=1e-9)
    engine.undo(re, im, diagonal, gamma, beta)
    np.testing.assert_allclose(re + 1j * im, before, atol=1e-12)


@COMPILED
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("n", [1, 3, 11, 12, 13, 16, 18])
@pytest.mark.parametrize("threads", [1, 2])
def test_compiled_and_plain_agree(dtype: type, n: int, threads: int) -> None:
    near = 1e-12 if dtype is np.float64 else 3e-6
    found = []
    for engine in (make_engine("numba", threads), make_engine("numpy")):
        re, im, diagonal = arrays(n, 5, dtype)
        engine.begin(re, im, diagonal, 0.2, 0.6)
        engine.layer(re, im, diagonal, 0.1, -1.1)
        lr, li, _ = arrays(n, 6, dtype)
        overlap = engine.overlap(lr, li, re, im)
        mass, energy = engine.histogram(re, im, diagonal, -100.0, 0.5, 400)
        found.append((re, im, overlap, mass, energy, *engine.moments(re, im, diagonal)))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=near * 30)


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("n", [1, 4, 7])
def test_overlap_is_the_sum_of_flips(name: str, n: int) -> None:
    lr, li, _ = arrays(n, 1)
    re, im, _ = arrays(n, 2)
    flips = sum((re + 1j * im)[np.arange(1 << n) ^ (1 << q)] for q in range(n))
    expected = np.vdot(lr + 1j * li, flips).imag
    assert make_engine(name).overlap(lr, li, re, im) == pytest.approx(expected, abs=1e-12)


@COMPILED
@pytest.mark.parametrize("qubits", range(12, 31))
def test_passes_cover_every_qubit_once(qubits: int) -> None:
    from qrobot.backends.gate.state.compiled import passes

    how = passes(qubits)
    covered = list(range(how.low))
    for low, bits, width in how.high:
        covered += range(low, low + bits)
        assert width <= 1 << low
    assert covered == list(range(qubits))
    assert len(how.high) <= 1 or qubits > 24


def test_engines_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="is not an engine"):
        make_engine("abacus")
    with pytest.raises(InputError, match="too few"):
        make_engine("numpy", 0)
    assert thread_count(None) >= 1
    monkeypatch.setattr(jit, "available", lambda: False)
    engine: LayerEngine = make_engine("auto")
    assert engine.name == "numpy"
    with pytest.raises(MissingExtraError, match="pip install"):
        make_engine("numba")
