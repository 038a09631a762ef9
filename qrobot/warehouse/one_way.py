"""Tours along one-way aisles: exact up to `EXACT_STOPS` stops, good ones beyond.

The sweep counts walks and not their directions, so here a tour is a sequence of stops on the
shortest directed ways between them. Whoever picks in a one-way sub-aisle walks all of it, so all
its picks are one stop.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot

__all__ = ["EXACT_STOPS", "one_way_tour", "refuse_one_way"]

EXACT_STOPS = 15
"""Stops up to which a tour is a shortest one: 32,768 subsets."""

MIN_GAIN = 1e-12
"""Relative to the tour: smaller gains are rounding."""

LONGEST_SEGMENT = 50
"""Stops that are moved together at most."""


def refuse_one_way(warehouse: AisleWarehouse, what: str) -> None:
    """Raise `InputError` when a layout has one-way aisles."""
    if warehouse.is_one_way:
        raise InputError(
            f"{what} takes no one-way aisles",
            field="one_way_aisles" if warehouse.one_way_aisles else "one_way_crossings",
            advice="drop their directions, or use a shortest tour",
        )


def one_way_tour(
    warehouse: AisleWarehouse,
    slots: Sequence[Slot],
    start: Slot | None = None,
    end: Slot | None = None,
    *,
    exact_stops: int = EXACT_STOPS,
) -> tuple[float, tuple[int, ...], bool]:
    """Return a tour past all slots: its length, their sequence, and whether none is shorter.

    Parameters
    ----------
    warehouse
        The layout.
    slots
        In any sequence.
    start, end
        Where it starts and ends; by default at the depot.
    exact_stops
        Stops up to which the tour is a shortest one.

    Returns
    -------
    tuple
        Metres, ``inf`` and an empty sequence where a place cannot be reached; indices of the
        slots as they are passed; whether the tour is a shortest one.
    """
    ends = [place for place in (start, end) if place is not None]
    d = warehouse.distance_matrix([*slots, *ends])
    first = 0 if start is None else len(slots) + 1
    last = 0 if end is None else len(slots) + len(ends)
    stops = _stops(warehouse, slots, ends)
    enter, leave = [stop[0] + 1 for stop in stops], [stop[-1] + 1 for stop in stops]
    ways = d[np.ix_([first, *leave], [last, *enter])]
    np.fill_diagonal(ways, 0.0)
    ways[0, 0] = d[first, last] if not stops else 0.0
    open_ = np.isfinite(ways)
    # Longer than any tour without a missing way.
    ways[~open_] = 1.0 + len(ways) * ways.max(where=open_, initial=0.0)
    exact = len(stops) <= exact_stops
    order = _shortest(ways) if exact else _shortened(ways, _inserted(ways))
    sequence = [i for at in order for i in stops[at - 1]]
    rows = [first, *(i + 1 for i in sequence), last]
    length = float(sum(d[a, b] for a, b in pairwise(rows)))
    return length, tuple(sequence) if length < np.inf else (), exact


def _stops(
    warehouse: AisleWarehouse, slots: Sequence[Slot], ends: Sequence[Slot]
) -> list[list[int]]:
    """Return the slots of each stop, as they are passed.

    A sub-aisle in which the tour starts or ends may be walked in part.
    """
    towards = {(aisle, block): to for aisle, block, to in warehouse.one_way_aisles}
    partly = {(slot.aisle, slot.block) for slot in ends}
    found: dict[tuple[int, ...], list[int]] = {}
    for i, slot in enumerate(slots):
        part = slot.aisle, slot.block
        whole = part in towards and part not in partly
        found.setdefault(part if whole else (*part, slot.slot), []).append(i)
    for key, stop in found.items():
        sign = -1 if len(key) == 2 and towards[key[0], key[1]] == "front" else 1
        stop.sort(key=lambda i: sign * slots[i].slot)
    return list(found.values())


def _shortest(ways: Floats) -> list[int]:
    """Return the shortest sequence of all stops (Held and Karp 1962).

    Parameters
    ----------
    ways
        Shape (stops + 1, stops + 1): row 0 leaves the start, column 0 comes to the end.
    """
    n = len(ways) - 1
    if n < 1:
        return []
    inner = ways[1:, 1:]
    masks = np.arange(1 << n)
    size = sum((masks >> j) & 1 for j in range(n))
    far = np.full((1 << n, n), np.inf)
    far[1 << np.arange(n), np.arange(n)] = ways[0, 1:]
    for many in range(2, n + 1):
        layer = masks[size == many]
        for j in range(n):
            here = layer[(layer >> j) & 1 == 1]
            # What a mask does not hold is infinitely far in its row.
            far[here, j] = (far[here ^ (1 << j)] + inner[:, j]).min(axis=1)
    mask = (1 << n) - 1
    at = int((far[mask] + ways[1:, 0]).argmin())
    sequence = [at + 1]
    while mask != 1 << at:
        mask ^= 1 << at
        at = int((far[mask] + inner[:, at]).argmin())
        sequence.append(at + 1)
    return sequence[::-1]


def _inserted(ways: Floats) -> list[int]:
    """Return a sequence of all stops, each put where it costs least, the farthest first."""
    away = ways[0, 1:] + ways[1:, 0]
    nodes = np.zeros(2, dtype=np.intp)
    for stop in np.argsort(-away, kind="stable") + 1:
        extra = ways[nodes[:-1], stop] + ways[stop, nodes[1:]] - ways[nodes[:-1], nodes[1:]]
        nodes = np.insert(nodes, int(extra.argmin()) + 1, stop)
    return [int(v) for v in nodes[1:-1]]


def _shortened(ways: Floats, sequence: list[int]) -> list[int]:
    """Return a sequence that no move of a segment shortens, the best move first.

    A segment moves as it is (Kanellakis and Papadimitriou 1980), or is turned round where it is
    (Croes 1958), which changes all its ways.
    """
    nodes = np.array([0, *sequence, 0], dtype=np.intp)
    total = float(ways[nodes[:-1], nodes[1:]].sum())
    while True:
        d = ways[np.ix_(nodes, nodes)]
        gain, moved = min(_best_move(d), _best_turn(d), key=lambda move: move[0])
        if gain >= -MIN_GAIN * max(total, 1.0):
            return [int(v) for v in nodes[1:-1]]
        nodes = nodes[moved]


def _best_move(d: Floats) -> tuple[float, npt.NDArray[np.intp]]:
    """Return the change of the best swap of two neighbouring segments, and the new sequence."""
    count = len(d)
    every = np.arange(count)
    steps = d[every[:-1], every[1:]]
    best, moved = 0.0, every
    for length in range(1, min(LONGEST_SEGMENT, count - 3) + 1):
        # The segment from i on comes after the one from i + length to j.
        i = every[1 : count - 1 - length, None]
        j = every[None, 1 : count - 1]
        after = i + length
        change = (
            d[i - 1, after] + d[j, i] + d[after - 1, j + 1]
            - steps[i - 1] - steps[after - 1] - steps[j]
        )  # fmt: skip
        change = np.where(j >= after, change, 0.0)
        at = int(change.argmin())
        if change.flat[at] < best:
            best = float(change.flat[at])
            row, column = divmod(at, change.shape[1])
            a, b, c = row + 1, row + 1 + length, column + 2
            moved = np.concatenate([every[:a], every[b:c], every[a:b], every[c:]])
    return best, moved


def _best_turn(d: Floats) -> tuple[float, npt.NDArray[np.intp]]:
    """Return the change of the best segment to turn round, and the new sequence."""
    count = len(d)
    every = np.arange(count)
    steps, against = d[every[:-1], every[1:]], d[every[1:], every[:-1]]
    turned = np.append(0.0, (against - steps).cumsum())
    i, j = every[1:-1, None], every[None, 1:-1]
    change = d[i - 1, j] + d[i, j + 1] - steps[i - 1] - steps[j] + turned[j] - turned[i]
    change = np.where(j > i, change, 0.0)
    row, column = divmod(int(change.argmin()), change.shape[1])
    a, b = row + 1, column + 2
    moved = np.concatenate([every[:a], every[a:b][::-1], every[b:]])
    return float(change[row, column]), moved
