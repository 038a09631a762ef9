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
POLICIES = [
    (policy, blocks)
    for policy in ROUTINGS
    for blocks in (1, 2, 3)
    if policy != "exact" and (blocks == 1 or policy not in {"return", "midpoint"})
]
COMPILED = pytest.mark.skipif(not _jit.available(), reason="numba is not installed")

UP_AND_DOWN = AisleWarehouse(4, 3, 2)
SHORTENED = {
    "s-shape": [Slot(2, 0, 1), Slot(2, 2), Slot(1, 0), Slot(0, 2, 1)],
    "combined": [Slot(2, 0, 1), Slot(1, 0), Slot(0, 0, 1), Slot(2, 2)],
    "largest-gap": [Slot(1, 0), Slot(2, 1, 1), Slot(3, 1), Slot(0, 1), Slot(1, 1)],
}
"""Picks whose way is longer without the first of them, by two blocks of four aisles."""


def layout_of(rng: Generator, blocks: int) -> AisleWarehouse:
    """Return an open layout, the depot at its front or its back; slots may lie on cross aisles."""
    aisles, unit = int(rng.integers(1, 8)), float(rng.choice([1.0, 0.5, 0.1]))
    slots = int(rng.integers(2, 90 if blocks == 1 else 12))
    return AisleWarehouse(
        aisles,
        slots,
        blocks,
        aisle_pitch=unit * float(rng.integers(1, 6)),
        slot_pitch=unit * float(rng.integers(1, 4)),
        block_gaps=tuple(
            (unit * float(rng.integers(0, 4)), unit * float(rng.integers(0, 4)))
            for _ in range(blocks)
        ),
        depot_aisle=int(rng.integers(aisles)),
        depot_cross_aisle=int(rng.integers(2)) * blocks,
        depot_distance=unit * float(rng.integers(0, 3)),
    )


@COMPILED
@pytest.mark.parametrize(("policy", "blocks"), POLICIES)
def test_three_ways_of_measuring_agree(policy: str, blocks: int) -> None:
    """And no way is shorter than a shortest tour, nor than what a proof leaves batches out by.

    That is the way past some of the places where another pick never shortens one, and a shortest
    tour past these elsewhere.
    """
    from qrobot.warehouse.kernels import least_length, masks_of, tour_length
    from qrobot.warehouse.layouts import CODES

    rng = np.random.default_rng(len(policy) + 100 * blocks)
    for _ in range(CASES):
        w = layout_of(rng, blocks)
        picks = [random_slot(rng, w) for _ in range(rng.integers(1, 14))]
        walked = route(w, picks, policy).length
        measure, _ = rule_of(policy, w)
        assert measure is not None
        layout, (one, fewer) = masks_of(w, [picks, picks[1:]], CODES[policy])
        assert measure(picks) == pytest.approx(walked, abs=1e-9), (w, picks)
        assert tour_length(one, layout) == pytest.approx(walked, abs=1e-9), (w, picks)
        shortest = Router(w, compiled=False).length(picks)
        assert shortest <= walked + 1e-9
        least = least_length(fewer, layout, tour_length(fewer, layout))
        assert least <= walked + 1e-9
        if layout.grows:
            assert tour_length(fewer, layout) <= walked + 1e-9
        else:
            expected = Router(w, compiled=False).length(picks[1:]) if picks[1:] else 0.0
            assert least == pytest.approx(max(expected, 2 * w.depot_distance))


@COMPILED
@pytest.mark.parametrize("policy", SHORTENED)
def test_another_pick_may_shorten_a_way_through_blocks(policy: str) -> None:
    """So its length leaves out no batch with more orders."""
    from qrobot.warehouse.kernels import least_length, masks_of, tour_length
    from qrobot.warehouse.layouts import CODES

    picks = SHORTENED[policy]
    layout, (more, fewer) = masks_of(UP_AND_DOWN, [picks, picks[1:]], CODES[policy])
    longer = tour_length(fewer, layout)
    assert longer > tour_length(more, layout)
    assert least_length(fewer, layout, longer) <= tour_length(more, layout)


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
        (AisleWarehouse(3, 4, 2), "return", "is a policy for one block, the warehouse has 2;"),
        (
            AisleWarehouse(3, 4, 2, depot_cross_aisle=1),
            "s-shape",
            "is a policy for a depot at the first or last cross aisle; leave",
        ),
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
