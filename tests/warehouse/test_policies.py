"""Routing policies: worked examples, the published rules, and shortest tours below them."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from itertools import pairwise
from math import dist, isinf
from pathlib import Path

import numpy as np
import pytest
from numpy.random import Generator

from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot
from qrobot.problem.formats import read
from qrobot.warehouse import POLICIES, Router, route

FIVE = AisleWarehouse(5, 9, aisle_pitch=3.0, slot_pitch=1.0, end_gap=1.0)
"""One block, aisles of 10 m, slots at 1 to 9 m."""
PICKS = [Slot(0, 1), Slot(1, 0), Slot(1, 7), Slot(2, 3), Slot(4, 4), Slot(4, 8)]
"""Heights: aisle 0 at 2, aisle 1 at 1 and 8, aisle 2 at 4, aisle 4 at 5 and 9."""

TWO = AisleWarehouse(4, 4, 2, aisle_pitch=2.0, slot_pitch=1.0, end_gap=1.0)
"""Two blocks of 5 m: slots at 1 to 4 and at 6 to 9 m."""
TWO_PICKS = [
    Slot(1, 1, 1), Slot(2, 0, 1), Slot(3, 2, 1),
    Slot(0, 1, 0), Slot(2, 0, 0), Slot(2, 3, 0), Slot(3, 0, 0),
]  # fmt: skip
"""Heights: aisle 0 at 2, aisle 1 at 7, aisle 2 at 1, 4 and 6, aisle 3 at 1 and 8."""

PUBLISHED = {
    "traversal": "s-shape",
    "return": "return",
    "midpoint": "midpoint",
    "largest_gap": "largest-gap",
    "combined": "combined",
}
PICKING = Path(__file__).resolve().parents[2] / "../shared/data/picking"
SMALL = [
    "henn/uniform_Largest_Gap__5l-30-30-0.txt",
    "henn/uniform_Largest_Gap__5l-30-30-6.txt",
    "henn/uniform_S-Shape__25s-30-30-2.txt",
]


@pytest.mark.parametrize(
    ("policy", "length", "sequence"),
    [
        # 24 m across in all. Aisles 0, 1, 2 and 4 passed: 40.
        ("s-shape", 64.0, [0, 2, 1, 3, 5, 4]),
        # 2 * (2 + 8 + 4 + 9).
        ("return", 70.0, [0, 1, 2, 3, 4, 5]),
        # 0 and 4 passed: 20; of 1 both ends, 2 * (1 + 2), of 2 the front, 2 * 4.
        ("midpoint", 58.0, [0, 2, 5, 4, 3, 1]),
        # The gaps from 1 to 8 m, and from 4 to 10 m, are left out.
        ("largest-gap", 58.0, [0, 2, 5, 4, 3, 1]),
        # 0 from the front, 4; 1 passed, 10; 2 from the back, 12; 4 passed, 10.
        ("combined", 60.0, [0, 1, 2, 3, 5, 4]),
        ("aisle-by-aisle", 60.0, [0, 1, 2, 3, 5, 4]),
        # 2 + 6 + 7 + 11 + 15 + 4 + 21.
        ("as-given", 66.0, [0, 1, 2, 3, 4, 5]),
    ],
)
def test_one_block_by_hand(policy: str, length: float, sequence: list[int]) -> None:
    way = route(FIVE, PICKS, policy)
    assert (way.length, list(way.sequence)) == (length, sequence)


@pytest.mark.parametrize(
    ("policy", "length", "sequence"),
    [
        # Up aisle 0, 5. Far block: 1 and 2 passed, 3 from the front: 6 + 5 + 5 + 6.
        # Near block, from the right: 3 passed, 2 from the front: 5 + 2 + 8; home 4.
        ("s-shape", 46.0, [3, 0, 1, 2, 6, 4, 5]),
        # 5. Far block: 1 passed, 3 passed, then the front of 2: 2 + 5 + 4 + 5 + 2 + 2.
        # Near block: the back of 2, 3 passed, the front of 2: 2 + 2 + 5 + 2 + 2; home 4.
        ("largest-gap", 42.0, [3, 0, 2, 1, 5, 6, 4]),
        # 5. Far block, all from the front: 6 + 4 + 2 + 6. Near: 3 from the back, 2 passed; home 4,
        # or 3 passed and 2 from the front; both 8 + 2 + 5.
        ("combined", 42.0, None),
        # 0 to the middle: 5; 1 from there: 4; 2 from there: 2 * (4 + 1); 3 up and home: 3 + 8.
        ("aisle-by-aisle", 42.0, [3, 0, 5, 4, 1, 2, 6]),
    ],
)
def test_two_blocks_by_hand(policy: str, length: float, sequence: list[int] | None) -> None:
    way = route(TWO, TWO_PICKS, policy)
    assert way.length == length
    assert sequence is None or list(way.sequence) == sequence


def random_case(rng: Generator, blocks: int) -> tuple[AisleWarehouse, list[Slot]]:
    """Return a layout with nothing closed and a depot at an end, and up to twelve picks."""
    aisles, slots = int(rng.integers(1, 8)), int(rng.integers(1, 9))
    gaps = rng.integers(1, 5, (blocks, 2)) / 2
    warehouse = AisleWarehouse(
        aisles,
        slots,
        blocks,
        aisle_pitch=float(rng.integers(1, 6)),
        depot_aisle=int(rng.integers(aisles)),
        depot_cross_aisle=int(rng.integers(2)) * blocks,
        depot_distance=float(rng.integers(3)),
        block_gaps=tuple((float(front), float(back)) for front, back in gaps),
    )
    picks = [
        Slot(int(rng.integers(aisles)), int(rng.integers(slots)), int(rng.integers(blocks)))
        for _ in range(rng.integers(1, 13))
    ]
    return warehouse, picks


def policies_of(blocks: int) -> list[str]:
    return [p for p in POLICIES if blocks == 1 or p not in {"return", "midpoint"}]


@pytest.mark.parametrize("blocks", [1, 2, 3])
def test_no_policy_beats_the_shortest_tour_and_each_picks_all(blocks: int) -> None:
    """Ways are measured by their corners, and sequences by shortest ways."""
    rng = np.random.default_rng(blocks)
    longer = dict.fromkeys(policies_of(blocks), 0)
    for _ in range(150):
        warehouse, picks = random_case(rng, blocks)
        optimum = Router(warehouse, compiled=False).length(picks)
        distances = warehouse.distance_matrix(picks)
        for policy in longer:
            way = route(warehouse, picks, policy)
            assert sorted(way.sequence) == list(range(len(picks)))
            stops = [0, *(i + 1 for i in way.sequence), 0]
            direct = distances[stops[:-1], stops[1:]].sum()
            assert optimum - 1e-9 <= direct <= way.length + 1e-9, (policy, warehouse, picks)
            longer[policy] += way.length > optimum + 1e-9
            walked = [point for leg in way.legs for point in leg]
            assert walked[0] == walked[-1] == warehouse.depot
            assert all(a[0] == b[0] or a[1] == b[1] for a, b in pairwise(walked))
            assert sum(dist(a, b) for a, b in pairwise(walked)) == pytest.approx(way.length)
            ends = [leg[-1] for leg in way.legs[:-1]]
            assert ends == [pytest.approx(warehouse.position(picks[i])) for i in way.sequence]
    assert longer.pop("shortest") == 0
    assert min(longer.values()) > 10


def test_one_block_as_the_published_values_count() -> None:
    """The rules in words of the benchmark: so many aisles, so many metres."""
    rng = np.random.default_rng(7)
    for _ in range(200):
        warehouse, picks = random_case(rng, 1)
        (length,), end = warehouse.block_lengths, warehouse.depot_cross_aisle
        heights: dict[int, list[float]] = {}
        for slot in picks:
            y = warehouse.offset(slot)
            heights.setdefault(slot.aisle, []).append(length - y if end else y)
        columns = [*heights, warehouse.depot_aisle]
        across = 2 * warehouse.aisle_pitch * (max(columns) - min(columns))
        across += 2 * warehouse.depot_distance
        aisles = sorted(heights)
        n, far = len(aisles), {a: 2 * max(heights[a]) for a in aisles}
        ends = 2 * length if n > 1 else far[aisles[0]]
        gaps = {
            a: max(b - a for a, b in pairwise([0.0, *sorted(heights[a]), length]))
            for a in aisles[1:-1]
        }
        traversed = n * length if n % 2 == 0 else (n - 1) * length + far[aisles[-1]]
        assert route(warehouse, picks, "s-shape").length == pytest.approx(across + traversed)
        assert route(warehouse, picks, "return").length == pytest.approx(across + sum(far.values()))
        largest = sum(2 * (length - gap) for gap in gaps.values())
        assert route(warehouse, picks, "largest-gap").length == pytest.approx(
            across + ends + largest
        )
        halves = 0.0
        for a in aisles[1:-1]:
            halves += 2 * max([y for y in heights[a] if y <= length / 2], default=0.0)
            halves += 2 * max([length - y for y in heights[a] if y > length / 2], default=0.0)
        assert route(warehouse, picks, "midpoint").length == pytest.approx(across + ends + halves)
        best = route(warehouse, picks, "combined").length
        assert best <= across + min(traversed, sum(far.values())) + 1e-9
        assert route(warehouse, picks, "aisle-by-aisle").length == pytest.approx(best)


@pytest.mark.parametrize("blocks", [1, 2])
def test_a_warehouse_turned_upside_down_changes_no_length(blocks: int) -> None:
    rng = np.random.default_rng(11)
    for _ in range(60):
        warehouse, picks = random_case(rng, blocks)
        turned = AisleWarehouse(
            warehouse.aisles,
            warehouse.slots,
            blocks,
            aisle_pitch=warehouse.aisle_pitch,
            depot_aisle=warehouse.depot_aisle,
            depot_cross_aisle=blocks - warehouse.depot_cross_aisle,
            depot_distance=warehouse.depot_distance,
            block_gaps=tuple((back, front) for front, back in warehouse.block_gaps[::-1]),
        )
        same = [Slot(s.aisle, warehouse.slots - 1 - s.slot, blocks - 1 - s.block) for s in picks]
        for policy in policies_of(blocks):
            if policy == "midpoint":
                continue  # a pick in the middle belongs to the depot's side in both
            assert route(turned, same, policy).length == pytest.approx(
                route(warehouse, picks, policy).length
            )


def test_another_pick_never_shortens_a_way_through_one_block() -> None:
    """What searches for batches rely on; with two blocks S-shape, largest gap and combined may."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        warehouse, picks = random_case(rng, 1)
        fewer = [slot for slot in picks if rng.random() < 0.6]
        for policy in POLICIES:
            less = route(warehouse, fewer, policy).length
            assert less <= route(warehouse, picks, policy).length + 1e-9, (policy, picks, fewer)


