"""Rows of tables: what they say is what the states say; the figures of the issue."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import dimod
import numpy as np
import pytest
from oracles import paper_shaped

from benchmarks.gate_row import (
    GateRow,
    grover_row,
    one_hot_row,
    paper_qubits,
    penalty_row,
    subspace_row,
)
from qrobot.backends.gate import feasible_set
from qrobot.errors import InputError
from qrobot.models import PickingModel, build_model
from qrobot.problem import Instance


def penalty_model(instance: Instance) -> PickingModel:
    step = 2.0 * float(instance.distances.max())
    weights = {"step": step, "visit": step, "capacity": step / 20}
    return build_model(instance, encoding="reduced", slack="paper", penalties=weights)


def whole(instance: Instance) -> Instance:
    return replace(instance, warehouse=replace(instance.warehouse, rounding="nearest"))


def paper_row(items: int) -> Instance:
    """Return a row of table 2: one robot of M = 15, weights that fit and have no common unit."""
    instance = paper_shaped(items, 1, 0)
    light = tuple(
        replace(item, weight=weight)
        for item, weight in zip(instance.items, (2, 1, 2, 1, 1, 1, 2, 1, 1), strict=False)
    )
    return replace(instance, items=light, robots=(replace(instance.robots[0], capacity=15),))


@pytest.mark.parametrize(("items", "qubits"), [(2, 10), (3, 16), (4, 24), (5, 34), (9, 94)])
def test_qubits_are_the_papers(items: int, qubits: int) -> None:
    assert paper_qubits(paper_row(items)) == qubits


@pytest.mark.parametrize(("items", "robots"), [(2, 1), (3, 1), (2, 2)])
def test_a_penalty_row_is_what_shots_say(items: int, robots: int) -> None:
    from qrobot.backends.gate.statevector import StatevectorSampler

    instance = paper_row(items) if robots == 1 else paper_shaped(items, robots, 0)
    model = penalty_model(instance)
    row = penalty_row(model)
    assert row.qubits == model.num_variables
    assert row.states == 1 << model.num_variables
    assert row.gain > 2
    gammas = [g / dimod_spread(model) for g in row.gammas]
    found = StatevectorSampler().sample(
        model.bqm, num_reads=200_000, seed=0, evaluations=0, gammas=gammas, betas=row.betas
    )
    reads = model.decode_all(found)
    # Reads may wait at the depot on the way and still be feasible: no fewer than the row says.
    if robots == 1:
        assert reads.feasible.mean() == pytest.approx(row.feasible, rel=0.15, abs=2e-4)
    else:
        assert reads.feasible.mean() >= row.feasible * 0.85
    plans = feasible_set(instance)
    wanted = {
        tuple(model.encode_bits(plans.routes(int(k))).tolist()) for k in plans.optimal.tolist()
    }
    hits = np.mean([tuple(one) in wanted for one in model.matrix(found).tolist()])
    assert hits == pytest.approx(row.probability, rel=0.2, abs=1e-4)
    assert row.uniform == len(wanted) / row.states


def dimod_spread(model: PickingModel) -> float:
    exact = dimod.ExactSolver().sample(model.bqm)
    return float(exact.record.energy.std())


def consistent(row: GateRow) -> None:
    assert 0 < row.probability <= row.feasible <= 1 + 1e-9
    assert row.distance - 1e-9 <= row.mean
    assert row.seen == pytest.approx(1 - (1 - row.probability) ** row.shots)
    if row.best is not None and row.best_uniform is not None:
        assert row.distance - 1e-9 <= row.best <= row.best_uniform + 1e-9
    plain = row.as_dict()
    assert plain["gain"] == row.gain
    assert len(plain["gammas"]) == row.layers


@pytest.mark.parametrize("mixer", ["swap", "swap-all", "grover"])
@pytest.mark.parametrize(("items", "robots"), [(5, 1), (4, 2), (5, 3)])
def test_rows_within_the_constraints(mixer: str, items: int, robots: int) -> None:
    row = subspace_row(paper_shaped(items, robots, 0), mixer, layers=2)
    consistent(row)
    assert row.feasible == 1.0
    assert row.gain > 1.3


def test_angles_carry_over_to_the_next_row() -> None:
    before = subspace_row(paper_row(5), layers=3)
    after = subspace_row(
        paper_row(6), layers=3, start=(before.gammas, before.betas), evaluations=1, alphas=(1.0,)
    )
    assert after.evaluations == 1
    assert after.gain > 3


def test_a_one_hot_row() -> None:
    row = one_hot_row(paper_row(4))
    consistent(row)
    assert row.states == 4**4
    assert row.feasible > row.feasible_uniform
    with pytest.raises(InputError, match="one robot"):
        one_hot_row(paper_shaped(3, 2, 0))


def test_counted_rows_equal_enumerated_ones() -> None:
    instance = whole(paper_shaped(6, 1, 0))
    counted = grover_row(instance, layers=2, alphas=(1.0,), evaluations=60)
    listed = subspace_row(instance, "grover", layers=2, alphas=(1.0,), evaluations=60)
    consistent(counted)
    for field in ("states", "uniform", "distance", "best_uniform"):
        assert getattr(counted, field) == pytest.approx(getattr(listed, field))
    assert counted.probability == pytest.approx(listed.probability, rel=1e-3)


def test_other_encodings_have_no_penalty_row() -> None:
    with pytest.raises(InputError, match="no row"):
        penalty_row(build_model(paper_row(2)))


# -- the figures of issue 3 ----------------------------------------------------------------


def in_a_minute(make: Callable[[], GateRow]) -> GateRow:
    """Return what is made in a minute of this process, whatever else the machine does."""
    begun = time.process_time()
    made = make()
    assert time.process_time() - begun <= 60
    return made


@pytest.mark.slow
@pytest.mark.figure
def test_figure_24_qubits_in_a_minute() -> None:
    row = in_a_minute(lambda: penalty_row(penalty_model(paper_row(4))))
    assert row.qubits == 24
    assert row.gain >= 10


@pytest.mark.slow
@pytest.mark.figure
@pytest.mark.parametrize("items", range(5, 10))
def test_figure_rows_five_to_nine(items: int) -> None:
    row = in_a_minute(lambda: subspace_row(paper_row(items), layers=1))
    consistent(row)
    assert row.states == np.prod(range(1, items + 1))


@pytest.mark.parametrize("items", [10, 11, 12])
def test_figure_rows_ten_to_twelve(items: int) -> None:
    row = in_a_minute(lambda: grover_row(whole(paper_shaped(items, 1, 0)), layers=4))
    consistent(row)
    assert row.gain > 20
