"""What a backend is, and what it says about itself.

Two kinds exist. A *sampler* is a `dimod.Sampler`: it takes any binary quadratic model and
returns a SampleSet. A *planner* takes an Instance and returns routes. Both declare
`Capabilities`, so that `planning` can choose and the command line can explain.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, runtime_checkable

from qrobot._arrays import Floats
from qrobot.problem.instance import Instance

__all__ = ["Capabilities", "OnBest", "PlanReads", "Planner", "Routes", "Search", "Stop"]

Routes = list[list[int]]
"""For each trip its nodes (item index + 1) in sequence."""


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a backend can do.

    Parameters
    ----------
    kind
        ``sampler`` (takes a BQM) or ``planner`` (takes an Instance).
    local
        False when the work is done by a machine that is reached over a network.
    deterministic
        Whether one seed and one amount of work give one answer.
    proves
        Whether it can prove that a plan is optimal.
    whole_orders
        Whether a planner keeps orders of several items together.
    max_size
        Largest useful size: variables of a sampler, items of a planner; ``None``: no limit.
    extra
        The extra of the distribution that installs it; ``None`` when the base does.
    control
        Whether a planner tells of as many random plans beside its own reads; a sampler's are
        drawn for it.
    objectives
        What a planner makes small beside the distance: names of objectives, or ``sum`` or
        ``schedule`` for all of that form (`Objective.form`); its `search` then takes `objective`.
        Where a shortest plan is a cheapest one, every backend will do.
    """

    kind: Literal["sampler", "planner"]
    local: bool = True
    deterministic: bool = True
    proves: bool = False
    whole_orders: bool = True
    max_size: int | None = None
    extra: str | None = None
    control: bool = False
    objectives: tuple[str, ...] = ("distance",)


class Stop:
    """When to stop: a deadline, a limit of work, or a request.

    Parameters
    ----------
    seconds
        Wall-clock seconds from now; ``None`` sets no deadline.
    max_work
        Limit of work units (iterations, reads; each backend says which); ``None``: none.
    parent
        A stop that ends this one too.
    """

    def __init__(
        self,
        seconds: float | None = None,
        max_work: int | None = None,
        parent: Stop | None = None,
    ) -> None:
        self.started = time.perf_counter()
        self.seconds = seconds
        self.max_work = max_work
        self._requested = threading.Event()
        self._parent = parent

    def request(self) -> None:
        """Ask for the best answer so far; safe from signal handlers and other threads."""
        self._requested.set()

    @property
    def requested(self) -> bool:
        """Whether somebody asked to stop."""
        return self._requested.is_set() or (self._parent is not None and self._parent.requested)

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self.started

    @property
    def remaining(self) -> float:
        """Seconds until the deadline, ``inf`` without one, 0 once a stop was requested."""
        if self.requested:
            return 0.0
        own = float("inf") if self.seconds is None else self.seconds - self.elapsed
        above = float("inf") if self._parent is None else self._parent.remaining
        return max(0.0, min(own, above))

    def __call__(self, work: int = 0) -> bool:
        """Return True when it is time to stop after `work` units."""
        if self.max_work is not None and work >= self.max_work:
            return True
        return self.requested or self.remaining <= 0.0

    def within(self, seconds: float | None = None, max_work: int | None = None) -> Stop:
        """Return a stop for a part of the work; it also ends when this one does."""
        return Stop(seconds, self.max_work if max_work is None else max_work, parent=self)


@dataclass(frozen=True, slots=True)
class PlanReads:
    """What a planner that samples plans read, beside as many random plans.

    Parameters
    ----------
    encoding
        What it sampled from, in words.
    variables
        Qubits that a circuit would have.
    lengths, random_lengths
        Distance of each read, and of each random plan; ``inf`` where no way leads.
    energy
        Least energy of all reads.
    details
        Anything worth reporting, plain data.
    """

    encoding: str
    variables: int
    lengths: Floats
    random_lengths: Floats
    energy: float
    details: Mapping[str, Any]


@dataclass(slots=True)
class Search:
    """What a planner found.

    Parameters
    ----------
    routes
        The best routes, or ``None`` when none was found.
    seats
        Where the objective counts who makes a route, and when: for each route its robot and which
        of that robot's trips it is, from 0.
    bound
        A valid lower bound of the cost: of the distance, unless `search` was given another
        objective (0 when nothing is known).
    optimal
        True when the routes are proven to be of least cost, and of fewest trips among those.
    infeasible
        A proven reason why no plan exists, or ``None``.
    work
        Units of work done.
    reads
        The reads of a planner that samples plans.
    """

    routes: Routes | None = None
    seats: list[tuple[int, int]] | None = None
    bound: float = 0.0
    optimal: bool = False
    infeasible: str | None = None
    work: int = 0
    reads: PlanReads | None = None


OnBest = Callable[[Sequence[Sequence[int]], float], None]
"""Called with routes and their distance whenever a better plan is known."""


@runtime_checkable
class Planner(Protocol):
    """A backend that takes an Instance and returns routes."""

    name: str
    capabilities: Capabilities

    def search(
        self,
        instance: Instance,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,
        on_best: OnBest | None = None,
    ) -> Search:
        """Search for routes until `stop` says so.

        Parameters
        ----------
        instance
            The question.
        stop
            Deadline, work limit and interrupts; must be asked at least every 0.2 s.
        seed
            Of every random choice.
        start
            Feasible routes to start from, when some are known.
        on_best
            Told of every better feasible plan, so that an interrupted run loses nothing.

        A planner that declares more `Capabilities.objectives` than the distance also takes
        ``objective``, the `Objective` to make small where robots are charged differently.

        Raises
        ------
        BackendError
            When the backend cannot work at all.
        """
        ...
