"""Central batches, own sequences: shortest by all permutations, honest where a backend cannot."""

from __future__ import annotations

import dataclasses
import json
import random
from itertools import pairwise, permutations
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import qrobot
from qrobot.backends import Stop
from qrobot.planning import Result, route_each, solve
from qrobot.problem import (
    AisleWarehouse,
    DistanceTable,
    Instance,
    Item,
    Node,
    OpenFloor,
    Order,
    Place,
    Point,
    Robot,
    Slot,
    Warehouse,
)

SCHEMA = json.loads((Path(qrobot.__file__).parent / "plan" / "plan.schema.json").read_text())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
HOUSES: dict[str, Warehouse] = {
    "aisles": AisleWarehouse(aisles=4, slots=6, blocks=2),
    "floor": OpenFloor(),
    "table": DistanceTable(
        tuple(tuple(float((3 * i + 5 * j) % 7 + abs(i - j)) for j in range(9)) for i in range(9))
    ),
}


def question(kind: str, orders: int, seed: int = 0) -> Instance:
    """Return a few orders of one to three items for two robots."""
    rng = random.Random(seed)

    def place() -> Place:
        if kind == "aisles":
            return Slot(rng.randrange(4), rng.randrange(6), rng.randrange(2))
        return (
            Point(rng.randrange(9), rng.randrange(9)) if kind == "floor" else Node(rng.randrange(9))
        )

    items, lots = [], []
    for o in range(orders):
        own = [Item(f"o{o}-{k}", 1, place()) for k in range(rng.randint(1, 3))]
        items += own
        lots.append(Order(f"o{o}", [item.id for item in own]))
    fleet = (Robot("A", 6, trips=3), Robot("B", 5, speed=2.0, trips=3))
    return Instance(HOUSES[kind], tuple(items), tuple(lots), fleet)


def longest_sequences(instance: Instance) -> Result:
    """Return a central plan whose batches are fine and whose sequences are not."""
    central = solve(instance, backend="exact", max_work=10)
    d = instance.distances

    def length(route: tuple[int, ...]) -> float:
        nodes = (0, *route, 0)
        return float(sum(d[a, b] for a, b in pairwise(nodes)))

    routes = [max(permutations(r), key=length) for r in central.plan.routes(instance)]
    plan = qrobot.Plan.from_routes(instance, routes)
    return dataclasses.replace(central, plan=plan, is_optimal=False, bound=0.0)


@settings(max_examples=20, deadline=None)
@given(
    kind=st.sampled_from(sorted(HOUSES)),
    backend=st.sampled_from(["exact", "auto"]),
    orders=st.integers(1, 5),
    seed=st.integers(0, 10**6),
)
def test_own_sequences_are_the_shortest_of_all_permutations(
    kind: str, backend: str, orders: int, seed: int
) -> None:
    instance = question(kind, orders, seed)
    central = longest_sequences(instance)
    found = route_each(central, backend, max_work=50)
    assert qrobot.check(found.plan, instance).ok
    assert found.each_robot is not None
    d = instance.distances
    for before, after, told in zip(
        central.plan.trips, found.plan.trips, found.each_robot.trips, strict=True
    ):
        assert (before.robot, set(before.orders)) == (after.robot, set(after.orders))
        nodes = [
            1 + next(k for k, i in enumerate(instance.items) if i.id == s) for s in after.stops
        ]
        least = min(
            sum(d[a, b] for a, b in zip((0, *way), (*way, 0), strict=True))
            for way in permutations(nodes)
        )
        assert after.distance == pytest.approx(least)
        assert (told.central, told.own) == pytest.approx((before.distance, after.distance))
        assert told.kept == ""
    assert found.each_robot.central == pytest.approx(central.cost)
    assert found.each_robot.cost == pytest.approx(sum(t.distance for t in found.plan.trips))
    VALIDATOR.validate(json.loads(json.dumps(found.to_dict())))


@pytest.mark.parametrize("backend", ["neal", "tabu", "qaoa-grover"])
def test_samplers_tell_what_they_found_by_themselves(backend: str) -> None:
    instance = question("floor", 4, seed=3)
    found = route_each(longest_sequences(instance), backend, max_work=50)
    assert found.each_robot is not None
    for told in found.each_robot.trips:
        assert told.sampler is not None
        assert told.sampler.backend == backend
        assert told.sampler.best is None or told.sampler.best >= told.own - 1e-9
    assert f"sequences by {backend}" in found.summary()
    assert f"({backend} by itself" in found.summary()
    VALIDATOR.validate(json.loads(json.dumps(found.to_dict(), default=str)))


