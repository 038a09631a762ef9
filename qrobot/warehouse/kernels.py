"""The sweep over the columns for numba. Importing this module imports numba.

Functions that call each other are in one file: numba's cache looks at its date only.
"""

from __future__ import annotations

import numpy as np

from qrobot._arrays import Floats
from qrobot._jit import compile_kernel
from qrobot.warehouse.sweep import Numbers

__all__ = ["sweep_length"]


def _relax(now: Floats, then: Floats, steps: Numbers, first: int, end: int, prices: Floats) -> None:
    """Set the least cost of every state after some steps."""
    then[:] = np.inf
    for k in range(first, end):
        cost = now[steps[k, 0]] + prices[steps[k, 2]]
        if cost < then[steps[k, 1]]:
            then[steps[k, 1]] = cost


_relax = compile_kernel(_relax)


def _sweep_length(
    costs: Floats,
    across: Floats,
    depot: tuple[int, int],
    columns: tuple[int, int],
    ends: tuple[int, int],
    steps: Numbers,
    starts: Numbers,
    now: Floats,
    then: Floats,
) -> float:
    """Return the length of a shortest tour.

    Parameters
    ----------
    costs
        Shape (columns, blocks, 6).
    across
        Shape (columns - 1, cross aisles).
    depot
        Column and cross aisle.
    columns
        First and last column that the tour may use.
    ends
        First and last state.
    steps, starts
        As in `sweep.Flat`.
    now, then
        Room for the costs of all states.
    """
    blocks = costs.shape[1]
    now[:] = np.inf
    now[ends[0]] = 0.0
    prices = np.zeros(3)
    for column in range(columns[0], columns[1] + 1):
        if column == depot[0]:
            group = 2 * blocks + 1 + depot[1]
            prices[0] = 0.0
            _relax(now, then, steps, starts[group], starts[group + 1], prices)
            now, then = then, now
        for group in range(blocks):
            _relax(now, then, steps, starts[group], starts[group + 1], costs[column, group])
            now, then = then, now
        for cross in range(blocks + 1):
            length = across[column, cross] if column < columns[1] else np.inf
            prices[1], prices[2] = length, 2 * length
            _relax(now, then, steps, starts[blocks + cross], starts[blocks + cross + 1], prices)
            now, then = then, now
    return float(now[ends[1]])


sweep_length = compile_kernel(_sweep_length)