@pytest.mark.parametrize(
    ("warehouse", "policy", "sentence"),
    [
        (TWO, "return", "'return' is a policy for one block, the warehouse has 2"),
        (TWO, "midpoint", "'midpoint' is a policy for one block"),
        (AisleWarehouse(3, 4, closed_aisles=frozenset({(1, 0)})), "s-shape", "for open aisles"),
        (AisleWarehouse(3, 4, 2, depot_cross_aisle=1), "combined", "first or last cross aisle"),
        (AisleWarehouse(3, 4, depot_ways=((1, 9.0),)), "largest-gap", "a depot at one aisle"),
        (AisleWarehouse(3, 4, depot_offset=1.0), "return", "a depot at one aisle"),
        (FIVE, "spiral", "'spiral' is not a routing policy; use one of shortest, s-shape"),
    ],
)
def test_what_a_policy_says_nothing_about_is_refused(
    warehouse: AisleWarehouse, policy: str, sentence: str
) -> None:
    with pytest.raises(InputError, match=re.escape(sentence)):
        route(warehouse, [Slot(0, 0)], policy)


def test_nothing_to_pick_and_nothing_to_reach() -> None:
    assert {route(FIVE, [], policy).length for policy in POLICIES} == {0.0}
    closed = AisleWarehouse(2, 4, closed_aisles=frozenset({(1, 0)}))
    for policy in ("shortest", "as-given"):
        way = route(closed, [Slot(0, 0), Slot(1, 0)], policy)
        assert isinf(way.length)
        assert (way.sequence, way.legs) == ((), ())


