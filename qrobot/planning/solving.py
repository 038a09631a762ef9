"""The front door of planning: arguments in, a checked result out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from qrobot._files import StrPath
from qrobot.backends import Planner, Stop, get
from qrobot.errors import BackendError, InfeasibleError, InputError
from qrobot.plan import Plan, check
from qrobot.planning.arguments import check_arguments, check_options
from qrobot.planning.auto import run_auto
from qrobot.planning.bounding import begin_bound, bound_from_below, time_to_search
from qrobot.planning.fallback import run_with_fallback
from qrobot.planning.feasibility import reason_infeasible
from qrobot.planning.interrupts import graceful_interrupts
from qrobot.planning.result import Ending, Result, SamplerReport
from qrobot.planning.run import TIE, Progress, Run
from qrobot.problem import Instance
from qrobot.problem.formats import instance_of
from qrobot.problem.packing import what_is_enough

__all__ = ["DEFAULT_DEADLINE", "result_of", "solve"]

DEFAULT_DEADLINE = 10.0
"""Seconds, when neither a deadline nor a limit of work is given."""


def solve(
    instance: Instance | StrPath,
    *,
    backend: str = "auto",
    deadline: float | None = None,
    max_work: int | None = None,
    seed: int = 0,
    control: bool = False,
    max_cost: float | None = None,
    fallback: str | None = None,
    stop: Stop | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    **options: Any,
) -> Result:
    """Plan who collects what, in which sequence, at the least distance.

    Parameters
    ----------
    instance
        The question, or the path of a file as `qrobot.read` takes it.
    backend
        A backend by name, or ``auto`` for the best plan that the installed software and
        the deadline allow.
    deadline
        Wall-clock seconds; the best plan so far is returned when they are over. Without
        deadline and work limit, 10 seconds; a remote backend is then waited for without
        limit, and repair, polish and bound get 10 seconds afterwards.
    max_work
        Limit of work units of each step (each backend says what its unit is); with it and
        without a deadline, one seed gives one plan.
    seed
        Of every random choice.
    control
        For samplers: also judge as many random reads and polish as many random starts, and
        report them beside.
    max_cost
        US dollars that a remote backend may bill; local ones bill nothing. A job that would,
        or might, cost more is refused before it is submitted.
    fallback
        Local backend (or ``auto``) that answers when the other one fails; the result's notes
        say so, and `Result.answered_by`. It shares the deadline.
    stop
        A stop that the caller can `request` from another thread.
    on_progress
        Called with `Progress` at every step and better plan.
    **options
        For samplers, about the model: ``encoding``, ``slack``, ``penalties``; ``rounds``,
        how often a sampler is asked at most while no read is a plan (8; remote ones 1);
        everything else, such as ``num_reads``, goes to the sampler.

    Returns
    -------
    Result
        Its plan was accepted by the independent checker.

    Raises
    ------
    InfeasibleError
        When no plan exists; carries the reason. Its `proven` is False when merely none was
        found within the limits.
    InputError
        When an argument or the instance cannot be used.
    BackendError
        When the backend failed.
    """
    check_arguments(
        backend=backend,
        deadline=deadline,
        max_work=max_work,
        seed=seed,
        control=control,
        max_cost=max_cost,
        fallback=fallback,
        stop=stop,
        on_progress=on_progress,
    )
    instance = instance_of(instance)
    limits = Stop(deadline, max_work, parent=stop)
    ask = _Question(instance, limits, int(seed), control, max_cost, on_progress)
    if fallback is None:
        return ask.answer(backend, options)
    _check_fallback(fallback)
    found = run_with_fallback(
        lambda: ask.answer(backend, options),
        fallback,
        lambda name: ask.for_fallback(name).answer(name, ask.shared(name, options)),
        primary_name=backend,
    )
    if found.note is None:
        return found.value
    notes = (*found.value.notes, found.note)
    return replace(found.value, backend=backend, answered_by=found.backend, notes=notes)


@dataclass(frozen=True)
class _Question:
    """What is asked of a backend, and of the one that answers in its place."""

    instance: Instance
    stop: Stop
    seed: int
    control: bool
    max_cost: float | None
    on_progress: Callable[[Progress], None] | None

    def answer(self, backend: str, options: dict[str, Any]) -> Result:
        """Return the plan of one backend."""
        chosen = None if backend == "auto" else get(backend)
        check_options(backend, chosen, options)
        if self.control and not _has_control(chosen):
            raise InputError(
                f"backend {backend} has no control",
                field="control",
                mend="leave it out, or choose a sampler such as neal",
            )
        run = Run(self.instance, self._limits(chosen, options), self.seed, self.on_progress)
        if (reason := reason_infeasible(self.instance)) is not None:
            raise InfeasibleError(reason)
        with graceful_interrupts(run.stop):
            if chosen is None:
                run_auto(run)
            elif isinstance(chosen, Planner):
                begin_bound(run)
                search = time_to_search(run)
                run.plan(chosen, search)
                run.out_of_time = search.remaining <= 0
                bound_from_below(run)
            else:
                from qrobot.planning.sampling import run_sampler

                if self.max_cost is not None and chosen.runs_remotely(**options):
                    options = options | {"max_cost": self.max_cost}
                run_sampler(run, chosen, control=self.control, options=options)
                bound_from_below(run)
        return result_of(run, backend)

    def _limits(self, chosen: Any, options: dict[str, Any]) -> Stop:
        stop = self.stop
        if stop.seconds is not None or stop.max_work is not None:
            return stop
        remote = not isinstance(chosen, Planner) and chosen is not None
        if remote and chosen.runs_remotely(**options):
            return stop  # nobody knows how long its queue is
        return Stop(DEFAULT_DEADLINE, parent=stop)

    def for_fallback(self, name: str) -> _Question:
        """Return what is asked of a fallback, which may have no control."""
        chosen = None if name == "auto" else get(name)
        return self if _has_control(chosen) else replace(self, control=False)

    def shared(self, name: str, options: dict[str, Any]) -> dict[str, Any]:
        """Return the options that a fallback understands too."""
        chosen = None if name == "auto" else get(name)
        if chosen is None or isinstance(chosen, Planner):
            return {}
        known = {*SHARED_OPTIONS} & {"encoding", "slack", "penalties", *chosen.parameters}
        return {key: value for key, value in options.items() if key in known}


def _has_control(chosen: Any) -> bool:
    """Whether a backend's reads can be told beside as many random ones."""
    if isinstance(chosen, Planner):
        return chosen.capabilities.control
    return chosen is not None


