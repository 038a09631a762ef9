"""The sweep over the columns in numpy: the least cost of every state, and how it was reached.

`kernels` has the same sweep for numba, which finds the length alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.warehouse.states import PLAIN, VERTICAL, Steps, transitions

__all__ = ["Door", "Ends", "Flat", "Inside", "Numbers", "flatten", "sweep"]

Numbers = npt.NDArray[np.int64]


class Ends(Enum):
    """Where a tour starts and ends.

    ``DOOR``: it starts and ends at one crossing. ``DOORS``: it leaves the depot by one of several
    ways and comes back by one of them. ``APART``: its start and its end are two places.
    """

    DOOR = "door"
    DOORS = "doors"
    APART = "apart"


LAYERS = {Ends.DOOR: (0,), Ends.DOORS: (0, 1, 2), Ends.APART: (0, 1, 1, 2)}
"""The sweep keeps the states once for each set of ends that the tour has taken so far: this is
how many of them each has. (Start and end of a tour from the depot are not told apart.)"""

Leads = tuple[tuple[int, int], ...]

STARTING: Leads = ((0, 1), (2, 3))
ENDING: Leads = ((0, 2), (1, 3))
BOTH: Leads = ((0, 3),)
"""From which layer to which the start, the end, or both at once of ``APART`` lead."""


class Door(NamedTuple):
    """A crossing that a way leads to from a place where a tour starts or ends.

    Parameters
    ----------
    column, cross
        The crossing.
    length
        Metres of the way.
    end
        Where start and end are apart: 0 for the start, 1 for the end.
    """

    column: int
    cross: int
    length: float
    end: int = 0


class Inside(NamedTuple):
    """A sub-aisle in which a tour starts, ends, or both.

    Parameters
    ----------
    end
        0 for the start, 1 for the end, 2 for both.
    prices
        What each of `states.VERTICAL` costs, metres.
    """

    end: int
    prices: Floats


NOWHERE: Mapping[tuple[int, int], Inside] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Flat:
    """The steps of a number of cross aisles as plain arrays.

    Parameters
    ----------
    count, begin, done
        Number of states; the first and the last.
    steps
        Shape (all, 3): before, after, choice.
    starts
        Where the steps of each group begin, then the end. Groups are each sub-aisle, each
        segment, a door at each crossing; of ``APART`` the doors are those of the start, and
        then come doors of the end, and each sub-aisle with the start, the end or both in it.
    marks
        Shape (blocks, 2): where the steps of each sub-aisle that enter it begin, and where those
        that leave it at the end they entered it from.
    """

    count: int
    begin: int
    done: int
    steps: Numbers
    starts: Numbers
    marks: Numbers


@cache
def flatten(cross_aisles: int, ends: Ends = Ends.DOOR) -> Flat:
    """Return the steps of a number of cross aisles as plain arrays."""
    table = transitions(cross_aisles, apart=ends is not Ends.DOOR)
    layers, index, count = LAYERS[ends], [], 0
    for taken in layers:
        kept = table.loose <= taken
        kept &= table.loose % 2 == taken % 2
        index.append(np.where(kept, count + np.cumsum(kept) - 1, -1))
        count += int(kept.sum())

    def lead(steps: Steps, choices: Sequence[int], pairs: Sequence[tuple[int, int]]) -> Numbers:
        """Return the steps of some choices from layers to layers."""
        chosen = steps[np.isin(steps[:, 2], choices)].astype(np.int64)
        parts = [
            np.column_stack([index[a][chosen[:, 0]], index[b][chosen[:, 1]], chosen[:, 2]])
            for a, b in pairs
        ]
        found = np.vstack(parts)
        found = found[(found[:, :2] >= 0).all(axis=1)]
        return found[np.argsort(found[:, 2], kind="stable")]

    same = [(layer, layer) for layer in range(len(layers))]
    groups = [lead(steps, range(PLAIN), same) for steps in table.along]
    groups += [lead(steps, range(3), same) for steps in table.across]
    stay = np.column_stack([np.arange(count), np.arange(count), np.zeros(count)]).astype(np.int64)
    if ends is Ends.DOOR:
        groups += [lead(steps, (2,), same) for steps in table.door]
    elif ends is Ends.DOORS:
        groups += [
            np.vstack([stay, lead(door, (1,), ((0, 1), (1, 2))), lead(door, (2,), ((0, 2),))])
            for door in table.door
        ]
    else:
        for pairs in (STARTING, ENDING):
            groups += [np.vstack([stay, lead(door, (1,), pairs)]) for door in table.door]
        for pairs in (STARTING, ENDING, BOTH):
            groups += [lead(steps, range(len(VERTICAL)), pairs) for steps in table.along]
    starts = np.cumsum([0, *map(len, groups)])
    marks = [np.searchsorted(groups[block][:, 2], (1, 3)) for block in range(len(table.along))]
    return Flat(
        count,
        int(index[0][table.begin]),
        int(index[-1][table.done]),
        np.vstack(groups),
        starts,
        np.array(marks, dtype=np.int64) + starts[: len(marks), None],
    )


def sweep(
    costs: Floats,
    across: Floats,
    doors: Sequence[Door],
    columns: tuple[int, int],
    *,
    ends: Ends = Ends.DOOR,
    inside: Mapping[tuple[int, int], Inside] = NOWHERE,
    choices: bool = False,
) -> tuple[float, list[int]]:
    """Return the length of a shortest tour, and its choices where asked, in numpy.

    Parameters
    ----------
    costs
        Shape (columns, blocks, 6), from `part_costs`.
    across
        Shape (columns - 1, cross aisles).
    doors
        Where the tour may start and end.
    columns
        First and last column that the tour may use.
    ends
        What the doors are.
    inside
        The sub-aisles ``(column, block)`` in which start or end is; only where they are apart.
    choices
        Whether to return them: for each column how often the way of each of its doors is
        walked, a choice for each sub-aisle, then the walks on each segment to the next column.
    """
    blocks = costs.shape[1]
    flat = flatten(blocks + 1, ends)
    now = np.full(flat.count, np.inf)
    now[flat.begin] = 0.0
    kept: list[Numbers] = []

    def take(group: int, prices: Floats) -> None:
        """Take each state's cheapest step of a group."""
        nonlocal now
        steps = flat.steps[flat.starts[group] : flat.starts[group + 1]]
        total, after = now[steps[:, 0]] + prices[steps[:, 2]], steps[:, 1]
        now = np.full(flat.count, np.inf)
        np.minimum.at(now, after, total)
        if choices:
            came = np.full((flat.count, 2), -1, dtype=np.int64)
            best = np.flatnonzero(total == now[after])[::-1]  # of equal ones the first is kept
            came[after[best]] = steps[best][:, [0, 2]]
            kept.append(came)

    for column in range(columns[0], columns[1] + 1):
        for door in doors:
            if door.column == column:
                group = 2 * blocks + 1 + door.end * (blocks + 1) + door.cross
                take(group, np.array([0.0, door.length, 2 * door.length]))
        for block in range(blocks):
            if here := inside.get((column, block)):
                take((4 + here.end) * blocks + 3 + block, here.prices)
            else:
                take(block, costs[column, block])
        for cross in range(blocks + 1):
            length = across[column, cross] if column < columns[1] else np.inf
            take(blocks + cross, np.array([0.0, length, 2 * length]))
    length, found = float(now[flat.done]), []
    if choices and np.isfinite(length):
        state = flat.done
        for came in reversed(kept):
            state, choice = came[state].tolist()
            found.append(choice)
    return length, found[::-1]