@pytest.mark.slow
@pytest.mark.parametrize("file", SMALL)
def test_best_batches_under_each_policy_are_the_published_ones(file: str) -> None:
    """All batches of a file, priced by the policy, and the best partition of the orders."""
    if not (PICKING / file).exists():
        pytest.skip("the published instances are not here")
    optimize = pytest.importorskip("scipy.optimize")
    instance = read(PICKING / file, robots="free")
    items = {item.id: item for item in instance.items}
    picks = [[items[i].place for i in order.items] for order in instance.orders]
    weights = [sum(items[i].weight for i in order.items) for order in instance.orders]
    batches: list[list[int]] = []

    def extend(batch: list[int], room: Fraction) -> None:
        for k in range(batch[-1] + 1 if batch else 0, len(picks)):
            if weights[k] <= room:
                batches.append([*batch, k])
                extend(batches[-1], room - weights[k])

    extend([], instance.robots[0].capacity)
    member = np.zeros((len(picks), len(batches)))
    for column, batch in enumerate(batches):
        member[batch, column] = 1
    published = {e["file"]: e for e in json.loads((PICKING / "index.json").read_text())}[file]
    for theirs, ours in PUBLISHED.items():
        costs = [
            route(instance.warehouse, [s for k in batch for s in picks[k]], ours).length
            for batch in batches
        ]
        found = optimize.milp(
            costs,
            integrality=np.ones(len(batches)),
            constraints=optimize.LinearConstraint(member, 1, 1),
        )
        assert published["published"][theirs]["proven"]
        assert found.fun == pytest.approx(published["published"][theirs]["value"], abs=1e-6), ours
