"""What a part of a tour looks like from the aisle that a sweep has reached.

Ratliff and Rosenthal (1983) build a shortest tour aisle by aisle: of all ways to walk through the
aisles so far, only what the rest of the tour can see matters. That is, for each crossing of the
last aisle, whether it was reached and by an even or odd number of walks, and which of the
crossings are connected. Roodbergen and de Koster (2001) and Pansart et al. (2018) did so for more
cross aisles. Here the aisle is left edge by edge, so that each step has at most six choices.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = [
    "MAX_CROSS_AISLES",
    "PLAIN",
    "VERTICAL",
    "Steps",
    "Transitions",
    "Vertical",
    "transitions",
]

MAX_CROSS_AISLES = 6
"""Layouts with more would need too many states (17,953 for seven)."""


class Vertical(NamedTuple):
    """What a sub-aisle can be.

    Parameters
    ----------
    front, back
        The walks at its front and its back end: none (0), an odd (1) or an even number (2).
    joined
        Whether the walks in it connect both ends; with none at either end, whether they are the
        whole tour.
    """

    front: int
    back: int
    joined: bool = False


VERTICAL = (
    Vertical(0, 0),
    Vertical(1, 1, True),
    Vertical(2, 2, True),
    Vertical(2, 0),
    Vertical(0, 2),
    Vertical(2, 2),
    Vertical(1, 0),
    Vertical(1, 2),
    Vertical(1, 2, True),
    Vertical(0, 1),
    Vertical(2, 1),
    Vertical(2, 1, True),
    Vertical(1, 1),
    Vertical(0, 0, True),
)
"""Not entered, passed once or twice, entered from the front, from the back, or from both ends and
left at the same end each; then what is possible only where a tour starts or ends. The first three
pick nothing in passing or everything, so they are all that an empty sub-aisle needs."""

PLAIN = 6
"""How many of them are possible anywhere."""

Steps = npt.NDArray[np.int32]
"""Shape (steps, 3): state before, state after, choice; by choice, then by state after."""

Touched = tuple[tuple[bool, int], ...]
"""For each crossing whether its number of walks is odd, and its component; component 0 means
that nothing leads there."""

State = Touched | None
"""None is the finished tour."""


@dataclass(frozen=True, slots=True)
class Transitions:
    """All states of a number of cross aisles, and how choices lead from one to another.

    Parameters
    ----------
    count
        Number of states.
    begin, done
        Index of the state before anything is reached, and of the finished tour.
    loose
        For each state the number of components in which an odd number of crossings is odd: so
        many ends of the tour are in it without the other.
    along
        For each block the steps by what its sub-aisle is, an index of `VERTICAL`.
    across
        For each cross aisle the steps by how often the segment to the next aisle is walked.
    door
        For each cross aisle the steps by how often a way from there to the depot is walked: twice,
        where ends of the tour are told apart also once.
    """

    count: int
    begin: int
    done: int
    loose: npt.NDArray[np.int32]
    along: tuple[Steps, ...]
    across: tuple[Steps, ...]
    door: tuple[Steps, ...]


@lru_cache(maxsize=2 * MAX_CROSS_AISLES)
def transitions(cross_aisles: int, *, apart: bool = False) -> Transitions:
    """Return the states of a number of cross aisles and the steps between them.

    Parameters
    ----------
    cross_aisles
        How many.
    apart
        Whether the two ends of a tour can be at different crossings.
    """
    nothing: Touched = ((False, 0),) * cross_aisles
    kinds = range(len(VERTICAL) if apart else PLAIN)
    choices: list[tuple[Callable[[State, int, int], Iterator[State]], int, int]] = [
        *((_along, block, c) for block in range(cross_aisles - 1) for c in kinds),
        *((_across, cross, walks) for cross in range(cross_aisles) for walks in range(3)),
        *((_door, cross, walks) for cross in range(cross_aisles) for walks in (1, 2)[not apart :]),
    ]
    index: dict[State, int] = {nothing: 0}
    waiting: list[State] = [nothing]
    found: dict[tuple[Callable[..., Iterator[State]], int], list[tuple[int, int, int]]] = {}
    while waiting:
        state = waiting.pop()
        for step, where, choice in choices:
            for after in step(state, where, choice):
                if after not in index:
                    if _loose(after) > 2:  # a tour has two ends
                        continue
                    index[after] = len(index)
                    waiting.append(after)
                found.setdefault((step, where), []).append((index[after], index[state], choice))
    return Transitions(
        count=len(index),
        begin=0,
        done=index[None],
        loose=np.array([_loose(state) for state in index], np.int32),
        along=tuple(_table(found[_along, block]) for block in range(cross_aisles - 1)),
        across=tuple(_table(found[_across, cross]) for cross in range(cross_aisles)),
        door=tuple(_table(found[_door, cross]) for cross in range(cross_aisles)),
    )


def _table(steps: list[tuple[int, int, int]]) -> Steps:
    by_choice = sorted(steps, key=lambda step: step[::-1])
    return np.array([(before, after, choice) for after, before, choice in by_choice], np.int32)


def _loose(state: State) -> int:
    """Return the number of components in which an odd number of crossings is odd."""
    loose: set[int] = set()
    for odd, part in state or ():
        if odd:
            loose ^= {part}
    return len(loose)


def _named(state: list[tuple[bool, int]]) -> Touched:
    """Return a state with its components numbered as they appear."""
    names = {0: 0}
    return tuple((odd, names.setdefault(part, len(names))) for odd, part in state)


def _along(state: State, block: int, choice: int) -> Iterator[State]:
    """Yield what a sub-aisle makes of a state."""
    kind = VERTICAL[choice]
    if kind == (0, 0, False):
        yield state
        return
    if state is None:
        return
    if kind == (0, 0, True):
        if not any(part for _, part in state):
            yield None
        return
    ends = [*state]
    for end, walks in ((block, kind.front), (block + 1, kind.back)):
        if walks:
            odd, part = ends[end]
            ends[end] = (odd != (walks == 1), part or -1 - end)
    if kind == (2, 2, True) and ends[block][1] == ends[block + 1][1]:
        return  # connected already: entering from one end costs less
    if kind.joined:
        old, new = ends[block + 1][1], ends[block][1]
        ends = [(odd, new if part == old else part) for odd, part in ends]
    yield _named(ends)


def _across(state: State, cross: int, walks: int) -> Iterator[State]:
    """Yield what the segment of a cross aisle to the next aisle makes of a state."""
    if state is None:
        if not walks:
            yield None
        return
    odd, part = state[cross]
    if not part:
        if not walks:  # more would lead to a crossing that has nothing
            yield state
    elif odd:
        if walks == 1:
            yield state
    elif walks == 2:
        yield state
    elif walks == 0:
        rest = [*state]
        rest[cross] = (False, 0)
        if any(p == part for _, p in rest):
            yield _named(rest)
        elif not any(p for _, p in rest):
            yield None


def _door(state: State, cross: int, walks: int) -> Iterator[State]:
    """Yield what a way from a crossing to the depot makes of a state."""
    if state is not None:
        ends = [*state]
        odd, part = ends[cross]
        ends[cross] = (odd != (walks == 1), part or -1)
        yield _named(ends)
