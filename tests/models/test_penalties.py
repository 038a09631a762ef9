"""Weights: safe ones make the best plan the ground state; all are refused when unusable."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from strategies import instances

from qrobot.errors import InfeasibleError, InputError
from qrobot.models import ENCODINGS, Penalties, PickingModel, build_model
from qrobot.problem import DistanceTable, Instance, Item, Node, Order, Robot


def lowest(model: PickingModel) -> tuple[float, dict[str, int]]:
    """Return the least energy of all assignments and one that has it."""
    count = model.num_variables
    low, best = np.inf, np.zeros(count, dtype=np.int8)
    for top in range(0, 2**count, 2**14):
        block = (np.arange(top, min(top + 2**14, 2**count))[:, None] >> np.arange(count)) & 1
        energies = model.bqm.energies((block.astype(np.int8), model.variables))
        if energies.min(initial=np.inf) < low:
            low, best = float(energies.min()), block[int(energies.argmin())]
    return low, dict(zip(model.variables, best.tolist(), strict=True))


@pytest.mark.parametrize("encoding", ENCODINGS)
@settings(max_examples=40)
@given(instance=instances(min_items=1, max_items=3, max_robots=2, multi_trip=True))
def test_with_safe_weights_the_lowest_energy_is_the_least_distance(
    encoding: str, instance: Instance
) -> None:
    # Coarse weights keep the slack, and with it the number of assignments, small.
    coarse = tuple(replace(item, weight=Fraction(round(item.weight))) for item in instance.items)
    instance = replace(instance, items=coarse)
    expected = least_distance(instance)
    assume(expected is not None)
    assert expected is not None
    model = build_model(instance, encoding, penalties=Penalties.safe(instance))
    assume(model.num_variables <= 17)
    energy, sample = lowest(model)
    decoded = model.decode(sample)
    assert energy == pytest.approx(expected[0], abs=1e-6)
    assert decoded.feasible, decoded.violations
    assert decoded.distance == pytest.approx(expected[0], abs=1e-6)


@pytest.mark.parametrize("encoding", ["compact", "reduced"])
@settings(max_examples=25)
@given(instance=instances(min_items=1, max_items=3, max_robots=2))
def test_with_safe_weights_every_violation_costs_more_than_any_plan(
    encoding: str, instance: Instance
) -> None:
    coarse = tuple(replace(item, weight=Fraction(1)) for item in instance.items)
    instance = replace(instance, items=coarse)
    try:
        model = build_model(instance, encoding, penalties=Penalties.safe(instance))
    except InfeasibleError:
        assume(False)
    count = model.num_variables
    assume(count <= 14)
    rows = ((np.arange(2**count)[:, None] >> np.arange(count)) & 1).astype(np.int8)
    energies = model.bqm.energies((rows, model.variables))
    for row in rows[np.argsort(energies)[:30]]:
        decoded = model.decode(dict(zip(model.variables, row.tolist(), strict=True)))
        if not decoded.feasible:
            assert decoded.energy > sum(
                instance.distances[i].max() for i in range(1, instance.size + 1)
            )


def detour_instance() -> Instance:
    """Going over the depot is shorter than going straight: 9 against 2 from item to item."""
    ways = ((0.0, 1.0, 1.0, 1.0), (1.0, 0.0, 9.0, 9.0), (1.0, 9.0, 0.0, 9.0), (1.0, 9.0, 9.0, 0.0))
    return Instance(
        warehouse=DistanceTable(matrix=ways),
        items=tuple(Item(f"i{k}", Fraction(1), Node(k)) for k in (1, 2, 3)),
        orders=tuple(Order(f"i{k}", (f"i{k}",)) for k in (1, 2, 3)),
        robots=(Robot("R1", Fraction(3)), Robot("R2", Fraction(3))),
    )


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_breaking_a_trip_at_the_depot_never_pays(encoding: str) -> None:
    instance = detour_instance()
    weights = Penalties.measured(instance, encoding)
    assert weights.detour == pytest.approx(7.0)
    model = build_model(instance, encoding)
    sample = model.encode([[1, 2], [3]])
    if encoding == "compact":
        return  # covered by the ground states above; the sample below needs a third step
    for t, node in ((1, 1), (2, 0), (3, 2)):
        for other in range(4):
            sample[f"x[{t},{other},1]"] = int(other == node)
    decoded = model.decode(sample)
    assert decoded.feasible
    assert decoded.routes[0] == [1, 2]
    assert decoded.energy >= decoded.distance - 1e-9


def test_the_scale_of_weights_and_distances_does_not_matter() -> None:
    instance = paper_shaped(5, 2, 3)
    heavier = replace(
        instance,
        items=tuple(replace(i, weight=i.weight * 1000) for i in instance.items),
        robots=tuple(replace(r, capacity=r.capacity * 1000) for r in instance.robots),
    )
    for encoding in ENCODINGS:
        assert Penalties.measured(instance, encoding) == Penalties.measured(heavier, encoding)


@pytest.mark.parametrize("encoding", ENCODINGS)
@given(instance=instances(max_items=5))
@settings(max_examples=30)
def test_measured_and_safe_weights_are_usable(encoding: str, instance: Instance) -> None:
    for weights in (Penalties.measured(instance, encoding), Penalties.safe(instance)):
        if instance.size:
            assert weights.step > 0
            assert weights.visit > 0
            assert weights.capacity > 0


def test_some_weights_can_be_replaced() -> None:
    instance = paper_shaped(3, 2, 0)
    model = build_model(instance, "reduced", penalties={"visit": 7.0})
    measured = Penalties.measured(instance, "reduced")
    assert model.penalties == replace(measured, visit=7.0)
    own = Penalties(step=1.0, visit=2.0, capacity=3.0, same_robot=4.0)
    assert build_model(instance, penalties=own).penalties is own


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf"), "much", True])
def test_unusable_weights_are_refused(value: object) -> None:
    with pytest.raises(InputError, match=r"penalties\.visit"):
        build_model(paper_shaped(2, 1, 0), penalties={"visit": value})


def test_unknown_weights_are_refused() -> None:
    with pytest.raises(InputError, match="no weight 'visits'"):
        build_model(paper_shaped(2, 1, 0), penalties={"visits": 1.0})


@given(st.floats(0, 1e6))
def test_any_finite_weight_is_taken(value: float) -> None:
    assert Penalties(step=value, visit=value, capacity=value, same_robot=value).step == value
