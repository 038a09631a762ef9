"""The annealing of batches: what it keeps account of, and what nearly full trips need."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from qrobot import _jit
from qrobot.backends import Stop, get
from qrobot.backends.base import Planner
from qrobot.backends.classical.batching.lots import Lots, fits_surely, packed
from qrobot.backends.classical.batching.rules import join_by_savings
from qrobot.backends.classical.exact import ExactPlanner
from qrobot.problem import AisleWarehouse, Instance, Item, Order, Robot, Slot

pytestmark = pytest.mark.skipif(not _jit.available(), reason="numba is not installed")


def full_trips(seed: int, orders: int = 12, capacity: int = 30, trips: int = 4) -> Instance:
    """Return orders whose weights fill all trips to the last unit."""
    random = np.random.default_rng(seed)
    each = orders // trips
    weights: list[int] = []
    for _ in range(trips):
        cuts = np.sort(random.choice(np.arange(1, capacity), each - 1, replace=False))
        weights += np.diff([0, *cuts, capacity]).tolist()
    random.shuffle(weights)
    items, whole = [], []
    for k, weight in enumerate(weights):
        place = Slot(int(random.integers(6)), int(random.integers(10)), 0)
        items.append(Item(f"item-{k}", weight, place))
        whole.append(Order(f"order-{k}", (f"item-{k}",)))
    house = AisleWarehouse(aisles=6, slots=10)
    return Instance(house, tuple(items), tuple(whole), (Robot("R", capacity, trips=trips),))


@pytest.mark.parametrize("seed", range(4))
def test_trips_filled_to_the_last_unit_are_batched_as_well_as_they_can_be(seed: int) -> None:
    instance = full_trips(seed)
    search = get("batching")
    assert isinstance(search, Planner)
    found = search.search(instance, stop=Stop(max_work=200), seed=seed)
    best = ExactPlanner().search(instance, stop=Stop(60))
    assert best.optimal
    assert found.routes is not None
    assert best.routes is not None
    assert instance.length(found.routes) == pytest.approx(instance.length(best.routes))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("heat", [0.2, 5.0, 100.0])
def test_loads_lengths_and_overload_are_kept_account_of(seed: int, heat: float) -> None:
    from qrobot.backends.classical.batching.annealing import anneal, place
    from qrobot.backends.classical.batching.state import new_state
    from qrobot.backends.classical.orders import orders_of

    orders = orders_of(full_trips(seed, orders=16))
    random = np.random.default_rng(seed)
    state, again = (new_state(orders, 0.0, seed, 100) for _ in range(2))
    place(orders, state, random.integers(len(orders.capacities), size=16))
    for _ in range(5):
        total, over = anneal(orders, state, 500, heat, 0.0)
        place(orders, again, state.trip)
        loads = np.bincount(state.trip, orders.weights, len(orders.capacities))
        np.testing.assert_array_equal(state.load, loads)
        np.testing.assert_array_equal(state.key, again.key)
        np.testing.assert_allclose(state.length, again.length)
        assert total == pytest.approx(again.length.sum())
        assert over == np.maximum(loads - orders.capacities, 0).sum()
        for trip in range(len(orders.capacities)):
            members = state.members[trip, : state.size[trip]]
            assert sorted(members) == np.flatnonzero(state.trip == trip).tolist()


@given(
    st.lists(st.integers(1, 20), min_size=1, max_size=30),
    st.integers(1, 12),
    st.integers(15, 60),
)
@settings(max_examples=300)
def test_what_surely_fits_is_packed(loads: list[int], trips: int, capacity: int) -> None:
    capacities = np.full(trips, capacity, dtype=np.int64)
    weights = np.array(loads, dtype=np.int64)
    if fits_surely(weights, capacities):
        assert packed(weights, capacities) is not None


@pytest.mark.parametrize("limits", [{}, {"max_work": 10**9}, {"seconds": 1e6}])
def test_a_request_ends_the_savings_that_many_orders_begin_from(
    limits: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from qrobot.backends.classical.batching import aisles

    instance = full_trips(0, orders=2 * aisles.MANY, trips=aisles.MANY)
    stop, joined = Stop(**limits), []

    def join(lots: Lots, part: Stop) -> int:
        assert not part()
        stop.request()
        joined.append(join_by_savings(lots, part))
        return joined[-1]

    monkeypatch.setattr(aisles, "join_by_savings", join)
    found = aisles.search_aisles(instance, stop, seed=0)
    assert joined == [0]
    assert found.routes is None or sorted(v for r in found.routes for v in r) == list(
        range(1, 2 * aisles.MANY + 1)
    )
