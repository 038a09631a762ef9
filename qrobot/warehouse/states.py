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

import numpy as np
import numpy.typing as npt

__all__ = ["MAX_CROSS_AISLES", "VERTICAL", "Steps", "Transitions", "transitions"]

MAX_CROSS_AISLES = 6
"""Layouts with more would need too many states (17,953 for seven)."""

VERTICAL = ("none", "pass", "twice", "front", "back", "both")
"""What a sub-aisle can be: not entered, passed once or twice, entered from the front, from the
back, or from both ends and left at the same end each. The first three pick nothing in passing
or everything, so they are all that an empty sub-aisle needs."""

Steps = npt.NDArray[np.int16]
"""Shape (steps, 3): state before, state after, choice; of one state after all together."""

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
    along
        For each block the steps by what its sub-aisle is, an index of `VERTICAL`.
    across
        For each cross aisle the steps by how often the segment to the next aisle is walked.
    visit
        For each cross aisle the steps to the states in which the tour is also at that crossing,
        where the depot is.
    """

    count: int
    begin: int
    done: int
    along: tuple[Steps, ...]
    across: tuple[Steps, ...]
    visit: tuple[Steps, ...]


@lru_cache(maxsize=MAX_CROSS_AISLES)
def transitions(cross_aisles: int) -> Transitions:
    """Return the states of a number of cross aisles and the steps between them."""
    nothing: Touched = ((False, 0),) * cross_aisles
    choices: list[tuple[Callable[[State, int, int], Iterator[State]], int, int]] = [
        *((_along, block, c) for block in range(cross_aisles - 1) for c in range(len(VERTICAL))),
        *((_across, cross, walks) for cross in range(cross_aisles) for walks in range(3)),
        *((_visit, cross, 0) for cross in range(cross_aisles)),
    ]
    index: dict[State, int] = {nothing: 0}
    waiting: list[State] = [nothing]
    found: dict[tuple[Callable[..., Iterator[State]], int], list[tuple[int, int, int]]] = {}
    while waiting:
        state = waiting.pop()
        for step, where, choice in choices:
            for after in step(state, where, choice):
                if after not in index:
                    index[after] = len(index)
                    waiting.append(after)
                found.setdefault((step, where), []).append((index[after], index[state], choice))
    return Transitions(
        count=len(index),
        begin=0,
        done=index[None],
        along=tuple(_table(found[_along, block]) for block in range(cross_aisles - 1)),
        across=tuple(_table(found[_across, cross]) for cross in range(cross_aisles)),
        visit=tuple(_table(found[_visit, cross]) for cross in range(cross_aisles)),
    )


def _table(steps: list[tuple[int, int, int]]) -> Steps:
    by_choice = sorted(steps, key=lambda step: step[::-1])
    return np.array([(before, after, choice) for after, before, choice in by_choice], np.int16)


def _named(state: list[tuple[bool, int]]) -> Touched:
    """Return a state with its components numbered as they appear."""
    names = {0: 0}
    return tuple((odd, names.setdefault(part, len(names))) for odd, part in state)


def _along(state: State, block: int, choice: int) -> Iterator[State]:
    """Yield what a sub-aisle makes of a state."""
    kind = VERTICAL[choice]
    if kind == "none":
        yield state
        return
    if state is None:
        return
    ends = [*state]
    reached = {"front": (block,), "back": (block + 1,)}.get(kind, (block, block + 1))
    for end in reached:
        odd, part = ends[end]
        ends[end] = (odd != (kind == "pass"), part or -1 - end)
    if kind == "twice" and ends[block][1] == ends[block + 1][1]:
        return  # connected already: entering from one end costs less
    if kind in ("pass", "twice"):
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


def _visit(state: State, cross: int, _: int) -> Iterator[State]:
    """Yield the state that is also at a crossing."""
    if state is not None:
        ends = [*state]
        ends[cross] = (ends[cross][0], ends[cross][1] or -1)
        yield _named(ends)
