"""How `solve` runs a backend: one interface for planners, samplers and ``auto``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from qrobot._parameters import Parameter, near
from qrobot.backends import Capabilities, Planner, Routes, Search, Stop
from qrobot.backends.base import OnBest
from qrobot.errors import InputError
from qrobot.plan.objective import DISTANCE, Objective
from qrobot.planning.bounding import begin_bound, time_to_search
from qrobot.planning.feasibility import reason_infeasible
from qrobot.planning.run import Run

if TYPE_CHECKING:
    from qrobot.backends.sampler import PickingSampler

__all__ = [
    "ARGUMENTS",
    "DEFAULT_DEADLINE",
    "MODEL_OPTIONS",
    "PlannerStrategy",
    "Strategy",
    "check_arguments",
]

DEFAULT_DEADLINE = 10.0
"""Seconds, when neither a deadline nor a limit of work is given."""

ARGUMENTS: Mapping[str, Parameter] = {
    "backend": Parameter("text", optional=False),
    "deadline": Parameter("number", 0, above=True),
    "max_work": Parameter("whole", 1),
    "seed": Parameter("whole", 0, optional=False),
    "control": Parameter("flag", optional=False),
    "max_cost": Parameter("number", 0),
    "fallback": Parameter("text"),
    "objective": Parameter("text", optional=False),
    "routing": Parameter("text", optional=False),
    "stop": Parameter("object", also=(Stop,)),
    "on_progress": Parameter("function"),
}
"""What each argument of `solve` takes."""

MODEL_OPTIONS = ("encoding", "slack", "penalties")
"""Options of the model, which `qrobot.models.build_model` checks."""


def check_arguments(**given: Any) -> None:
    """Refuse an argument of the wrong type or out of range.

    Raises
    ------
    InputError
        Names the argument, its value and what is allowed.
    """
    for name, value in given.items():
        ARGUMENTS[name].check(name, value)


class Strategy:
    """A planner that works on a run of `solve`, in one step or several.

    A subclass says in `plan` what is done; it also is a `Planner`, whose `search` does the
    same on a run of its own. What `solve` must know before it starts are methods here.
    """

    name: str
    capabilities: Capabilities
    sampler: PickingSampler | None = None
    """The sampler that is asked, if any."""

    def plan(self, run: Run) -> None:
        """Find a plan for a run's instance; the run gets it, its bound, and what was done."""
        raise NotImplementedError

    def search(
        self,
        instance: Any,
        *,
        stop: Stop,
        seed: int = 0,
        start: Routes | None = None,
        on_best: OnBest | None = None,
        objective: Objective = DISTANCE,
    ) -> Search:
        """Search on a run of its own; see `Planner.search`."""
        if (reason := reason_infeasible(instance)) is not None:
            return Search(infeasible=reason)
        run = Run(instance, stop, seed, on_best=on_best, objective=objective)
        if start is not None:
            run.best.offer(start)
        self.plan(run)
        return Search(
            routes=run.best.routes,
            seats=run.best.seats,
            bound=run.best.as_cost(run.best.bound),
            optimal=run.finished and run.infeasible is None,
            infeasible=run.infeasible,
            work=sum(run.record.work.values()),
        )

    def take(
        self,
        options: Mapping[str, Any],
        *,
        control: bool = False,
        max_cost: float | None = None,  # noqa: ARG002 - planners bill nothing
    ) -> None:
        """Take what the caller of `solve` wants of this backend.

        Parameters
        ----------
        options
            Those of the model, ``rounds``, and the sampler's own.
        control, max_cost
            As of `solve`.

        Raises
        ------
        InputError
            Names what the backend does not take, or not like this.
        """
        self.check_options(options)
        if control and not self.capabilities.control:
            raise InputError(
                f"backend {self.name} has no control",
                field="control",
                advice="leave it out, or choose a sampler such as neal",
            )

    def check_options(self, options: Mapping[str, Any]) -> None:
        """Refuse options that the backend does not take, or not like this."""
        if options:
            unknown = sorted(options)
            raise InputError(
                f"backend {self.name} takes no option {', '.join(unknown)}",
                field=unknown[0],
                advice=near(unknown[0], ARGUMENTS)
                or "leave it out, or choose a sampler such as neal",
            )

    def known_options(self, options: Mapping[str, Any]) -> dict[str, Any]:  # noqa: ARG002
        """Return the options given for another backend that mean the same to this one."""
        return {}

    def limits(self, stop: Stop) -> Stop:
        """Return a stop that also ends when nobody asked for limits."""
        limited = stop.seconds is not None or stop.max_work is not None
        return stop if limited else Stop(DEFAULT_DEADLINE, parent=stop)


class PlannerStrategy(Strategy):
    """One planner, with time kept back for the bound."""

    def __init__(self, planner: Planner) -> None:
        self.planner = planner
        self.name, self.capabilities = planner.name, planner.capabilities

    def plan(self, run: Run) -> None:
        """Let the planner search between the two parts of the bound."""
        begin_bound(run)
        search = time_to_search(run)
        run.plan(self.planner, search)
        run.out_of_time = search.remaining <= 0
