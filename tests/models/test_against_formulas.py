"""The models against the paper's tables and against the formulas written out as loops."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import dimod
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import least_distance, paper_shaped
from strategies import instances

from qrobot.errors import InfeasibleError
from qrobot.models import ENCODINGS, Penalties, build_model
from qrobot.planning.run import plan_fits
from qrobot.problem import Instance, Robot

# Items, capacity and qubits as printed in the paper: table 1 (full), tables 2 and 3 (reduced).
TABLE_1 = [18, 26, 36, 48, 62, 78, 96, 116, 138, 162, 188]
TABLE_2 = [10, 16, 24, 34, 46, 60, 76, 94, 115, 137, 161]


def light(items: int, robots: int, capacity: int) -> Instance:
    """Items of one kilogram, so that only the shape of the model is looked at."""
    drawn = paper_shaped(items, robots, 0)
    return replace(
        drawn,
        items=tuple(replace(item, weight=Fraction(1)) for item in drawn.items),
        robots=tuple(Robot(f"R{k + 1}", Fraction(capacity)) for k in range(robots)),
    )


@pytest.mark.parametrize("slack", ["exact", "paper"])
@pytest.mark.parametrize(("items", "qubits"), list(zip(range(2, 13), TABLE_1, strict=True)))
def test_the_full_encoding_has_the_qubits_of_table_1(items: int, qubits: int, slack: str) -> None:
    model = build_model(light(items, 1, 45), "full", slack=slack)
    assert model.num_variables == qubits == len(model.bqm.variables)


@pytest.mark.parametrize("slack", ["exact", "paper"])
@pytest.mark.parametrize(("items", "qubits"), list(zip(range(2, 13), TABLE_2, strict=True)))
def test_the_reduced_encoding_has_the_qubits_of_tables_2_and_3(
    items: int, qubits: int, slack: str
) -> None:
    capacity = 15 if items <= 9 else 25
    model = build_model(light(items, 1, capacity), "reduced", slack=slack)
    assert model.num_variables == qubits == len(model.bqm.variables)


def test_two_robots_and_nine_items_have_188_qubits() -> None:
    assert build_model(light(9, 2, 15), "reduced").num_variables == 188


def formula(
    instance: Instance, weights: Penalties, bits: list[int], sample: dict[str, int]
) -> float:
    """The corrected formulas of the paper, term by term, for the reduced encoding."""
    n, robots = instance.size, len(instance.robots)
    d = instance.distances
    room = int(instance.vehicle_capacities[0])

    def x(t: int, i: int, p: int) -> int:
        if t in (0, n + 1):  # the depot layers are constant
            return int(i == 0)
        return sample[f"x[{t},{i},{p}]"]

    energy = 0.0
    for p in range(1, robots + 1):
        for t in range(1, n + 2):
            for i in range(n + 1):
                for j in range(n + 1):
                    energy += d[i, j] * x(t - 1, i, p) * x(t, j, p)
        for t in range(1, n + 1):
            energy += weights.step * (sum(x(t, i, p) for i in range(n + 1)) - 1) ** 2
        load = sum(
            int(instance.weights[i - 1]) * x(t, i, p)
            for t in range(1, n + 1)
            for i in range(1, n + 1)
        )
        slack = sum(c * sample[f"slack[{p},{b}]"] for b, c in enumerate(bits))
        energy += weights.capacity * (load + slack - room) ** 2
    for i in range(1, n + 1):
        visits = sum(x(t, i, p) for p in range(1, robots + 1) for t in range(1, n + 1))
        energy += weights.visit * (visits - 1) ** 2
    return energy


def test_energies_are_the_formulas_on_all_assignments() -> None:
    instance = light(2, 1, 5)
    model = build_model(instance, "reduced")
    names = model.variables
    slack = [name for name in names if name.startswith("slack")]
    first = int(slack[0].split(",")[1].rstrip("]"))
    renamed = {name: f"slack[1,{int(name.split(',')[1].rstrip(']')) - first}]" for name in slack}
    for values in itertools.product((0, 1), repeat=len(names)):
        sample = dict(zip(names, values, strict=True))
        looked_up = {renamed.get(name, name): value for name, value in sample.items()}
        expected = formula(instance, model.penalties, [1, 2, 2], looked_up)
        assert model.bqm.energy(sample) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("encoding", ENCODINGS)
@settings(max_examples=60)
@given(instance=instances(min_items=1, max_items=5, max_robots=3), data=st.data())
def test_the_energy_of_a_plan_is_its_distance(
    encoding: str, instance: Instance, data: st.DataObject
) -> None:
    """And decoding what was encoded gives the same routes."""
    rooms = instance.vehicle_capacities.tolist()
    routes: list[list[int]] = [[] for _ in rooms]
    for order in data.draw(st.permutations(range(len(instance.orders)))):
        weight = int(instance.order_weights[order])
        fitting = [k for k, room in enumerate(rooms) if room >= weight]
        if not fitting:
            return
        seat = data.draw(st.sampled_from(fitting))
        rooms[seat] -= weight
        routes[seat] += instance.order_nodes[order]
    routes = [data.draw(st.permutations(route)) for route in routes]
    assert plan_fits(instance, [list(route) for route in routes if route])
    try:
        model = build_model(instance, encoding)
    except InfeasibleError:
        raise AssertionError("a plan exists") from None
    sample = model.encode(routes)
    distance = instance.length(routes)
    assert model.bqm.energy(sample) == pytest.approx(distance, abs=1e-6)
    decoded = model.decode(sample)
    assert decoded.feasible, decoded.violations
    assert decoded.distance == pytest.approx(distance, abs=1e-9)
    driven = sorted(map(tuple, filter(None, decoded.routes)))
    assert driven == sorted(map(tuple, filter(None, routes)))
    samples = dimod.SampleSet.from_samples_bqm(sample, model.bqm)
    feasible, costs = model.decode_all(samples)
    assert feasible.tolist() == [True]
    assert costs[0] == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_random_samples_are_judged_alike_one_by_one_and_together(encoding: str) -> None:
    model = build_model(paper_shaped(4, 2, 1), encoding)
    rng = np.random.default_rng(3)
    rows = (rng.random((200, model.num_variables)) < 0.2).astype(np.int8)
    samples = dimod.SampleSet.from_samples_bqm((rows, model.variables), model.bqm)
    feasible, costs = model.decode_all(samples)
    for row, good, cost in zip(samples.record.sample, feasible, costs, strict=True):
        decoded = model.decode(dict(zip(samples.variables, row.tolist(), strict=True)))
        assert decoded.feasible == bool(good)
        if good:
            assert decoded.distance == pytest.approx(cost)
        else:
            assert all(violation.text for violation in decoded.violations)


def test_with_safe_penalties_the_ground_state_is_an_optimal_plan() -> None:
    instance = paper_shaped(3, 1, 0)
    model = build_model(instance, "compact", penalties=Penalties.safe(instance))
    ground = dimod.ExactSolver().sample(model.bqm).first
    decoded = model.decode(ground.sample)
    expected = least_distance(instance)
    assert expected is not None
    assert decoded.feasible
    assert ground.energy == pytest.approx(expected[0])
    assert decoded.distance == pytest.approx(expected[0])
