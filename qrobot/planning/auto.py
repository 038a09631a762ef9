"""The strategy of ``backend="auto"``: the best plan that software and deadline allow.

Small instances are proven at once by the subset dynamic programme. Where all fitting sets
can be enumerated, a short search gives a first plan and the set partition proves or
improves it. Everything else is searched until the deadline, with a bound beside it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

from qrobot._extras import is_installed
from qrobot.backends import Capabilities, Planner, Stop, available
from qrobot.backends.classical.aisles import NOT_COMPILED, compiled_soon, is_late, takes
from qrobot.backends.classical.exact import ExactPlanner, no_packing, pack
from qrobot.backends.classical.exact.partition import MAX_ELEMENTS
from qrobot.backends.classical.generation import can_generate, count_of_batches, is_worth_proving
from qrobot.backends.registry import get_planner
from qrobot.planning.bounding import begin_bound, share_of, time_to_search
from qrobot.planning.crew import Crew, spare_cores
from qrobot.planning.dispatching import dispatch
from qrobot.planning.run import Run
from qrobot.planning.strategy import Strategy
from qrobot.problem import Instance

__all__ = ["AutoPlanner", "choose_search"]

FIRST_SHARE, FIRST_SECONDS = 0.1, 0.5
"""Before a proof, the search gets a tenth of the time, at most half a second, or a fifth of
the work."""

PROOF_SHARE = 0.6
"""The proof gets this share of the time; then the search goes on."""

BATCHES_SHARE = 0.8
"""That of whole orders in aisles: no other bound comes near to it."""

MANY_BATCHES = 200_000
"""Batches beyond which a proof takes seconds, so that helpers are worth their start."""

PACKING_SHARE = 0.3
"""A search that found no plan in this share of the time gets a packing to start from."""


MANY_STOPS = 200
"""Stops beyond which a plan is made at once, before the search."""

HELPED_SECONDS = 3.0
"""Searches this long get the other cores too; starting a process takes a part of a second."""


def choose_search(instance: Instance) -> Planner:
    """Return the best search that is installed and keeps what must stay together."""
    exact = instance.routing == "exact"
    pyvrp = available("pyvrp") and not instance.whole_orders and exact
    return get_planner("pyvrp" if pyvrp else "batching")


class AutoPlanner(Strategy):
    """The best plan that the installed software and the deadline allow."""

    name = "auto"
    capabilities = Capabilities(kind="planner", proves=True, objectives=("sum", "schedule"))

    def plan(self, run: Run) -> None:
        """Prove what is small, search and prove what can be enumerated, search the rest."""
        if run.best.objective.form(run.instance) == "schedule":
            dispatch(run, self)
            return
        exact, few = ExactPlanner(), len(run.instance.orders) <= MAX_ELEMENTS
        if exact.at_once(run.instance):
            run.plan(exact, run.stop)
        search = choose_search(run.instance)
        proves = few or (run.best.shortest_is_best and _has_cp_sat())
        if not (run.finished or is_late(run.stop) or compiled_soon(run.stop)) and takes(
            run.instance
        ):
            run.record.notes.append(NOT_COMPILED)
        if not run.finished and proves and _can_prove(exact, run):
            _prove(run, exact, search)
        if not (run.finished or run.best.shortest_is_best or run.best.aim(search)):
            run.record.notes.append(
                f"no search takes account of {run.best.objective.name} here: short plans were "
                "sought, their trips dealt to the robots at the least cost"
            )
        if not run.finished:
            _begin(run)
        if not run.finished and not run.stop():
            _search_on(run, search)


def _prove(run: Run, exact: ExactPlanner, search: Planner) -> None:
    """Prove, or improve, what is in reach of a proof."""
    if not can_generate(run.instance):
        # A first plan tells the set partition which trips cannot be part of a better one.
        run.plan(search, share_of(run.stop, FIRST_SHARE, FIRST_SECONDS))
        run.plan(exact, _proving(run.stop, PROOF_SHARE))
        return
    # There the proof makes a plan itself; a long one leaves the other cores to the search.
    stop = _proving(run.stop, BATCHES_SHARE)
    seconds = stop.remaining if count_of_batches(run.instance) > MANY_BATCHES else 0.0
    with _helpers(run, search, seconds) as crew:
        run.plan(exact, _Patient(run, stop, crew))


def _can_prove(exact: ExactPlanner, run: Run) -> bool:
    """Return whether a proof is in reach."""
    if not exact.fits(run.instance, run.stop):
        return False
    return not can_generate(run.instance) or is_worth_proving(run.instance, run.stop)


def _begin(run: Run) -> None:
    """Have a plan before a search that may be too slow for its first, or for which it is late."""
    late = run.stop() or len(run.instance.stops) > MANY_STOPS
    if late and run.best.routes is None and (routes := run.instance.first_routes()) is not None:
        run.begin("insertion")
        run.best.offer(routes)


def _search_on(run: Run, search: Planner) -> None:
    """Search until it is time for the bound; without any plan after a while, pack first."""
    begin_bound(run)
    if run.finished:
        return
    stop = time_to_search(run)
    with _helpers(run, search, stop.remaining) as crew:
        part = _Patient(run, stop, crew)
        run.plan(search, part)
        if math.isfinite(part.remaining) and part.max_work is None and not part():
            run.plan(get_planner("batching"), part)  # PyVRP gave up: too little time for it
        run.out_of_time = part.remaining <= 0
    if run.best.routes is None and run.infeasible is None and not run.stop():
        run.begin("packing")
        with run.timed("run"):
            routes, impossible = pack(run.instance, stop, run.seed)
        if impossible:
            run.infeasible = no_packing(run.instance)
        elif routes is not None:
            run.best.offer(routes)
            run.plan(search, stop)
            run.out_of_time = stop.remaining <= 0


@contextmanager
def _helpers(run: Run, search: Planner, seconds: float) -> Iterator[Crew | None]:
    """Let the other cores search too while the block runs, where it is worth their start."""
    long = HELPED_SECONDS <= seconds < math.inf
    helpers = spare_cores() if long and run.stop.max_work is None else 0
    if not helpers:
        yield None
        return
    # PyVRP's own settings beside ours: what one misses the other often finds. But with robots of
    # different prices they pay too little for overload, and hardly find a plan.
    aim = run.best.aim(search)
    other = "pyvrp-plain" if search.name == "pyvrp" and not aim else search.name
    crew = Crew(run.instance, other, run.seed, seconds, None, helpers, aim)
    try:
        yield crew
    finally:
        with run.timed("run"):
            crew.close(run.best.offer, wait=0.0)


class _Patient(Stop):
    """A stop for a part of a run that also ends when no plan was found for too long.

    Whenever it is asked, what helpers have found is offered to the run.
    """

    def __init__(self, run: Run, stop: Stop, crew: Crew | None) -> None:
        left = stop.remaining
        super().__init__(None if math.isinf(left) else left, stop.max_work, parent=stop)
        self._run, self._crew = run, crew

    def __call__(self, work: int = 0) -> bool:
        """Return True when it is time to stop after `work` units."""
        if self._crew is not None:
            self._crew.deliver(self._run.best.offer)
        if super().__call__(work):
            return True
        if self._run.best.routes is not None:
            return False
        if self.max_work is not None and work > PACKING_SHARE * self.max_work:
            return True
        return self.seconds is not None and self.elapsed > PACKING_SHARE * self.seconds


def _proving(stop: Stop, share: float) -> Stop:
    """Return a stop that leaves a search its share when the proof takes too long."""
    left = stop.remaining
    return stop if math.isinf(left) else stop.within(share * left)


def _has_cp_sat() -> bool:
    return is_installed("ortools")
