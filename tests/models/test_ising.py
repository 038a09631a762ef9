"""Both sign conventions of spins give the energies of the binary model."""

from __future__ import annotations

import itertools

import dimod
import numpy as np
import pytest
from oracles import paper_shaped

from qrobot.models import build_model, to_ising


@pytest.mark.parametrize("encoding", ["compact", "reduced"])
def test_energies_agree_under_both_conventions(encoding: str) -> None:
    model = build_model(paper_shaped(3, 1, 0), encoding)
    rng = np.random.default_rng(0)
    bits = rng.integers(0, 2, (200, model.num_variables))
    expected = model.bqm.energies((bits, model.variables))
    annealer = to_ising(model.bqm)
    gate = to_ising(model.bqm, "gate")
    assert annealer.labels == gate.labels == tuple(model.variables)
    np.testing.assert_allclose(annealer.energies(2 * bits - 1), expected)
    np.testing.assert_allclose(gate.energies(1 - 2 * bits), expected)
    assert np.array_equal(annealer.binaries(2 * bits - 1), bits)
    assert np.array_equal(gate.binaries(1 - 2 * bits), bits)
    np.testing.assert_array_equal(gate.h, -annealer.h)
    np.testing.assert_array_equal(gate.J, annealer.J)
    assert gate.flipped().convention == "annealer"


def test_it_is_dimods_own_spin_form() -> None:
    model = build_model(paper_shaped(2, 2, 0), "reduced")
    h, J, offset = model.bqm.to_ising()
    own = to_ising(model.bqm)
    assert own.offset == pytest.approx(offset)
    for label, field in zip(own.labels, own.h, strict=True):
        assert field == pytest.approx(h[label])
    for row, column, coupling in zip(own.rows, own.columns, own.J, strict=True):
        pair = (own.labels[row], own.labels[column])
        assert coupling == pytest.approx(J.get(pair, J.get(pair[::-1], 0.0)))


def test_spin_models_are_taken_too() -> None:
    bqm = dimod.BinaryQuadraticModel({"a": 0.5, "b": -1.0}, {"ab": 2.0}, 3.0, "SPIN")
    own = to_ising(bqm)
    for spins in itertools.product((-1, 1), repeat=2):
        sample = dict(zip(own.labels, spins, strict=True))
        assert own.energies(np.array(spins)) == pytest.approx(bqm.energy(sample))
