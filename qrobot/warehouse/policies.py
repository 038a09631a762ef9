"""Ways that pickers walk by a rule, as warehouses use them, beside the shortest tour.

A rule says which aisles are passed and where the picker turns; whatever the picker passes is
picked. S-shape, largest gap, combined and aisle-by-aisle go through any number of blocks as
Roodbergen and de Koster (2001) and Vaughan and Petersen (1999) describe; return and midpoint
(Hall 1993) are rules for one block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from math import inf

from qrobot.errors import InputError
from qrobot.problem import AisleWarehouse, Slot
from qrobot.warehouse.layouts import EVEN
from qrobot.warehouse.routing import Router
from qrobot.warehouse.walking import XY, Route, Walk, corners
from qrobot.warehouse.walking import length as walked

__all__ = ["POLICIES", "Policy", "check_layout", "route"]

Policy = Callable[[AisleWarehouse, Sequence[Slot]], Route]


def s_shape(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Pass every aisle with picks to its other end; turn in the last one where that is shorter.

    Several blocks: up the first aisle with picks to the farthest block, then block after block,
    each from its nearer end.
    """

    def serve(walk: Walk, aisles: Mapping[int, Sequence[float]], front: float, back: float) -> None:
        *passed, last = _from_nearer_end(walk, aisles, front)
        for aisle in passed:
            walk.go(aisle, back if walk.y == front else front)
        _finish(walk, last, aisles[last], front)

    return _by_blocks(_walk(warehouse, slots, "s-shape"), serve)


