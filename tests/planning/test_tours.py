"""The trips of a plan in aisles are shortest tours, whatever backend dealt the orders out."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from tours import random_aisles, random_slot, shortest_way

import qrobot
from qrobot.backends import Capabilities, Search, Stop
from qrobot.errors import InputError
from qrobot.jobs import JobStore
from qrobot.planning import collect
from qrobot.planning.run import Run
from qrobot.planning.tours import shorten_tours
from qrobot.problem import Instance, Item, Order, Robot
from qrobot.problem.formats.native import to_text
from qrobot.warehouse.routing import Router


class InFileOrder:
    """A backend whose trips take two orders each and pass the items as the file has them."""

    name = "in-file-order"
    capabilities = Capabilities(kind="planner")

    def search(self, instance: Instance, *, stop: Stop, seed: int, **_: Any) -> Search:
        return Search(routes=in_file_order(instance))


def in_file_order(instance: Instance) -> list[list[int]]:
    """Return two orders a trip, their items as the file has them."""
    first, second, third, fourth = instance.order_nodes
    return [[*first, *second], [*third, *fourth]]


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


def test_a_job_that_is_fetched_gets_them_too(monkeypatch: pytest.MonkeyPatch) -> None:
    (one, *_) = (i for i in INSTANCES if i.warehouse.blocks > 1)
    kept = SimpleNamespace(id="1", backend="far", context={"instance": to_text(one)})
    store = SimpleNamespace(get=lambda _: kept)
    monkeypatch.setattr("qrobot.planning.remote_jobs.build_model", lambda *_, **__: None)
    monkeypatch.setattr("qrobot.planning.remote_jobs.fetch", lambda *_: None)
    monkeypatch.setattr(
        "qrobot.planning.remote_jobs.use_reads",
        lambda run, *_: run.best.offer(in_file_order(run.instance)),
    )
    fetched = collect("1", cast("JobStore", store))
    monkeypatch.setattr("qrobot.planning.solving.get", lambda _: InFileOrder())
    solved = qrobot.solve(one, backend="in-file-order", max_work=5)
    assert fetched.plan.distance == pytest.approx(solved.plan.distance)
    assert fetched.plan.distance < one.length(in_file_order(one))


def test_an_interrupt_ends_it_and_keeps_what_was_gained(monkeypatch: pytest.MonkeyPatch) -> None:
    one, stop, asked = INSTANCES[0], Stop(), []
    shortest = Router.route

    def route(*given: Any) -> tuple[float, list[int]]:
        asked.append(given)
        stop.request()
        return shortest(*given)

    monkeypatch.setattr(Router, "route", route)
    run = Run(one, stop, 0)
    run.best.offer(in_file_order(one))
    before = run.best.length
    shorten_tours(run)
    assert len(asked) == 1 < len(run.best.routes or [])
    assert run.best.length <= before
