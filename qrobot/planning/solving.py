"""The front door of planning: arguments in, a checked result out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qrobot.backends import Planner, Stop, get
from qrobot.errors import BackendError, InfeasibleError, InputError
from qrobot.plan import Plan, check
from qrobot.planning.auto import bound_from_below, run_auto
from qrobot.planning.feasibility import reason_infeasible
from qrobot.planning.interrupts import graceful_interrupts
from qrobot.planning.result import Ending, Result
from qrobot.planning.run import Progress, Run
from qrobot.problem import Instance

__all__ = ["DEFAULT_DEADLINE", "solve"]

DEFAULT_DEADLINE = 10.0
"""Seconds, when neither a deadline nor a limit of work is given."""


def solve(
    instance: Instance,
    *,
    backend: str = "auto",
    deadline: float | None = None,
    max_work: int | None = None,
    seed: int = 0,
    control: bool = False,
    stop: Stop | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    **options: Any,
) -> Result:
    """Plan who collects what, in which sequence, at the least distance.

    Parameters
    ----------
    instance
        The question.
    backend
        A backend by name, or ``auto`` for the best plan that the installed software and
        the deadline allow.
    deadline
        Wall-clock seconds; the best plan so far is returned when they are over. Without
        deadline and work limit, 10 seconds.
    max_work
        Limit of work units of each step (each backend says what its unit is); with it and
        without a deadline, one seed gives one plan.
    seed
        Of every random choice.
    control
        For samplers: also polish as many random starts, and report them beside.
    stop
        A stop that the caller can `request` from another thread.
    on_progress
        Called with `Progress` at every step and better plan.
    **options
        For samplers, about the model: ``encoding``, ``slack``, ``penalties``; everything
        else, such as ``num_reads``, goes to the sampler.

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
    if deadline is not None and not deadline > 0:
        raise InputError(
            f"deadline {deadline:g} is not positive", field="deadline", mend="give seconds above 0"
        )
    if max_work is not None and max_work < 1:
        raise InputError(
            f"max_work {max_work} is too little", field="max_work", mend="give 1 or more"
        )
    if seed < 0:
        raise InputError(f"seed {seed} is negative", field="seed", mend="give 0 or more")
    if deadline is None and max_work is None:
        deadline = DEFAULT_DEADLINE
    chosen = None if backend == "auto" else get(backend)
    if options and (chosen is None or isinstance(chosen, Planner)):
        raise InputError(
            f"backend {backend} takes no option {', '.join(sorted(options))}",
            field="backend",
            mend="leave it out, or choose a sampler such as neal",
        )
    if control and (chosen is None or isinstance(chosen, Planner)):
        raise InputError(
            f"backend {backend} has no control", field="control", mend="it is for samplers"
        )
    run = Run(instance, Stop(deadline, max_work, parent=stop), seed, on_progress)
    if (reason := reason_infeasible(instance)) is not None:
        raise InfeasibleError(reason)
    with graceful_interrupts(run.stop):
        if chosen is None:
            run_auto(run)
        elif isinstance(chosen, Planner):
            run.plan(chosen, run.stop)
            bound_from_below(run)
        else:
            from qrobot.planning.sampling import run_sampler

            run_sampler(run, chosen, control=control, options=options)
            bound_from_below(run)
    return _result(run, backend)


def _result(run: Run, backend: str) -> Result:
    if run.infeasible is not None:
        raise InfeasibleError(run.infeasible)
    if run.routes is None:
        limits = "it was interrupted" if run.stop.requested else "the limits were reached"
        raise InfeasibleError(
            f"no plan was found before {limits} ({run.stop.elapsed:.1f} s, steps: "
            f"{', '.join(run.steps) or 'none'}); whether one exists is not known: give more time "
            "or more robots",
            proven=False,
        )
    proven = run.finished
    plan = Plan.from_routes(run.instance, run.routes)
    with run.timed("check"):
        report = check(plan, run.instance)
    if not report.ok:
        problems = "; ".join(map(str, report.problems))
        raise BackendError(f"the checker refused the plan of {' + '.join(run.steps)}: {problems}")
    run.timing.total = run.stop.elapsed
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
