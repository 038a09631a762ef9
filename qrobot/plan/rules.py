"""The checker's own measure of routing policies: closed formulas, no walk.

One block of aisles, all open in both directions, and a depot at one aisle. Heights count from the
depot's cross aisle, L is the length of an aisle, and each policy adds twice the way along the
cross aisle that all its aisles and the depot need. `warehouse` walks instead, so that a fault
there shows.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

from qrobot.problem.aisles import AisleWarehouse
from qrobot.problem.warehouse import Place, Slot, Warehouse

__all__ = ["RULES", "rule_of"]

Aisles = Sequence[Sequence[float]]
"""Of each aisle with picks, from left to right, the heights, rising."""

Rule = Callable[[Aisles, float], float]


def _return(aisles: Aisles, _length: float) -> float:
    return 2 * math.fsum(heights[-1] for heights in aisles)


def _s_shape(aisles: Aisles, length: float) -> float:
    passed = len(aisles) - len(aisles) % 2
    return passed * length + 2 * math.fsum(heights[-1] for heights in aisles[passed:])


def _around(aisles: Aisles, length: float, inside: Callable[[Sequence[float]], float]) -> float:
    """Pass the first and the last aisle; the others cost what is walked inside."""
    if len(aisles) == 1:
        return 2 * aisles[0][-1]
    return 2 * length + math.fsum(map(inside, aisles[1:-1]))


def _midpoint(aisles: Aisles, length: float) -> float:
    def inside(heights: Sequence[float]) -> float:
        front = max((y for y in heights if y <= length / 2), default=0.0)
        back = min((y for y in heights if y > length / 2), default=length)
        return 2 * front + 2 * (length - back)

    return _around(aisles, length, inside)


def _largest_gap(aisles: Aisles, length: float) -> float:
    return _around(
        aisles,
        length,
        lambda heights: 2 * (length - max(b - a for a, b in pairwise((0.0, *heights, length)))),
    )


def _combined(aisles: Aisles, length: float) -> float:
    """Return the least over all choices of aisles that are passed, an even number of them."""
    # What is left to be walked from the front and from the back of each aisle, from the last on.
    front, back = 0.0, math.inf
    for heights in reversed(aisles):
        front, back = (
            min(2 * heights[-1] + front, length + back),
            min(2 * (length - heights[0]) + back, length + front),
        )
    return front


RULES: dict[str, Rule] = {
    "s-shape": _s_shape,
    "return": _return,
    "midpoint": _midpoint,
    "largest-gap": _largest_gap,
    "combined": _combined,
    "aisle-by-aisle": _combined,
}
"""What is walked inside the aisles, by the name of a policy."""


def rule_of(
    name: str, warehouse: Warehouse
) -> tuple[Callable[[Iterable[Place]], float] | None, str]:
    """Return a function that measures the trip of a policy, or None and why there is none."""
    if name not in RULES:
        return None, f"is not known; known are {', '.join(('exact', *RULES))}"
    w = warehouse
    if not isinstance(w, AisleWarehouse) or w.blocks > 1 or w.depot_offset or w.depot_ways:
        return None, "needs one block of aisles and a depot at one of them"
    if w.closed_aisles or w.closed_crossings or w.one_way_aisles or w.one_way_crossings:
        return None, "needs aisles that are open in both directions"
    ((front, back),) = w.block_gaps or ((w.end_gap, w.end_gap),)
    length = front + (w.slots - 1) * w.slot_pitch + back

    def measure(places: Iterable[Place]) -> float:
        picks: defaultdict[int, set[float]] = defaultdict(set)
        for place in places:
            assert isinstance(place, Slot)
            y = front + place.slot * w.slot_pitch
            picks[place.aisle].add(length - y if w.depot_cross_aisle else y)
        if not picks:
            return 0.0
        span = max(*picks, w.depot_aisle) - min(*picks, w.depot_aisle)
        inside = RULES[name]([sorted(picks[aisle]) for aisle in sorted(picks)], length)
        return inside + 2 * span * w.aisle_pitch + 2 * w.depot_distance

    return measure, ""
