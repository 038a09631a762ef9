"""The checker's own measure of routing policies: formulas, no walk.

Aisles that are all open in both directions, and a depot at one of them, at the first or last cross
aisle. Heights count from the depot's side of a block, L is the length of its aisles. Through one
block each policy adds twice the way along the cross aisle that all its aisles and the depot need;
through several blocks the aisles are noted at which the way along cross aisles turns. `warehouse`
walks instead, so that a fault there shows.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import accumulate, pairwise

from qrobot.problem.aisles import AisleWarehouse
from qrobot.problem.warehouse import Place, Slot, Warehouse

__all__ = ["RULES", "rule_of"]

ROUNDING = 1e-9
"""Lengths that differ by less than this share of an aisle are the same."""

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
    half = (0.5 + ROUNDING) * length

    def inside(heights: Sequence[float]) -> float:
        front = max((y for y in heights if y <= half), default=0.0)
        back = min((y for y in heights if y > half), default=length)
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
"""What is walked inside the aisles of one block, by the name of a policy."""

Block = Mapping[int, Sequence[float]]
"""Of each aisle with picks in a block the heights, rising."""

Passing = Callable[[Block, float, int, bool], tuple[float, Sequence[int]]]
"""From a block, L, the aisle where the picker comes to it, and whether that is at its front: what
is walked inside, and at which aisles the way along cross aisles turns; the last leads to the front.
"""


def _from_nearer_end(block: Block, at: int, at_front: bool) -> list[int]:
    """Return the aisles, from the left one where both ends are as near."""
    first, last = min(block), max(block)
    return sorted(block, reverse=not at_front and abs(last - at) < abs(first - at))


def _s_shape_block(block: Block, length: float, at: int, at_front: bool) -> tuple[float, list[int]]:
    aisles = _from_nearer_end(block, at, at_front)
    # Whoever comes from the front returns there after an even number of aisles that are passed.
    turned = aisles[-1:] if len(aisles) % 2 == at_front else []
    inside = (len(aisles) - len(turned)) * length + sum(2 * block[a][-1] for a in turned)
    return inside, [aisles[0], aisles[-1]]


def _combined_block(
    block: Block, length: float, at: int, at_front: bool
) -> tuple[float, list[int]]:
    aisles = _from_nearer_end(block, at, at_front)

    def after(k: int) -> float:
        """Return what is walked in the aisles from k on, beginning at the front."""
        return _combined([block[a] for a in aisles[k:]], length)

    # From the back: the first aisles are left where they were entered, then one is passed.
    turned = list(accumulate((2 * (length - block[a][0]) for a in aisles), initial=0.0))
    from_back = (turned[k] + length + after(k + 1) for k in range(len(aisles)))
    return after(0) if at_front else min(from_back), [aisles[0], aisles[-1]]


def _largest_gap_block(
    block: Block, length: float, at: int, at_front: bool
) -> tuple[float, list[int]]:
    first, last = min(block), max(block)
    if at_front and first == last:
        return 2 * block[first][-1], [first]
    begun = [first] if at_front else []
    at = first if at_front else at
    last = last if last - at >= abs(first - at) else first
    inside, from_back, from_front = length * (len(begun) + 1), [at], [last]
    for aisle in block.keys() - {last, *begun}:
        gaps = [b - a for a, b in pairwise((0.0, *block[aisle], length))]
        inside += 2 * (length - max(gaps))
        left_out = [gap >= max(gaps) - ROUNDING * length for gap in gaps].index(True)
        if left_out < len(gaps) - 1:
            from_back.append(aisle)
        if left_out > 0:
            from_front.append(aisle)
    # Between the picker and the last aisle all lies on the way; what is on the other side does not.
    other_side = min(from_back) if last > at else max(from_back)
    end = min(from_front) if last == max(from_front) else max(from_front)
    return inside, [*begun, other_side, last, end]


PASSINGS: dict[str, Passing] = {
    "s-shape": _s_shape_block,
    "largest-gap": _largest_gap_block,
    "combined": _combined_block,
}
"""How policies that go from block to block serve one of several."""


def _block_by_block(
    passing: Passing, blocks: Sequence[Block], lengths: Sequence[float], depot: int
) -> tuple[float, int]:
    """Return metres in the aisles, and pitches along cross aisles.

    The first aisle with picks leads to the farthest block, and is served on the way.
    """
    farthest = max(b for b, block in enumerate(blocks) if block)
    first = min(min(block) for block in blocks if block)
    inside, turns = math.fsum(lengths[:farthest]), [depot, first]
    for b in range(farthest, -1, -1):
        left = {a: ys for a, ys in blocks[b].items() if b == farthest or a != first}
        if left:
            more, stops = passing(left, lengths[b], turns[-1], b == farthest)
            inside += more
            turns += stops
        else:
            inside += lengths[b]
    return inside, sum(abs(b - a) for a, b in pairwise([*turns, depot]))


def _aisle_by_aisle(
    blocks: Sequence[Block], lengths: Sequence[float], depot: int
) -> tuple[float, int]:
    """Return metres in the aisles, and pitches along cross aisles; each aisle is served once."""
    levels = list(accumulate(lengths, initial=0.0))
    aisles: defaultdict[int, list[float]] = defaultdict(list)
    for block, level in zip(blocks, levels, strict=False):
        for aisle, heights in block.items():
            aisles[aisle] += [level + y for y in heights]
    best = {0.0: 0.0}
    for _, heights in sorted(aisles.items()):
        low, high = min(heights), max(heights)
        best = {
            leave: high
            - low
            + min(
                cost
                + min(abs(enter - low) + abs(high - leave), abs(enter - high) + abs(low - leave))
                for enter, cost in best.items()
            )
            for leave in levels
        }
    return best[0.0], 2 * (max(depot, *aisles) - min(depot, *aisles))


def rule_of(
    name: str, warehouse: Warehouse
) -> tuple[Callable[[Iterable[Place]], float] | None, str]:
    """Return a function that measures the trip of a policy, or None and why there is none."""
    w = warehouse
    if reason := _why_not(name, w):
        return None, reason
    assert isinstance(w, AisleWarehouse)
    gaps = w.block_gaps or ((w.end_gap, w.end_gap),) * w.blocks
    lengths = [front + (w.slots - 1) * w.slot_pitch + back for front, back in gaps]
    flipped = w.depot_cross_aisle > 0
    seen = lengths[::-1] if flipped else lengths

    def measure(places: Iterable[Place]) -> float:
        heights: defaultdict[tuple[int, int], set[float]] = defaultdict(set)
        for place in places:
            assert isinstance(place, Slot)
            y, b = gaps[place.block][0] + place.slot * w.slot_pitch, place.block
            key = (w.blocks - 1 - b if flipped else b), place.aisle
            heights[key].add(lengths[b] - y if flipped else y)
        if not heights:
            return 0.0
        blocks: list[dict[int, list[float]]] = [{} for _ in lengths]
        for (b, aisle), ys in sorted(heights.items()):
            blocks[b][aisle] = sorted(ys)
        if w.blocks == 1:
            (block,), depot = blocks, w.depot_aisle
            inside = RULES[name](list(block.values()), seen[0])
            pitches = 2 * (max(depot, *block) - min(depot, *block))
        elif name == "aisle-by-aisle":
            inside, pitches = _aisle_by_aisle(blocks, seen, w.depot_aisle)
        else:
            inside, pitches = _block_by_block(PASSINGS[name], blocks, seen, w.depot_aisle)
        return inside + pitches * w.aisle_pitch + 2 * w.depot_distance

    return measure, ""


def _why_not(name: str, w: Warehouse) -> str:
    """Return why a policy does not suit a warehouse, empty where it does."""
    if name not in RULES:
        return f"is not known; known are {', '.join(('exact', *RULES))}"
    if not isinstance(w, AisleWarehouse) or w.depot_offset or w.depot_ways:
        return "needs aisles and a depot at one of them"
    if w.depot_cross_aisle not in (0, w.blocks):
        return "needs a depot at the first or last cross aisle"
    if w.blocks > 1 and name not in (*PASSINGS, "aisle-by-aisle"):
        return "needs one block of aisles"
    if w.closed_aisles or w.closed_crossings or w.one_way_aisles or w.one_way_crossings:
        return "needs aisles that are open in both directions"
    return ""