def test_the_model_of_a_trip_has_no_weights_and_one_stop_a_place() -> None:
    """Stops squared: no qubit is spent on a capacity, none on a second item of a place."""
    items = tuple(Item(f"i{k}", 3, Point(k // 2, 1)) for k in range(6))
    orders = (Order("o", [item.id for item in items]),)
    instance = Instance(OpenFloor(), items, orders, (Robot("A", 20),))
    central = solve(instance, backend="exact")
    found = route_each(central, "neal", max_work=20)
    assert found.each_robot is not None
    (told,) = found.each_robot.trips
    assert told.stops == 3
    assert told.sampler is not None
    assert told.sampler.variables == 3 * 3
    assert [len(trip.stops) for trip in found.plan.trips] == [6]


def test_a_trip_that_a_backend_cannot_take_keeps_the_central_sequence() -> None:
    rng = random.Random(1)
    items = tuple(Item(f"i{k}", 1, Point(rng.random(), rng.random())) for k in range(11))
    orders = tuple(Order(item.id, [item.id]) for item in items)
    instance = Instance(OpenFloor(), items, orders, (Robot("A", 8), Robot("B", 3)))
    central = solve(instance, backend="pyvrp", max_work=200)
    found = route_each(central, "statevector", max_work=20)
    assert found.each_robot is not None
    long, short = sorted(found.each_robot.trips, key=lambda told: -told.stops)
    assert (long.stops, short.stops) == (8, 3)
    assert "64 binary variables, backend statevector takes 26" in long.kept
    assert long.own == long.central
    assert (short.kept, short.sampler is not None) == ("", True)
    assert found.plan.trips[long.trip - 1].stops == central.plan.trips[long.trip - 1].stops
    assert "1 of 2 trips kept the central sequence" in found.summary()


def test_what_nobody_could_do_is_refused_at_once() -> None:
    central = longest_sequences(question("aisles", 3))
    for backend, wish, says in (
        ("neal", {"nonsense": 1}, "nonsense"),
        ("exact", {"num_reads": 5}, "takes no option num_reads"),
        ("nobody", {}, "nobody"),
        ("neal", {"deadline": -1}, "deadline"),
    ):
        with pytest.raises(qrobot.InputError, match=says):
            route_each(central, backend, **wish)  # type: ignore[arg-type]
    by_policy = solve(
        dataclasses.replace(
            question("aisles", 3), warehouse=AisleWarehouse(aisles=4, slots=6, blocks=2)
        ),
        routing="combined",
        max_work=20,
    )
    with pytest.raises(qrobot.InputError, match="combined tells the sequences"):
        route_each(by_policy, "exact")


def test_an_interrupt_keeps_the_central_sequences() -> None:
    central = longest_sequences(question("floor", 4))
    stop = Stop()
    stop.request()
    found = route_each(central, "exact", stop=stop)
    assert found.each_robot is not None
    assert {told.kept for told in found.each_robot.trips} == {"interrupted"}
    assert found.plan == central.plan


def test_costs_are_those_of_the_objective_and_robots_keep_their_trips() -> None:
    instance = question("floor", 5, seed=2)
    central = solve(instance, objective="time", backend="exact")
    found = route_each(central, "exact", max_work=50)
    assert [t.robot for t in found.plan.trips] == [t.robot for t in central.plan.trips]
    assert found.cost == pytest.approx(sum(t.seconds for t in found.plan.trips))
    assert found.cost == pytest.approx(central.cost)
    assert found.is_optimal == central.is_optimal


def test_deadlines_keep_a_shorter_central_sequence(monkeypatch: pytest.MonkeyPatch) -> None:
    instance = question("floor", 4, seed=5)
    orders = tuple(dataclasses.replace(order, deadline=1000.0) for order in instance.orders)
    central = solve(dataclasses.replace(instance, orders=orders), backend="auto", max_work=50)

    def worst(asked: Instance, **_: Any) -> Result:
        return longest_sequences(asked)

    monkeypatch.setattr("qrobot.planning.each_robot.solve", worst)
    found = route_each(central, "exact", max_work=10)
    assert found.each_robot is not None
    for told in found.each_robot.trips:
        assert told.own == told.central
    assert any("longer, and orders have deadlines" in told.kept for told in found.each_robot.trips)
