"""Random aisle layouts, and shortest ways past places without any code of the package."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from numpy.random import Generator

from qrobot.problem import AisleWarehouse, Slot

__all__ = ["random_aisles", "random_slot", "shortest_way"]


def shortest_way(d: Sequence[Sequence[float]]) -> float:
    """Return the length of a shortest way from row 0 past all others to the last (Held-Karp 1962).

    A tour is one whose last row is the depot again.
    """
    inner = range(1, len(d) - 1)
    best = {(1 << i, i): d[0][i] for i in inner}
    for size in range(2, len(inner) + 1):
        for chosen in combinations(inner, size):
            mask = sum(1 << i for i in chosen)
            for j in chosen:
                best[mask, j] = min(best[mask ^ (1 << j), k] + d[k][j] for k in chosen if k != j)
    everything = sum(1 << i for i in inner)
    return min((best[everything, j] + d[j][-1] for j in inner), default=d[0][-1])


def random_aisles(rng: Generator, blocks: int, *, most: int) -> AisleWarehouse:
    """Return a layout of up to `most` aisles and slots, in half of the cases with closed parts."""
    aisles, slots = int(rng.integers(1, most + 1)), int(rng.integers(1, most + 1))
    closed = rng.random() < 0.5
    return AisleWarehouse(
        aisles,
        slots,
        blocks,
        aisle_pitch=float(rng.integers(1, 6)),
        slot_pitch=float(rng.integers(1, 4)) / 2,
        end_gap=float(rng.integers(1, 4)),
        depot_aisle=int(rng.integers(aisles)),
        depot_cross_aisle=int(rng.integers(blocks + 1)),
        depot_distance=float(rng.integers(0, 3)),
        closed_aisles=frozenset(
            (int(rng.integers(aisles)), int(rng.integers(blocks)))
            for _ in range(rng.integers(3) * closed)
        ),
        closed_crossings=frozenset(
            (int(rng.integers(blocks + 1)), int(rng.integers(aisles - 1)))
            for _ in range(rng.integers(5) * closed * (aisles > 1))
        ),
    )


def random_slot(rng: Generator, w: AisleWarehouse) -> Slot:
    """Return a slot of a layout."""
    return Slot(
        int(rng.integers(w.aisles)), int(rng.integers(w.slots)), int(rng.integers(w.blocks))
    )
