"""CP-SAT by OR-Tools' plain wrapper, with interrupts and repeatable limits of work.

The modelling layer `cp_model` would import pandas (50 MB and seconds on a Pi); the wrapper
does not.
"""

from __future__ import annotations

import threading
from typing import Any

from qrobot._extras import load
from qrobot.backends.base import Stop

__all__ = ["new_solver", "run", "solve"]

POLL = 0.05
"""Seconds between looks at interrupts."""

LONGEST = 1e6
"""Seconds; longer limits are none, and would not fit CP-SAT's milliseconds."""


def new_solver(what: str, name: str = "SAT") -> Any:
    """Return an empty model of CP-SAT, or of another solver of OR-Tools.

    Parameters
    ----------
    what
        Who asks, for the error.
    name
        Of the solver, as the wrapper knows it.

    Raises
    ------
    MissingExtraError
        When OR-Tools is not installed.
    """
    return load("ortools.linear_solver.pywraplp", what).Solver.CreateSolver(name)


def solve(solver: Any, stop: Stop, seed: int) -> int:
    """Solve a model on one worker until it is done or `stop` says so.

    Parameters
    ----------
    solver
        From `new_solver`.
    stop
        Deadline and interrupts. A work limit becomes deterministic time, a thousandth of
        CP-SAT's deterministic second each.
    seed
        Of the solver.

    Returns
    -------
    int
        The wrapper's status: ``solver.OPTIMAL``, ``FEASIBLE``, ``INFEASIBLE`` or
        ``NOT_SOLVED``.
    """
    parameters = f"num_workers:1 random_seed:{seed % 2**31}"
    if stop.max_work is not None:
        parameters += f" max_deterministic_time:{max(stop.max_work, 1) / 1000}"
    solver.SetSolverSpecificParametersAsString(parameters)
    return run(solver, stop)


def run(solver: Any, stop: Stop) -> int:
    """Solve a model with the parameters it has, until it is done or `stop` says so."""
    if stop.remaining < LONGEST:
        solver.SetTimeLimit(max(1, int(1000 * stop.remaining)))
    status: list[int] = []
    # Solve releases the interpreter, so this thread can watch for interrupts.
    worker = threading.Thread(target=lambda: status.append(solver.Solve()), daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(POLL)
        if stop.remaining <= 0:
            solver.InterruptSolve()
    return status[0] if status else int(solver.NOT_SOLVED)
