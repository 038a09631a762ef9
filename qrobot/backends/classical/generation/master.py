"""The linear programme of a set partition: some batches, each order once, the robots there are.

After Wahlen and Gschwind (2023), whose branch-price-and-cut is the reference for order batching;
subset-row cuts after Jepsen et al. (2008).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot._extras import load
from qrobot.backends.classical.generation.cuts import Cut
from qrobot.backends.classical.orders import Batch

__all__ = ["Master", "Pairs"]

Members = npt.NDArray[np.signedinteger[Any]]
"""Shape (batches, width): orders, -1 after the last."""

Pairs = tuple[tuple[int, int], ...]


class Master:
    """A set partition over the batches that it was given so far; fractions of batches allowed.

    Parameters
    ----------
    orders
        How many.
    trips
        Least and most trips.
    fleet
        Rows (load, trips): at most so many batches are heavier than this load.
    outside
        What an order costs that no batch holds.

    Raises
    ------
    MissingExtraError
        When OR-Tools is not installed.
    """

    def __init__(
        self, orders: int, trips: tuple[int, int], fleet: list[tuple[int, int]], outside: float
    ) -> None:
        tool = load("ortools.linear_solver.pywraplp", "backend exact")
        self._solver = tool.Solver.CreateSolver("CLP")
        # Without presolve each programme goes on from the basis of the one before.
        self._parameters = tool.MPSolverParameters()
        self._parameters.SetIntegerParam(self._parameters.PRESOLVE, self._parameters.PRESOLVE_OFF)
        self._objective = self._solver.Objective()
        self._rows = [self._solver.Constraint(1.0, 1.0) for _ in range(orders)]
        self._fleet = [(load, self._solver.Constraint(0.0, float(most))) for load, most in fleet]
        self._trips = self._solver.Constraint(float(trips[0]), float(trips[1]))
        self._outside = outside
        self._batches: list[Any] = []
        self._of: list[Batch] = []
        self._index: set[Batch] = set()
        self._costs: list[float] = []
        self._loads: list[int] = []
        self._shut: set[int] = set()
        self.cuts: list[Cut] = []
        self._cut_rows: list[Any] = []
        for row in self._rows:
            absent = self._solver.NumVar(0.0, 1.0, "")
            row.SetCoefficient(absent, 1.0)
            self._objective.SetCoefficient(absent, outside)
        for sign in (1.0, -1.0):  # with too few batches, no plan of so many trips may exist yet
            missing = self._solver.NumVar(0.0, self._solver.infinity(), "")
            self._trips.SetCoefficient(missing, sign)
            self._objective.SetCoefficient(missing, outside)

    def __len__(self) -> int:
        """Return how many batches take part."""
        return len(self._batches)

    def add(self, members: Members, costs: Floats, loads: Ints) -> int:
        """Add batches that are not there yet; return how many were new."""
        before = len(self)
        for row, cost, weight in zip(members.tolist(), costs.tolist(), loads.tolist(), strict=True):
            batch = tuple(order for order in row if order >= 0)
            if batch in self._index:
                continue
            variable = self._solver.NumVar(0.0, self._solver.infinity(), "")
            self._index.add(batch)
            self._of.append(batch)
            self._costs.append(cost)
            self._loads.append(weight)
            self._batches.append(variable)
            self._objective.SetCoefficient(variable, cost)
            self._trips.SetCoefficient(variable, 1.0)
            for order in batch:
                self._rows[order].SetCoefficient(variable, 1.0)
            for limit, fleet_row in self._fleet:
                if weight > limit:
                    fleet_row.SetCoefficient(variable, 1.0)
            for cut, cut_row in zip(self.cuts, self._cut_rows, strict=True):
                if times := cut.counts(batch):
                    cut_row.SetCoefficient(variable, float(times))
        return len(self) - before

    def cut(self, cuts: list[Cut]) -> None:
        """Add cuts."""
        for cut in cuts:
            row = self._solver.Constraint(0.0, float(cut.most))
            for variable, batch in zip(self._batches, self._of, strict=True):
                if times := cut.counts(batch):
                    row.SetCoefficient(variable, float(times))
            self.cuts.append(cut)
            self._cut_rows.append(row)

    def restrict(
        self, trips: tuple[int, int], lightest: int, together: Pairs, apart: Pairs
    ) -> None:
        """Allow only plans of so many trips of so much load, with pairs together or apart."""
        self._trips.SetBounds(float(trips[0]), float(trips[1]))
        shut = set()
        for at, batch in enumerate(self._of):
            split = self._loads[at] < lightest or any(
                (i in batch) != (j in batch) for i, j in together
            )
            if split or any(i in batch and j in batch for i, j in apart):
                shut.add(at)
        for at in shut - self._shut:
            self._batches[at].SetUb(0.0)
        for at in self._shut - shut:
            self._batches[at].SetUb(self._solver.infinity())
        self._shut = shut

    def solve(self) -> float:
        """Solve; return a lower bound of the least cost, that cost but for rounding.

        The bound is what the duals say, so that it is valid whatever the solver says.
        """
        self._solver.Solve(self._parameters)
        orders, fleet, cuts = self.prices
        low, high = self._trips.lb(), self._trips.ub()
        return float(
            np.minimum(orders, self._outside).sum()
            + sum(p * row.ub() for p, (_, row) in zip(fleet, self._fleet, strict=True))
            + sum(p * row.ub() for p, row in zip(cuts, self._cut_rows, strict=True))
            + self.trip_price * (low if self.trip_price > 0.0 else high)
        )

    @property
    def prices(self) -> tuple[Floats, Floats, Floats]:
        """Duals of the orders, and those of the fleet's rows and of the cuts, at most 0."""
        return (
            np.array([row.dual_value() for row in self._rows]),
            np.array([min(0.0, row.dual_value()) for _, row in self._fleet]),
            np.array([min(0.0, row.dual_value()) for row in self._cut_rows]),
        )

    @property
    def trip_price(self) -> float:
        """Dual of the number of trips."""
        return float(self._trips.dual_value())

    def used(self) -> tuple[list[Batch], Floats]:
        """Return the batches with a share above 0, and their shares."""
        values = np.array([variable.solution_value() for variable in self._batches])
        rows = np.flatnonzero(values > 1e-7)
        return [self._of[row] for row in rows], values[rows]

    def cheapest(self, most: int, width: int) -> tuple[Members, Floats, Ints]:
        """Return the batches of least reduced cost: orders, costs and loads."""
        reduced = np.array([variable.reduced_cost() for variable in self._batches])
        rows = np.argsort(reduced, kind="stable")[:most].tolist()
        members = np.full((len(rows), width), -1, dtype=np.int16)
        for at, row in enumerate(rows):
            members[at, : len(self._of[row])] = self._of[row]
        return (
            members,
            np.array([self._costs[row] for row in rows]),
            np.array([self._loads[row] for row in rows], dtype=np.int64),
        )