def return_trips(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Enter every aisle from the depot's side, go to the farthest pick and back."""
    walk = _walk(warehouse, slots, "return")
    for aisle, heights in walk.picks(0).items():
        walk.go(aisle, heights[-1], 0.0)
    return walk.home()


def midpoint(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Pass the first and the last aisle; pick each half of the others from its own end.

    A pick in the very middle belongs to the front.
    """

    def cut(heights: Sequence[float], front: float, back: float) -> int:
        # Seen from the depot, the front of one block is at 0.
        return sum(2 * y <= front + (1 + EVEN) * back for y in heights)

    return _around(_walk(warehouse, slots, "midpoint"), cut)


def largest_gap(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Pass the first and the last aisle; leave out the largest gap of each of the others.

    A gap lies between two picks, or between a pick and an end of the aisle; of gaps as wide the one
    nearest to the front is left out. Several blocks: as in
    `s_shape`, and the aisle that leads to the front of a block is that which is farthest from
    where the picker comes in.
    """

    def cut(heights: Sequence[float], front: float, back: float) -> int:
        gaps = [b - a for a, b in pairwise((front, *heights, back))]
        least = max(gaps) - EVEN * (back - front)
        return next(k for k, gap in enumerate(gaps) if gap >= least)

    return _around(_walk(warehouse, slots, "largest-gap"), cut)


def combined(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Pass each aisle of a block or turn in it, whichever makes the way through the block shortest.

    Aisles are served from one end of the block to the other, by a dynamic programme; blocks as in
    `s_shape`.
    """

    def serve(walk: Walk, aisles: Mapping[int, Sequence[float]], front: float, back: float) -> None:
        _serve_in_turn(walk, _from_nearer_end(walk, aisles, front), aisles, [front, back], front)

    return _by_blocks(_walk(warehouse, slots, "combined"), serve)


def aisle_by_aisle(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Serve each aisle once with all its blocks; the best cross aisle leads to the next one."""
    walk = _walk(warehouse, slots, "aisle-by-aisle")
    aisles: dict[int, list[float]] = {}
    for block in range(warehouse.blocks):
        for aisle, heights in walk.picks(block).items():
            aisles.setdefault(aisle, []).extend(heights)
    _serve_in_turn(walk, sorted(aisles), aisles, walk.heights, 0.0)
    return walk.home()


def as_given(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Pick in the sequence of the slots, each time by the shortest way.

    A warehouse whose locations have a sort index sorts the slots by it first.
    """
    return _in_sequence(warehouse, slots, range(len(slots)))


def shortest(warehouse: AisleWarehouse, slots: Sequence[Slot]) -> Route:
    """Walk a shortest tour; along one-way aisles past more than 15 stops, a good one."""
    tour = Router(warehouse, compiled=False).tour(slots)
    return _in_sequence(warehouse, slots, tour.sequence)


POLICIES: dict[str, Policy] = {
    "shortest": shortest,
    "s-shape": s_shape,
    "return": return_trips,
    "midpoint": midpoint,
    "largest-gap": largest_gap,
    "combined": combined,
    "aisle-by-aisle": aisle_by_aisle,
    "as-given": as_given,
}
"""Routing policies by name."""

ONE_BLOCK = ("return", "midpoint")


def route(warehouse: AisleWarehouse, slots: Sequence[Slot], policy: str = "shortest") -> Route:
    """Return the way from the depot past some slots and back that a routing policy takes.

    Parameters
    ----------
    warehouse
        The layout. Policies other than ``shortest`` and ``as-given`` need every aisle and cross
        aisle open in both directions, and the depot at the first or the last cross aisle;
        ``return`` and ``midpoint`` need one block.
    slots
        What is picked.
    policy
        One of `POLICIES`.

    Returns
    -------
    Route
        Its length, the sequence of the picks, and where it turns.

    Raises
    ------
    InputError
        When the policy is unknown, or says nothing about such a layout.
    """
    if policy not in POLICIES:
        raise InputError(
            f"{policy!r} is not a routing policy",
            field="policy",
            advice=f"use one of {', '.join(POLICIES)}",
        )
    for slot in slots:
        warehouse.check(slot)
    return POLICIES[policy](warehouse, slots) if slots else Route(0.0, (), ())


def check_layout(warehouse: AisleWarehouse, policy: str) -> str:
    """Return why a rule says nothing about a layout, empty where it does."""
    reason = ""
    if warehouse.blocks > 1 and policy in ONE_BLOCK:
        reason = f"is a policy for one block, the warehouse has {warehouse.blocks}"
    elif warehouse.closed_aisles or warehouse.closed_crossings:
        reason = "is a policy for open aisles, some are closed"
    elif warehouse.is_one_way:
        reason = "is a policy for aisles that are walked both ways, some are one-way"
    elif len(warehouse.doors) > 1:
        reason = "is a policy for a depot at one aisle"
    elif 0 < warehouse.depot_cross_aisle < warehouse.blocks:
        reason = "is a policy for a depot at the first or last cross aisle"
    return reason


def _walk(warehouse: AisleWarehouse, slots: Sequence[Slot], policy: str) -> Walk:
    """Return a picker at the depot of a layout that a policy is made for."""
    if reason := check_layout(warehouse, policy):
        raise InputError(f"{policy!r} {reason}", field="policy", advice="use shortest or as-given")
    return Walk(warehouse, slots)


Serve = Callable[[Walk, Mapping[int, Sequence[float]], float, float], None]
"""Serves what is left in a block (aisle to heights), given its front and its back."""


def _by_blocks(walk: Walk, serve: Serve) -> Route:
    """Go up the first aisle with picks to the farthest block, then serve block after block."""
    blocks = len(walk.heights) - 1
    filled = {block: picks for block in range(blocks) if (picks := walk.picks(block))}
    far = max(filled)
    walk.picked = range(far)
    walk.go(min(aisle for picks in filled.values() for aisle in picks), walk.heights[far])
    for block in range(far, -1, -1):
        walk.picked = range(block, block + 1)
        front, back = walk.heights[block : block + 2]
        if aisles := walk.picks(block):
            serve(walk, aisles, front, back)
        else:
            walk.go(walk.aisle, front)
    return walk.home()


def _from_nearer_end(walk: Walk, aisles: Mapping[int, object], front: float) -> list[int]:
    """Return the aisles of a block from the end where the picker comes in."""
    ordered = sorted(aisles)
    right_is_nearer = abs(ordered[-1] - walk.aisle) < abs(ordered[0] - walk.aisle)
    return ordered[::-1] if right_is_nearer and walk.y != front else ordered


def _finish(walk: Walk, aisle: int, heights: Sequence[float], front: float) -> None:
    """Serve the last aisle of a block and come to its front."""
    walk.go(aisle, *([max(heights)] if walk.y == front else []), front)


def _around(walk: Walk, cut: Callable[[Sequence[float], float, float], int]) -> Route:
    """Serve each block from its back and then from its front.

    Parameters
    ----------
    walk
        The picker.
    cut
        Of an aisle's picks, how many are picked from the front.
    """

    def serve(walk: Walk, aisles: Mapping[int, Sequence[float]], front: float, back: float) -> None:
        first = min(aisles)
        if walk.y == front:
            if len(aisles) == 1:
                _finish(walk, first, aisles[first], front)
                return
            walk.go(first, back)
            aisles = {aisle: aisles[aisle] for aisle in aisles if aisle != first}
        here = walk.aisle
        last = max(aisles, key=lambda aisle: (abs(aisle - here), aisle))
        parts = {a: (ys[: cut(ys, front, back)], ys[cut(ys, front, back) :])
                 for a, ys in aisles.items() if a != last}  # fmt: skip
        # First what lies behind the picker, then what lies on the way to the last aisle.
        for aisle in sorted(parts, key=lambda a: ((a - here) * (last - here) > 0, abs(a - here))):
            if behind := parts[aisle][1]:
                walk.go(aisle, behind[0], back)
        walk.go(last, front)
        for aisle in sorted(parts, key=lambda a: abs(a - last)):
            if before := parts[aisle][0]:
                walk.go(aisle, before[-1], front)

    if len(walk.heights) == 2:
        # On the way out to the first aisle, the fronts of those that are passed.
        front, back = walk.heights
        inner = list(walk.picks(0).items())[1:-1]
        for aisle, ys in reversed(inner):
            if aisle < walk.depot and (n := cut(ys, front, back)):
                walk.go(aisle, ys[n - 1], front)
    return _by_blocks(walk, serve)


def _serve_in_turn(
    walk: Walk,
    order: Sequence[int],
    aisles: Mapping[int, Sequence[float]],
    levels: Sequence[float],
    end: float,
) -> None:
    """Serve aisles in turn, leaving each at the cross aisle that makes the whole way shortest.

    Parameters
    ----------
    walk
        The picker, at one of the levels.
    order
        The aisles in sequence.
    aisles
        Heights of the picks of each.
    levels
        Heights of the cross aisles that lead from one to the next.
    end
        Where the picker comes out of the last one.
    """
    best = {walk.y: (0.0, [walk.y])}
    for aisle in order:
        low, high = min(aisles[aisle]), max(aisles[aisle])
        best = {
            leave: min(
                (cost + walked([_turns(enter, leave, low, high)]), [*before, leave])
                for enter, (cost, before) in best.items()
            )
            for leave in levels
        }
    for aisle, (enter, leave) in zip(order, pairwise(best[end][1]), strict=True):
        low, high = min(aisles[aisle]), max(aisles[aisle])
        walk.go(aisle, *(y for _, y in _turns(enter, leave, low, high)))


def _turns(enter: float, leave: float, low: float, high: float) -> tuple[XY, ...]:
    """Return where a picker turns in an aisle: from one height past two others to a fourth."""
    bottom, top = min(enter, leave, low), max(enter, leave, high)
    turns = (bottom, top) if enter <= leave else (top, bottom)
    return corners([(0.0, y) for y in (enter, *turns, leave)])


def _in_sequence(
    warehouse: AisleWarehouse, slots: Sequence[Slot], sequence: Sequence[int]
) -> Route:
    """Return the shortest ways from pick to pick."""
    places = [None, *(slots[i] for i in sequence), None]
    stops = [0, *(i + 1 for i in sequence), 0]
    length = float(warehouse.distance_matrix(slots)[stops[:-1], stops[1:]].sum())
    if len(stops) == 2 or length == inf:
        return Route(inf, (), ())
    legs = tuple(corners(warehouse.way(a, b)) for a, b in pairwise(places))
    return Route(length, tuple(sequence), legs)
