"""The strategy of ``backend="auto"``: the best plan that software and deadline allow.

Small instances are proven at once by the subset dynamic programme. Where all fitting sets
can be enumerated, a short search gives a first plan and the set partition proves or
improves it. Everything else is searched until the deadline, with a bound beside it.
"""

from __future__ import annotations

import importlib.util
import math

from qrobot.backends import Planner, Stop, available, get
from qrobot.backends.exact import ExactPlanner, no_packing, pack
from qrobot.backends.exact.partition import MAX_ELEMENTS
from qrobot.planning.bounds import forest_bound, quick_bound, walk_bound
from qrobot.planning.run import Run
from qrobot.problem import Instance

__all__ = ["bound_from_below", "choose_search", "run_auto"]

FIRST_SHARE, FIRST_SECONDS, FIRST_WORK = 0.1, 0.5, 5
"""The first search gets a tenth of the time, at most half a second, or a fifth of the work."""

BOUND_SHARE, BOUND_SECONDS = 0.07, 2.0
"""The bound of large instances gets a fourteenth of the time, at most two seconds."""

PACKING_SHARE = 0.3
"""A search that found no plan in this share of the time gets a packing to start from."""


def choose_search(instance: Instance) -> Planner:
    """Return the best search that is installed and keeps what must stay together."""
    name = "pyvrp" if available("pyvrp") and not instance.whole_orders else "batching"
    planner = get(name)
    assert isinstance(planner, Planner)
    return planner


def run_auto(run: Run) -> None:
    """Find the best plan for a run's instance within its stop."""
    exact = ExactPlanner()
    small = exact.fits(run.instance)
    if small and len(run.instance.orders) <= MAX_ELEMENTS:
        run.plan(exact, run.stop)
        if run.finished:
            return
    search = choose_search(run.instance)
    _first_plan(run, search)
    if small and _has_cp_sat() and not run.finished:
        run.plan(exact, run.stop)
    if run.finished or run.stop():
        bound_from_below(run)
        return
    bound_from_below(run)
    if not run.finished:
        run.plan(search, run.stop)


def _first_plan(run: Run, search: Planner) -> None:
    """Search for a short while; without any plan then, pack first and search from there."""
    run.plan(search, _part(run.stop, FIRST_SHARE, FIRST_SECONDS))
    if run.routes is None and not run.stop():
        run.plan(search, _part(run.stop, PACKING_SHARE, math.inf))
    if run.routes is None and not run.stop():
        run.begin("packing")
        with run.timed("run"):
            routes, impossible = pack(run.instance, run.stop, run.seed)
        if routes is not None:
            run.offer(routes)
        elif impossible:
            run.infeasible = no_packing(run.instance)


def bound_from_below(run: Run) -> None:
    """Raise the run's lower bound, by as much work as the deadline affords."""
    if run.proven or run.routes is None:
        return
    with run.timed("bound"):
        run.raise_bound(quick_bound(run.instance))
        part = _part(run.stop, BOUND_SHARE, BOUND_SECONDS)
        run.raise_bound(forest_bound(run.instance, run.cost, part))
        run.raise_bound(walk_bound(run.instance, run.cost, part))


def _has_cp_sat() -> bool:
    return importlib.util.find_spec("ortools") is not None


def _part(stop: Stop, share: float, most: float) -> Stop:
    """Return a stop for a share of the time that is left, or of the work."""
    # Without a deadline only work counts: a clock would make the plan depend on the machine.
    seconds = None if math.isinf(stop.remaining) else min(share * stop.remaining, most)
    work = None if stop.max_work is None else max(1, stop.max_work // FIRST_WORK)
    return stop.within(seconds, work)