SHARED_OPTIONS = ("encoding", "slack", "penalties", "num_reads", "seed")
"""Options that mean the same to every sampler."""


def _check_fallback(name: str) -> None:
    """Refuse a fallback that may fail like the backend it stands for."""
    try:
        chosen = None if name == "auto" else get(name)
    except InputError as error:
        raise InputError(error.problem, field="fallback", mend=error.mend) from None
    if chosen is not None and not chosen.capabilities.local:
        raise InputError(
            f"backend {name} is remote itself", field="fallback", mend="name a local one, as auto"
        )


def result_of(run: Run, backend: str) -> Result:
    """Return the checked result of a run that is over.

    Raises
    ------
    InfeasibleError
        When the run has no plan.
    BackendError
        When the checker refuses the plan.
    """
    if run.infeasible is not None:
        raise InfeasibleError(run.infeasible)
    if run.routes is None:
        limits = "it was interrupted" if run.stop.requested else "the limits were reached"
        raise InfeasibleError(
            f"no plan was found before {limits} ({run.elapsed:.1f} s, steps: "
            f"{', '.join(run.steps) or 'none'}); whether one exists is not known: give more "
            f"time; {what_is_enough(run.instance)}",
            proven=False,
        )
    proven = run.finished
    plan = Plan.from_routes(run.instance, run.routes)
    with run.timed("check"):
        report = check(plan, run.instance)
    if not report.ok:
        problems = "; ".join(map(str, report.problems))
        raise BackendError(f"the checker refused the plan of {' + '.join(run.steps)}: {problems}")
    run.timing.total = run.elapsed
    if proven and run.sampler is not None:
        _count_optimal(run, run.sampler, plan.distance)
    return Result(
        instance=run.instance,
        plan=plan,
        bound=min(run.bound, plan.distance),
        is_optimal=proven,
        backend=backend,
        steps=tuple(run.steps),
        seed=run.seed,
        work=run.work,
        ended=_ending(run, proven),
        sampler=run.sampler,
        timing=run.timing,
        notes=tuple(run.notes),
    )


def _count_optimal(run: Run, report: SamplerReport, least: float) -> None:
    """Say how many reads are optimal plans, now that the optimum is proven."""
    if run.reads is None or not report.reads:
        return
    limit = least * (1 + TIE)
    lengths, random = run.reads
    report.optimal_fraction = float((lengths <= limit).sum() / report.reads)
    if random is not None:
        report.random_optimal_fraction = float((random <= limit).sum() / report.reads)


def _ending(run: Run, proven: bool) -> Ending:
    if run.stop.requested:
        return "interrupted"
    if proven:
        return "proven"
    if run.out_of_time or run.stop.remaining <= 0:
        return "deadline"
    if run.stop.max_work is not None:
        return "work"
    return "finished"
