"""What every planner must keep to."""

# The names of the tests say what they check.
# ruff: noqa: D102

from __future__ import annotations

import copy
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from qrobot.backends.base import Planner, Routes, Search, Stop
from qrobot.backends.testing.cases import Case, cases, scattered, verify
from qrobot.errors import BackendError
from qrobot.problem import Instance

__all__ = ["PlannerConformance"]

CLOSE = 1e-6


class PlannerConformance:
    """What every planner must keep to. Override `make`; adjust the rest where needed."""

    work: ClassVar[int] = 300
    """Limit of work of each search."""

    seconds: ClassVar[float] = 10.0
    """Deadline of each search."""

    obeys_within: ClassVar[float] = 0.5
    """Seconds from a request to stop until the search must have ended; those in which a busy
    machine gave it no processor do not count."""

    large: ClassVar[int] = 60
    """Items of the instance that a search is interrupted on."""

    def make(self) -> Planner:
        """Return a planner."""
        raise NotImplementedError

    def search(self, instance: Instance, **more: Any) -> Search:
        """Search with `work` and `seconds`."""
        stop = Stop(seconds=self.seconds, max_work=self.work)
        return self.make().search(instance, **{"stop": stop, "seed": 3, **more})

    def usable(self) -> list[Case]:
        """Return the cases that the planner claims to take."""
        declared = self.make().capabilities
        return [case for case in cases() if declared.whole_orders or not case.instance.whole_orders]

    def test_declares_itself(self) -> None:
        planner = self.make()
        assert isinstance(planner, Planner)
        assert planner.name
        assert planner.capabilities.kind == "planner"

    def test_plans_keep_to_all_rules_and_bounds_are_true(self) -> None:
        for case in self.usable():
            found = self.search(case.instance)
            if case.best is None:
                assert found.routes is None, f"{case.name} has no plan"
                continue
            assert found.infeasible is None, f"{case.name} has a plan"
            assert found.bound <= case.best + CLOSE, f"{case.name}: bound above the optimum"
            if found.routes is None:
                assert not found.optimal, f"{case.name}: nothing found, but called optimal"
                continue
            length = verify(case.instance, found.routes)
            assert length >= case.best - CLOSE
            if found.optimal:
                assert length <= case.best + CLOSE, f"{case.name}: {length} is not optimal"

    def test_finds_plans(self) -> None:
        found = [self.search(case.instance).routes for case in self.usable() if case.best]
        assert all(routes is not None for routes in found)

    def test_never_calls_a_solvable_instance_infeasible(self) -> None:
        for case in self.usable():
            found = self.search(case.instance)
            assert (found.infeasible is None) or case.best is None, case.name
            if found.infeasible is not None:
                assert found.routes is None
                assert "\n" not in found.infeasible

    def test_tells_of_feasible_plans_only(self) -> None:
        for case in self.usable():
            told: list[tuple[Routes, float]] = []

            def keep(routes: Sequence[Sequence[int]], cost: float, told: Any = told) -> None:
                told.append(([list(route) for route in routes], cost))

            found = self.search(case.instance, on_best=keep)
            for routes, cost in told:
                assert case.best is not None, f"{case.name} has no plan"
                assert abs(verify(case.instance, routes) - cost) <= CLOSE * max(1.0, cost)
            if told and found.routes is not None:
                last = min(cost for _, cost in told)
                assert verify(case.instance, found.routes) <= last + CLOSE

    def test_one_seed_and_one_limit_of_work_give_one_plan(self) -> None:
        if not self.make().capabilities.deterministic:
            return
        for case in self.usable():
            first, second = (
                self.search(case.instance, stop=Stop(max_work=self.work)) for _ in range(2)
            )
            assert first.routes == second.routes, case.name
            assert first.work == second.work, case.name
            assert first.bound == second.bound, case.name

    def test_takes_a_start(self) -> None:
        for case in self.usable():
            routes = self.search(case.instance).routes
            if routes is None:
                continue
            start = [list(reversed(route)) for route in routes if route]
            kept = copy.deepcopy(start)
            found = self.search(case.instance, start=start)
            assert start == kept, f"{case.name}: the start was changed"
            if found.routes is not None:
                verify(case.instance, found.routes)

    def test_leaves_the_instance_as_it_is(self) -> None:
        for case in self.usable():
            kept = copy.deepcopy(case.instance)
            before = case.instance.distances.copy()
            self.search(case.instance)
            assert case.instance == kept
            assert np.array_equal(case.instance.distances, before)

    def test_ends_when_asked_to(self) -> None:
        instance = scattered(self.large)
        planner = self.make()
        with_time = Stop(seconds=60.0)
        try:
            planner.search(instance, stop=Stop(seconds=0.2), seed=1)  # loads what it needs
        except BackendError:
            return  # too large for it, and it says so
        searcher = threading.get_native_id()
        asked: list[float] = []

        def ask() -> None:
            asked.append(with_time.elapsed - held_up(searcher))
            with_time.request()

        timer = threading.Timer(0.3, ask)
        timer.start()
        found = planner.search(instance, stop=with_time, seed=1)
        ended = with_time.elapsed - held_up(searcher)
        timer.cancel()
        assert not asked or ended - asked[0] <= self.obeys_within
        if found.routes is not None:
            verify(instance, found.routes)

    def test_a_stop_at_once_is_no_error(self) -> None:
        case = self.usable()[0]
        stop = Stop(seconds=self.seconds, max_work=self.work)
        stop.request()
        found = self.search(case.instance, stop=stop)
        if found.routes is not None:
            verify(case.instance, found.routes)


def held_up(thread: int) -> float:
    """Return the seconds that a thread has waited for a processor, 0 where Linux does not tell."""
    try:
        told = Path(f"/proc/self/task/{thread}/schedstat").read_text()
        return int(told.split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0
