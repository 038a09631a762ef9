"""The sweep over the columns in numpy: the least cost of every state, and how it was reached.

`kernels` has the same sweep for numba, which finds the length alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats
from qrobot.warehouse.states import Steps, transitions

__all__ = ["Flat", "flatten", "sweep"]

Numbers = npt.NDArray[np.int64]


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
        Where the steps of each sub-aisle begin, then those of each segment, then those of the
        depot at each crossing, then the end.
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
def flatten(cross_aisles: int) -> Flat:
    """Return the steps of a number of cross aisles as plain arrays."""
    table = transitions(cross_aisles)
    groups: tuple[Steps, ...] = (*table.along, *table.across, *table.visit)
    starts = np.cumsum([0, *map(len, groups)])
    marks = [np.searchsorted(steps[:, 2], (1, 3)) for steps in table.along]
    return Flat(
        table.count,
        table.begin,
        table.done,
        np.vstack(groups).astype(np.int64),
        starts,
        np.array(marks, dtype=np.int64) + starts[: len(marks), None],
    )


def sweep(
    costs: Floats,
    across: Floats,
    depot: tuple[int, int],
    columns: tuple[int, int],
    *,
    choices: bool = False,
) -> tuple[float, list[int]]:
    """Return the length of a shortest tour, and its choices where asked, in numpy.

    Parameters
    ----------
    costs
        Shape (columns, blocks, 6), from `part_costs`.
    across
        Shape (columns - 1, cross aisles).
    depot
        Column and cross aisle.
    columns
        First and last column that the tour may use.
    choices
        Whether to return them: for each column a choice for each sub-aisle, then the walks
        on each segment to the next column.
    """
    blocks = costs.shape[1]
    flat = flatten(blocks + 1)
    now = np.full(flat.count, np.inf)
    now[flat.begin] = 0.0
    kept: list[Numbers] = []

    def take(group: int, prices: Floats) -> None:
        """Take each state's cheapest step of a group."""
        nonlocal now
        steps = flat.steps[flat.starts[group] : flat.starts[group + 1]]
        total = now[steps[:, 0]] + prices[steps[:, 2]]
        order = np.lexsort((total, steps[:, 1]))
        best = order[np.flatnonzero(np.diff(steps[order, 1], prepend=-1))]
        now = np.full(flat.count, np.inf)
        now[steps[best, 1]] = total[best]
        if choices:
            came = np.full((flat.count, 2), -1, dtype=np.int64)
            came[steps[best, 1]] = steps[best][:, [0, 2]]
            kept.append(came)

    for column in range(columns[0], columns[1] + 1):
        if column == depot[0]:
            take(2 * blocks + 1 + depot[1], np.zeros(1))
        for block in range(blocks):
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
