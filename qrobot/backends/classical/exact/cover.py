"""Choose trips so that everything is collected exactly once: set partition, proven.

Three steps. A Lagrangian bound over the explicit columns gives prices; columns whose
reduced cost shows that no better plan uses them are dropped; CP-SAT solves what is left
and proves it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot.backends.base import Stop
from qrobot.backends.classical.cpsat import new_solver, solve

__all__ = ["Cover", "Prices", "cheapest_cover", "lagrangian"]


@dataclass(frozen=True, slots=True)
class Prices:
    """What pricing leaves of a set partition.

    Parameters
    ----------
    bound
        A valid lower bound of the cost of every cover that is cheaper than the known one.
    rows
        Columns that such a cover may use.
    """

    bound: float
    rows: npt.NDArray[np.intp]


def lagrangian(
    masks: Ints,
    costs: Floats,
    elements: int,
    trips: tuple[int, int],
    upper: float,
    stop: Callable[[], bool],
    rounds: int = 400,
) -> Prices:
    """Price the elements by subgradient steps (Held, Wolfe and Crowder 1974).

    With prices on the elements, a cover that uses column c costs at least the sum of the
    prices, plus c's reduced cost, plus the least reduced cost for each other trip. Columns
    for which that reaches `upper` are dropped on the way.

    Parameters
    ----------
    masks, costs
        Columns, shape (N,).
    elements
        Number of elements n.
    trips
        Least and most number of trips in a cover.
    upper
        Cost of a known cover, or ``inf``.
    stop
        Asked every round.
    rounds
        Most rounds.
    """
    member = ((masks[:, None] >> np.arange(elements)) & 1).astype(np.float64)
    fewest, most = trips
    rows = np.arange(len(masks))
    prices = np.zeros(elements)
    target = upper if np.isfinite(upper) else float(np.median(costs)) * most
    best, step, stale = 0.0, 1.0, 0
    for round_ in range(rounds):
        if stop() or not len(rows):
            break
        reduced = costs - member @ prices
        least = float(reduced.min())
        used = most if least < 0 else fewest
        bound = float(prices.sum()) + used * least
        if bound > best + 1e-9 * abs(best):
            best, stale = bound, 0
            # 1e-9: a column is dropped only if rounding cannot be the reason.
            kept = bound - least + reduced < upper * (1 + 1e-9)
            if round_ % 10 == 0 or kept.mean() < 0.8:
                rows, member, costs, reduced = rows[kept], member[kept], costs[kept], reduced[kept]
                if not len(rows):
                    break
        elif (stale := stale + 1) == 10:
            step, stale = step / 2, 0
            if step < 1e-4:
                break
        # Average over the cheapest columns: a smoother direction than one column's.
        near = np.argpartition(reduced, min(most, len(reduced)) - 1)[:most]
        slope = 1.0 - used * member[near].mean(axis=0)
        length = float(slope @ slope)
        if length < 1e-12:
            break
        prices = prices + step * max(target - bound, 1e-3 * abs(target)) / length * slope
    return Prices(min(best, upper), rows)


@dataclass(frozen=True, slots=True)
class Cover:
    """What the set partition found.

    Parameters
    ----------
    rows
        Rows of the chosen columns, or ``None`` when no cover better than the known one
        exists or was found in time.
    complete
        True when the search ended by itself: ``rows`` is optimal, or nothing better exists.
    bound
        A valid lower bound, in the unit of the costs.
    """

    rows: list[int] | None
    complete: bool
    bound: float


def cheapest_cover(
    masks: Ints,
    costs: npt.NDArray[np.int64],
    loads: npt.NDArray[np.int64],
    elements: int,
    capacities: npt.NDArray[np.int64],
    stop: Stop,
    seed: int,
) -> Cover:
    """Choose disjoint columns that cover all elements at the least cost, with CP-SAT.

    Parameters
    ----------
    masks, costs, loads
        Columns, shape (N,); whole costs.
    elements
        Number of elements.
    capacities
        Capacity of each possible trip, largest first.
    stop
        Deadline and interrupts. A work limit becomes CP-SAT's deterministic time.
    seed
        Of the solver.

    Raises
    ------
    MissingExtraError
        When OR-Tools is not installed.
    """
    if stop():
        return Cover(None, False, 0.0)
    solver = new_solver("the set partition of backend exact")
    chosen = [solver.BoolVar("") for _ in range(len(masks))]
    for e in range(elements):
        once = solver.Constraint(1, 1)
        for row in np.flatnonzero(masks & (1 << e)):
            once.SetCoefficient(chosen[row], 1)
    # Trips heavier than c need robots larger than c; that is enough, because capacities
    # are nested: the heaviest trips go to the largest robots.
    for threshold in [-1, *sorted(set(capacities.tolist()))[:-1]]:
        enough = solver.Constraint(0, int((capacities > threshold).sum()))
        for row in np.flatnonzero(loads > threshold):
            enough.SetCoefficient(chosen[row], 1)
    objective = solver.Objective()
    for column, cost in enumerate(costs.tolist()):
        objective.SetCoefficient(chosen[column], cost)
    objective.SetMinimization()
    ended = solve(solver, stop, seed)
    if ended == solver.INFEASIBLE:
        return Cover(None, True, float("inf"))
    if ended not in (solver.OPTIMAL, solver.FEASIBLE):
        return Cover(None, False, 0.0)
    rows = [column for column, variable in enumerate(chosen) if variable.solution_value() > 0.5]
    return Cover(rows, ended == solver.OPTIMAL, float(objective.BestBound()))
