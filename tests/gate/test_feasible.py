"""The enumerated plans: complete, right, and the bit strings of the reduced model."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from oracles import least_distance, paper_shaped
from strategies import instances

from qrobot.backends.gate.feasible import all_sequences, feasible_set
from qrobot.errors import BackendError, InfeasibleError
from qrobot.models import build_model
from qrobot.problem import Instance


def plans_by_trying(instance: Instance) -> set[tuple[tuple[int, ...], ...]]:
    """Return all feasible routes of robots, the largest first, in plain Python."""
    n = instance.size
    rooms = sorted((robot.capacity for robot in instance.robots), reverse=True)
    owner = instance.order_of_node
    found = set()
    for symbols in permutations([*range(1, n + 1), *[0] * (len(rooms) - 1)]):
        text, routes = [*symbols, 0], [[]]
        for symbol in text[:-1]:
            if symbol:
                routes[-1].append(symbol)
            else:
                routes.append([])
        loads = [sum(instance.items[v - 1].weight for v in route) for route in routes]
        orders = [{int(owner[v]) for v in route} for route in routes]
        whole = sum(map(len, orders)) == len(set().union(*orders))
        if whole and all(load <= room for load, room in zip(loads, rooms, strict=True)):
            found.add(tuple(map(tuple, routes)))
    return found


@given(instances(max_items=4, max_robots=3))
def test_every_plan_is_there_once(instance: Instance) -> None:
    expected = plans_by_trying(instance)
    if not expected:
        with pytest.raises(InfeasibleError):
            feasible_set(instance)
        return
    found = feasible_set(instance)
    routes = [tuple(map(tuple, found.routes(k))) for k in range(found.size)]
    assert len(routes) == len(set(routes))
    assert set(routes) == expected
    best = least_distance(instance)
    assert best is not None
    assert found.costs.min() == pytest.approx(best[0], abs=1e-6)


@given(instances(min_items=1, max_items=4, max_robots=2, feasible=True))
def test_states_are_the_bit_strings_of_the_model(instance: Instance) -> None:
    found = feasible_set(instance)
    model = build_model(instance, encoding="reduced")
    for k in range(0, found.size, 1 + found.size // 5):
        sample = model.encode(found.routes(k))
        assert found.assignment(k, "exact") == {label for label, value in sample.items() if value}
        assert found.assignment(k) == {
            label for label, value in sample.items() if value and label.startswith("x")
        }
        decoded = model.decode(sample)
        assert decoded.feasible
        assert decoded.distance == pytest.approx(found.costs[k])


@pytest.mark.parametrize("n", range(6))
def test_permutations_are_all_there(n: int) -> None:
    assert sorted(map(tuple, all_sequences(n).tolist())) == sorted(permutations(range(1, n + 1)))


@given(instances(min_items=2, max_items=4, max_robots=3, feasible=True))
def test_an_exchange_is_its_own_inverse(instance: Instance) -> None:
    found = feasible_set(instance)
    length = found.sequences.shape[1]
    for a in range(length):
        for b in range(a + 1, length):
            partner = found.swapped(a, b)
            assert (partner[partner] == np.arange(found.size)).all()
            moved = partner != np.arange(found.size)
            exchanged = found.sequences.copy()
            exchanged[:, [a, b]] = exchanged[:, [b, a]]
            assert (found.sequences[partner[moved]] == exchanged[moved]).all()


def test_nine_items_and_one_robot() -> None:
    found = feasible_set(paper_shaped(9, 1, 0))
    assert found.size == math.factorial(9)
    assert len(found.optimal) % 2 == 0  # both directions


def test_too_many_are_refused_before_they_are_made() -> None:
    with pytest.raises(BackendError, match="too many to enumerate"):
        feasible_set(paper_shaped(12, 1, 0))
