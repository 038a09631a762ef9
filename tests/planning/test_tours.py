"""The trips of a plan in aisles are shortest tours, whatever backend dealt the orders out."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from tours import random_aisles, random_slot, shortest_way

import qrobot
from qrobot.backends import Capabilities, Search, Stop
from qrobot.errors import InputError
from qrobot.problem import Instance, Item, Order, Robot


class InFileOrder:
    """A backend whose trips take two orders each and pass the items as the file has them."""

    name = "in-file-order"
    capabilities = Capabilities(kind="planner")

    def search(self, instance: Instance, *, stop: Stop, seed: int, **_: Any) -> Search:
        nodes = instance.order_nodes
        trips = [[*nodes[k], *(nodes[k + 1] if k + 1 < len(nodes) else ())]
                 for k in range(0, len(nodes), 2)]  # fmt: skip
        return Search(routes=trips)


def instance_of(seed: int) -> Instance | None:
    """Return four orders of two items in a random layout; None where not all can be reached."""
    rng = np.random.default_rng(seed)
    house = random_aisles(rng, int(rng.integers(1, 4)), most=5)
    items = tuple(Item(f"{k}", 1, random_slot(rng, house)) for k in range(8))
    orders = tuple(Order(f"{o}", (f"{2 * o}", f"{2 * o + 1}")) for o in range(4))
    try:
        instance = Instance(
            warehouse=house, items=items, orders=orders, robots=(Robot("R1", 4, trips=4),)
        )
        _ = instance.place_distances
    except InputError:
        return None
    return instance


INSTANCES = [instance for instance in map(instance_of, range(12)) if instance is not None]


@pytest.mark.parametrize("instance", INSTANCES, ids=range(len(INSTANCES)))
def test_every_trip_is_a_shortest_tour(instance: Instance, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: InFileOrder())
    result = qrobot.solve(instance, backend="in-file-order", max_work=5)
    every = instance.distances
    for trip in result.plan.trips:
        walked = [0, *(1 + int(item) for item in trip.stops), 0]
        length = sum(every[a, b] for a, b in pairwise(walked))
        assert length == pytest.approx(shortest_way(every[np.ix_(walked, walked)].tolist()))


def test_the_cases_are_shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: InFileOrder())
    results = [
        qrobot.solve(instance, backend="in-file-order", max_work=5) for instance in INSTANCES
    ]
    shortened = [result for result in results if "tours" in result.steps]
    assert len(shortened) >= 5
    assert all(result.steps[0] == "in-file-order" for result in results)
