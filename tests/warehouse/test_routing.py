"""Shortest tours against the subset programme of Held and Karp over shortest ways."""

import math

import numpy as np
import pytest
from numpy.random import Generator
from tours import random_aisles, random_slot, shortest_way

from qrobot import _jit
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse import Router
from qrobot.warehouse.states import transitions

CASES = 250


def random_case(rng: Generator, blocks: int) -> tuple[AisleWarehouse, list[Slot]]:
    """Return a layout and up to seven picks."""
    warehouse = random_aisles(rng, blocks, most=6)
    return warehouse, [random_slot(rng, warehouse) for _ in range(rng.integers(1, 8))]


@pytest.mark.parametrize("blocks", [1, 2, 3, 4])
def test_tours_are_shortest(blocks: int) -> None:
    """A thousand layouts: two to five cross aisles, closed parts, depots anywhere."""
    rng = np.random.default_rng(blocks)
    reached = 0
    for _ in range(CASES):
        warehouse, picks = random_case(rng, blocks)
        distances = warehouse.distance_matrix(picks)
        rows = [0, *range(1, len(picks) + 1), 0]
        expected = shortest_way(distances[np.ix_(rows, rows)].tolist())
        router = Router(warehouse, compiled=False)
        tour = router.tour(picks)
        assert router.length(picks) == pytest.approx(expected, abs=1e-9), (warehouse, picks)
        assert tour.length == pytest.approx(expected, abs=1e-9)
        if math.isinf(expected):
            assert tour.sequence == ()
            continue
        reached += 1
        stops = [0, *(i + 1 for i in tour.sequence), 0]
        assert sorted(tour.sequence) == list(range(len(picks)))
        assert distances[stops[:-1], stops[1:]].sum() == pytest.approx(expected, abs=1e-9)
    assert reached > CASES / 2


@pytest.mark.skipif(not _jit.available(), reason="numba is not installed")
@pytest.mark.parametrize("blocks", [1, 2, 3])
def test_numba_finds_the_same_lengths(blocks: int) -> None:
    rng = np.random.default_rng(10 + blocks)
    for _ in range(50):
        warehouse, picks = random_case(rng, blocks)
        plain = Router(warehouse, compiled=False).length(picks)
        assert Router(warehouse, compiled=True).length(picks) == pytest.approx(plain, abs=1e-9)


def test_as_many_states_as_published() -> None:
    """Ratliff and Rosenthal (1983); Roodbergen and de Koster (2001); Pansart et al. (2018)."""
    assert [transitions(h).count for h in (2, 3, 4, 5)] == [7, 25, 113, 569]


def test_another_pick_never_shortens_a_tour_and_a_mirror_changes_nothing() -> None:
    rng = np.random.default_rng(5)
    for _ in range(60):
        warehouse, picks = random_case(rng, int(rng.integers(1, 4)))
        router = Router(warehouse, compiled=False)
        length = router.length(picks)
        assert router.length(picks[1:]) <= length + 1e-9
        assert router.length(picks[::-1]) == length
        last = warehouse.aisles - 1
        mirrored = AisleWarehouse(
            warehouse.aisles,
            warehouse.slots,
            warehouse.blocks,
            aisle_pitch=warehouse.aisle_pitch,
            slot_pitch=warehouse.slot_pitch,
            end_gap=warehouse.end_gap,
            depot_aisle=last - warehouse.depot_aisle,
            depot_cross_aisle=warehouse.depot_cross_aisle,
            depot_distance=warehouse.depot_distance,
            closed_aisles=frozenset((last - a, b) for a, b in warehouse.closed_aisles),
            closed_crossings=frozenset((c, last - 1 - a) for c, a in warehouse.closed_crossings),
        )
        moved = [Slot(last - p.aisle, p.slot, p.block) for p in picks]
        assert Router(mirrored, compiled=False).length(moved) == pytest.approx(length, abs=1e-9)


def test_too_many_cross_aisles_are_refused_in_a_sentence() -> None:
    with pytest.raises(InputError, match="7 cross aisles are more than 6"):
        Router(AisleWarehouse(3, 3, 6))


def test_no_picks_need_no_tour() -> None:
    router = Router(AisleWarehouse(3, 3))
    assert router.length([]) == 0.0
    assert router.tour([]).sequence == ()
