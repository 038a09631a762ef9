"""The strategy of ``backend="auto"``: the best plan that software and deadline allow.

Small instances are proven at once by the subset dynamic programme. Where all fitting sets
can be enumerated, a short search gives a first plan and the set partition proves or
improves it. Everything else is searched until the deadline, with a bound beside it.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Iterator
from contextlib import contextmanager

from qrobot.backends import Planner, Stop, available, get
from qrobot.backends.exact import ExactPlanner, no_packing, pack
from qrobot.backends.exact.partition import MAX_ELEMENTS
from qrobot.planning.bounds import forest_bound, quick_bound, walk_bound
from qrobot.planning.crew import Crew, spare_cores
from qrobot.planning.run import Run
from qrobot.problem import Instance

__all__ = ["bound_from_below", "choose_search", "run_auto"]

FIRST_SHARE, FIRST_SECONDS, FIRST_WORK = 0.1, 0.5, 5
"""Before a proof, the search gets a tenth of the time, at most half a second, or a fifth of
the work."""

PROOF_SHARE = 0.6
"""The proof gets this share of the time; then the search goes on."""

BOUND_SHARE, BOUND_SECONDS = 0.07, 1.0
"""The bound of large instances gets a fourteenth of the time, at most a second."""

INSTANT = 8
"""Orders that are proven in no time."""

PATIENCE = 0.3
"""A search that found no plan in this share of the time gets a packing to start from."""


HELPED_SECONDS, HELPER_START = 3.0, 0.3
"""Searches this long get the other cores too; starting a process takes a part of a second."""


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
    search = choose_search(run.instance)
    if small and not run.finished and _has_cp_sat():
        # A first plan tells the set partition which trips cannot be part of a better one.
        run.plan(search, _part(run.stop, FIRST_SHARE, FIRST_SECONDS))
        run.plan(exact, _proving(run.stop))
    if not run.finished and not run.stop():
        _search_on(run, search)
    bound_from_below(run)


def _search_on(run: Run, search: Planner) -> None:
    """Search until it is time for the bound; without any plan after a while, pack first."""
    left = run.stop.remaining
    seconds = None if math.isinf(left) else left - min(BOUND_SHARE * left, BOUND_SECONDS)
    part = _Patient(run, seconds)
    with _helpers(run, search, seconds):
        run.plan(search, part)
        run.out_of_time = part.remaining <= 0
    if run.routes is None and not run.finished and not run.stop():
        run.begin("packing")
        with run.timed("run"):
            routes, impossible = pack(run.instance, run.stop, run.seed)
        if impossible:
            run.infeasible = no_packing(run.instance)
        elif routes is not None:
            run.offer(routes)
            run.plan(search, run.stop)


@contextmanager
def _helpers(run: Run, search: Planner, seconds: float | None) -> Iterator[None]:
    """Let the other cores search too while the block runs, where it is worth their start."""
    long = seconds is not None and seconds >= HELPED_SECONDS
    helpers = spare_cores() if long and run.stop.max_work is None else 0
    if not helpers:
        yield
        return
    assert seconds is not None
    # PyVRP's own settings beside ours: what one misses the other often finds.
    other = "pyvrp-plain" if search.name == "pyvrp" else search.name
    crew = Crew(run.instance, other, run.seed, seconds - HELPER_START, None, helpers)
    try:
        yield
    finally:
        with run.timed("run"):
            crew.close(run.offer, wait=0.0)


class _Patient(Stop):
    """A stop for a part of a run that also ends when no plan was found for too long."""

    def __init__(self, run: Run, seconds: float | None) -> None:
        super().__init__(seconds, run.stop.max_work, parent=run.stop)
        self._run = run

    def __call__(self, work: int = 0) -> bool:
        """Return True when it is time to stop after `work` units."""
        if super().__call__(work):
            return True
        if self._run.routes is not None:
            return False
        if self.max_work is not None and work > PATIENCE * self.max_work:
            return True
        return self.seconds is not None and self.elapsed > PATIENCE * self.seconds


def bound_from_below(run: Run) -> None:
    """Raise the run's lower bound, by as much work as the deadline affords."""
    if run.proven or run.routes is None:
        return
    with run.timed("bound"):
        if _proved(run):
            return
        run.raise_bound(quick_bound(run.instance))
        part = _part(run.stop, 1.0, BOUND_SECONDS)
        run.raise_bound(forest_bound(run.instance, run.cost, part))
        run.raise_bound(walk_bound(run.instance, run.cost, part))


def _proved(run: Run) -> bool:
    """Take the optimum of a small instance as the bound; its plan stays out of the result."""
    exact = ExactPlanner()
    small = len(run.instance.orders) <= MAX_ELEMENTS and exact.fits(run.instance)
    if not small or exact.name in run.steps:
        return False
    # So few orders take a millisecond or two: worth it even when time is up.
    late = run.stop() and len(run.instance.orders) <= INSTANT
    stop = Stop(BOUND_SECONDS) if late else _part(run.stop, 1.0, BOUND_SECONDS)
    found = exact.search(run.instance, stop=stop, seed=run.seed)
    run.raise_bound(found.bound)
    return found.optimal


def _proving(stop: Stop) -> Stop:
    """Return a stop that leaves a search its share when the proof takes too long."""
    left = stop.remaining
    return stop if math.isinf(left) else stop.within(PROOF_SHARE * left)


def _has_cp_sat() -> bool:
    return importlib.util.find_spec("ortools") is not None


def _part(stop: Stop, share: float, most: float) -> Stop:
    """Return a stop for a share of the time that is left, or of the work."""
    # Without a deadline only work counts: a clock would make the plan depend on the machine.
    seconds = None if math.isinf(stop.remaining) else min(share * stop.remaining, most)
    work = None if stop.max_work is None else max(1, stop.max_work // FIRST_WORK)
    return stop.within(seconds, work)
