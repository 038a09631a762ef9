"""Energies of all assignments, Ising form, sign conventions, refusals."""

from __future__ import annotations

import dimod
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qrobot.backends.gate.form import Form, bits_of, diagonal
from qrobot.errors import InputError

numbers = st.integers(-40, 40).map(lambda quarters: quarters / 4)


@st.composite
def models(draw: st.DrawFn, most: int = 10) -> dimod.BinaryQuadraticModel:
    n = draw(st.integers(0, most))
    kind = draw(st.sampled_from([dimod.Float64BQM, dimod.Float32BQM, dimod.DictBQM]))
    vartype = draw(st.sampled_from(["SPIN", "BINARY"]))
    linear = {f"v{k}": draw(numbers) for k in range(n)}
    pairs = [(a, b) for a in range(n) for b in range(a)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=12)) if pairs else []
    quadratic = {(f"v{a}", f"v{b}"): draw(numbers) for a, b in chosen}
    return kind(linear, quadratic, draw(numbers), vartype)


@given(models())
def test_energies_equal_dimods_on_every_assignment(bqm: dimod.BinaryQuadraticModel) -> None:
    form = Form.from_bqm(bqm)
    every = bits_of(np.arange(1 << form.qubits), form.qubits)
    samples = 2 * every - 1 if bqm.vartype is dimod.SPIN else every
    expected = np.array([float(bqm.offset)])
    if form.qubits:
        expected = np.asarray(bqm.energies((samples, list(form.variables))), dtype=float)
    np.testing.assert_allclose(diagonal(form), expected, atol=1e-9)
    np.testing.assert_allclose(form.energies(every), expected, atol=1e-9)
    np.testing.assert_allclose(diagonal(form, np.float32, 3.0), expected - 3.0, atol=1e-4)
    assert form.mean == pytest.approx(expected.mean(), abs=1e-9)
    assert form.spread == pytest.approx(expected.std(), abs=1e-9)


@given(models(6))
def test_the_ising_form_has_z_plus_one_on_zero(bqm: dimod.BinaryQuadraticModel) -> None:
    form = Form.from_bqm(bqm)
    h, J, constant = form.ising
    z = 1.0 - 2.0 * bits_of(np.arange(1 << form.qubits), form.qubits)
    energies = constant + z @ h + ((z @ J) * z).sum(axis=1) / 2
    np.testing.assert_allclose(energies, diagonal(form), atol=1e-9)


def test_blocks_of_the_diagonal_fit_together() -> None:
    form = Form.from_bqm(dimod.generators.gnp_random_bqm(17, 0.8, "SPIN", random_state=3))
    rng = np.random.default_rng(0)
    indices = rng.integers(0, 1 << 17, 500)
    np.testing.assert_allclose(
        diagonal(form)[indices], form.energies(bits_of(indices, 17)), atol=1e-9
    )


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_numbers_that_are_none_are_refused(bad: float) -> None:
    for bqm in (
        dimod.BinaryQuadraticModel({"a": bad}, {}, 0.0, "BINARY"),
        dimod.BinaryQuadraticModel({}, {("a", "b"): bad}, 0.0, "SPIN"),
        dimod.BinaryQuadraticModel({"a": 1.0}, {}, bad, "BINARY"),
    ):
        with pytest.raises(InputError, match="not a finite number"):
            Form.from_bqm(bqm)


def test_index_bits_are_lowest_first() -> None:
    assert bits_of([6], 4).tolist() == [[0, 1, 1, 0]]
