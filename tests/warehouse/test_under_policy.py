"""Lengths of a policy's ways: walked, by closed formulas, and compiled."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.random import Generator
from tours import random_slot

from qrobot import _jit
from qrobot.errors import InputError
from qrobot.plan.rules import RULES, rule_of
from qrobot.problem import AisleWarehouse, Instance, Item, OpenFloor, Order, Point, Robot, Slot
from qrobot.warehouse import ROUTINGS, PolicyInstance, Router, route, under_policy

CASES = 120


def one_block(rng: Generator) -> AisleWarehouse:
    """Return an open layout of one block, the depot at its front or its back."""
    aisles = int(rng.integers(1, 8))
    return AisleWarehouse(
        aisles,
        int(rng.integers(1, 90)),
        aisle_pitch=float(rng.integers(1, 6)),
        slot_pitch=float(rng.integers(1, 4)) / 2,
        block_gaps=((float(rng.integers(1, 4)), float(rng.integers(1, 4))),),
        depot_aisle=int(rng.integers(aisles)),
        depot_cross_aisle=int(rng.integers(2)),
        depot_distance=float(rng.integers(0, 3)),
    )


@pytest.mark.skipif(not _jit.available(), reason="numba is not installed")
@pytest.mark.parametrize("policy", [name for name in ROUTINGS if name != "exact"])
def test_three_ways_of_measuring_agree(policy: str) -> None:
    """And no way is shorter than a shortest tour, nor than that past some of its places.

    The last is what lets a proof leave out the batches that contain a batch that is too long.
    """
    from qrobot.warehouse.kernels import masks_of, tour_length
    from qrobot.warehouse.layouts import CODES

    rng = np.random.default_rng(len(policy))
    for _ in range(CASES):
        w = one_block(rng)
        picks = [random_slot(rng, w) for _ in range(rng.integers(1, 14))]
        walked = route(w, picks, policy).length
        measure, _ = rule_of(policy, w)
        assert measure is not None
        layout, (one, fewer) = masks_of(w, [picks, picks[1:]], CODES[policy])
        assert measure(picks) == pytest.approx(walked, abs=1e-9), (w, picks)
        assert tour_length(one, layout) == pytest.approx(walked, abs=1e-9), (w, picks)
        assert tour_length(fewer, layout) <= walked + 1e-9
        assert Router(w, compiled=False).length(picks) <= walked + 1e-9


def test_every_policy_has_its_formula() -> None:
    assert set(RULES) == set(ROUTINGS) - {"exact"}


def orders(warehouse: AisleWarehouse | OpenFloor, place: Slot | Point) -> Instance:
    return Instance(warehouse, (Item("a", 1, place),), (Order("o", ("a",)),), (Robot("R1", 5),))


@pytest.mark.parametrize(
    ("warehouse", "routing", "problem"),
    [
        (
            AisleWarehouse(3, 4),
            "s-curve",
            "routing: 's-curve' is not a routing; use one of exact, ",
        ),
        (AisleWarehouse(3, 4, 2), "s-shape", "plans batches in one block, the warehouse has 2;"),
        (
            AisleWarehouse(3, 4, closed_aisles=frozenset({(1, 0)})),
            "combined",
            "is a policy for open aisles, some are closed; leave",
        ),
        (
            AisleWarehouse(3, 4, one_way_aisles=frozenset({(1, 0, "back")})),
            "return",
            "is a policy for aisles that are walked both ways, some are one-way; leave",
        ),
        (
            AisleWarehouse(3, 4, depot_offset=1.0),
            "midpoint",
            "is a policy for a depot at one aisle; leave",
        ),
        (OpenFloor(), "return", "is a policy for aisles, this warehouse has none; leave"),
    ],
)
def test_what_a_policy_says_nothing_about_is_refused(
    warehouse: AisleWarehouse | OpenFloor, routing: str, problem: str
) -> None:
    place = Point(1, 1) if isinstance(warehouse, OpenFloor) else Slot(0, 1)
    with pytest.raises(InputError, match=problem):
        under_policy(orders(warehouse, place), routing)


def test_trips_are_walked_in_the_sequence_of_the_policy() -> None:
    house = AisleWarehouse(4, 9)
    places = [Slot(3, 2), Slot(0, 5), Slot(0, 1), Slot(2, 4), Slot(2, 4, side="right")]
    items = tuple(Item(f"i{k}", 1, place) for k, place in enumerate(places))
    instance = Instance(house, items, (Order("o", [i.id for i in items]),), (Robot("R1", 9),))
    asked = under_policy(instance, "return")
    assert isinstance(asked, PolicyInstance)
    assert asked.in_sequence([[1, 2, 3, 4, 5]]) == [[3, 2, 4, 5, 1]]
    assert asked.route_length([5, 4, 3, 2, 1]) == 2 * (6 + 5 + 3) + 2 * 9
    assert under_policy(instance, "exact") is instance
