"""Lower bounds within a run: what costs nothing at once, the rest in a share of its own.

A search uses all the time that it is given, and helpers use the other cores. So the bound is
begun before the search, with a fixed amount of work that does not depend on the clock where
the deadline allows it, and time is kept back for the rest of it and for the check of the plan.
"""

from __future__ import annotations

import math
import time

from qrobot.backends import Stop
from qrobot.backends.classical.aisles import TOURS, compiled_soon, takes
from qrobot.backends.classical.exact import ExactPlanner
from qrobot.backends.classical.generation import bound_of_batches
from qrobot.plan import Plan, check
from qrobot.planning.bounds import forest_bound, load_steps, quick_bound, tours_bound, walk_bound
from qrobot.planning.one_way import shorten_trips
from qrobot.planning.run import Run

__all__ = ["begin_bound", "bound_from_below", "share_of", "time_to_search"]

BOUND_SHARE, BOUND_SECONDS = 0.07, 1.0
"""The bound of large instances gets a fourteenth of the time, at most a second."""

EARLY_SHARE = 0.3
"""What is done of it before the search ends after this share of the time, however slow."""

FOREST_CELLS, WALK_CELLS, WALK_STEPS = 3e7, 1e8, 4_000
"""Work on the bound before the search, a tenth of a second or two each: pairs of stops that
are looked at, and load steps."""

FOREST_ROUNDS, WALK_ROUNDS = 300, 150
"""Rounds of a full bound."""

TOURS_SHARE, TOURS_SECONDS = 0.15, 3.0
"""Of the time, and at most, for shortest tours of the best plan along one-way aisles."""

INSTANT = 8
"""Orders that are proven in no time."""

MANY_STOPS = 200
"""Stops beyond which the check of a plan is timed before the search."""

CHECKS = 2.0
"""Checks of a plan that time is kept back for."""

WORK_SHARE = 5
"""A limit of work is cut by this for a part of a run."""


def begin_bound(run: Run) -> None:
    """Raise the bound as far as it goes before a search begins."""
    instance = run.instance
    if not instance.orders:
        return
    with run.timed("bound"):
        run.best.raise_bound(quick_bound(instance))
        if math.isinf(run.stop.remaining) or len(instance.orders) <= INSTANT:
            return  # all of it comes after the search, and takes no time
        _raise_by_tours(run)
        stop = run.stop.within(EARLY_SHARE * run.stop.remaining)
        pairs = len(instance.stops) ** 2
        rounds = min(FOREST_ROUNDS, int(FOREST_CELLS / pairs))
        run.best.raise_bound(forest_bound(instance, run.best.length, _Paced(stop), rounds))
        steps = load_steps(instance)
        rounds = min(WALK_ROUNDS, int(WALK_CELLS / (steps * pairs)), WALK_STEPS // steps)
        run.best.raise_bound(walk_bound(instance, run.best.length, _Paced(stop), rounds))
    run.tell()


def _raise_by_tours(run: Run) -> None:
    """Raise the bound by the shortest tours of whole orders, where these are found at once."""
    if takes(run.instance) and compiled_soon(run.stop, TOURS):
        run.best.raise_bound(tours_bound(run.instance))


def time_to_search(run: Run) -> Stop:
    """Return a stop that leaves the bound, and the check of the plan, their time."""
    left = run.stop.remaining
    if math.isinf(left):
        return run.stop
    kept = min(BOUND_SHARE * left, BOUND_SECONDS)
    slow = getattr(run.instance.warehouse, "is_slow_to_check", False)
    if slow or len(run.instance.stops) > MANY_STOPS:
        # How long the check of such a plan takes here and now.
        routes = run.best.routes or run.instance.first_routes() or []
        begun = time.perf_counter()
        check(Plan.from_routes(run.instance, routes), run.instance)
        run.check_seconds = CHECKS * (time.perf_counter() - begun)
        kept += run.check_seconds
    if getattr(run.instance.warehouse, "is_one_way", False):
        kept += min(TOURS_SHARE * left, TOURS_SECONDS)
    return run.stop.within(max(run.stop.remaining - kept, 0.0))


def bound_from_below(run: Run) -> None:
    """Raise the run's lower bound, by as much work as the deadline affords.

    The plan that it stands beside gets its shortest tours first, where aisles are one-way.
    """
    if run.best.proven or run.best.routes is None:
        return
    shorten_trips(run)
    with run.timed("bound"):
        if _proved(run):
            return
        stop = share_of(run.stop, 1.0, BOUND_SECONDS)
        if run.check_seconds:
            stop = stop.within(max(stop.remaining - run.check_seconds, 0.0))
        if stop.remaining <= 0 and run.best.bound > 0:
            return  # even to begin takes tenths of a second of two thousand stops
        run.best.raise_bound(quick_bound(run.instance))
        _raise_by_tours(run)
        if ExactPlanner.name not in run.record.steps:
            run.best.raise_bound(bound_of_batches(run.instance, run.best.routes, stop))
        part = _Paced(stop)
        for bound, rounds in ((forest_bound, FOREST_ROUNDS), (walk_bound, WALK_ROUNDS)):
            if stop.remaining > 0:
                run.best.raise_bound(bound(run.instance, run.best.length, part, rounds))


def _proved(run: Run) -> bool:
    """Take the optimum of a small instance as the bound; its plan stays out of the result."""
    exact = ExactPlanner()
    if exact.name in run.record.steps or not exact.at_once(run.instance):
        return False
    # So few orders take a millisecond or two: worth it even when time is up.
    late = run.stop() and len(run.instance.orders) <= INSTANT
    stop = Stop(BOUND_SECONDS) if late else share_of(run.stop, 1.0, BOUND_SECONDS)
    aim = run.best.aim(exact)
    found = exact.search(run.instance, stop=stop, seed=run.seed, **aim)
    run.best.take_bound(found, aim)
    return found.optimal


def share_of(stop: Stop, share: float, most: float) -> Stop:
    """Return a stop for a share of the time that is left, or of the work."""
    # Without a deadline only work counts: a clock would make the plan depend on the machine.
    seconds = None if math.isinf(stop.remaining) else min(share * stop.remaining, most)
    work = None if stop.max_work is None else max(1, stop.max_work // WORK_SHARE)
    return stop.within(seconds, work)


class _Paced(Stop):
    """A stop that also ends when a round as long as the last one would come too late."""

    def __init__(self, parent: Stop) -> None:
        super().__init__(parent=parent)
        self._asked: float | None = None

    def __call__(self, work: int = 0) -> bool:
        """Return True when it is time to stop after `work` units."""
        now = time.perf_counter()
        last = 0.0 if self._asked is None else now - self._asked
        self._asked = now
        return super().__call__(work) or self.remaining < last
