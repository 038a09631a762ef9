"""The front door of planning: arguments in, a checked result out."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from qrobot._files import StrPath
from qrobot._processes import catch_signals
from qrobot.backends import Planner, Stop, available, capabilities, get, names
from qrobot.errors import BackendError, InfeasibleError, InputError
from qrobot.plan import Objective, Plan, check
from qrobot.plan.objective import objective_named
from qrobot.planning.bounding import bound_from_below
from qrobot.planning.feasibility import reason_infeasible
from qrobot.planning.places import plan_after_places, run_with_places
from qrobot.planning.result import Ending, Result, SamplerReport
from qrobot.planning.run import TIE, Progress, Run
from qrobot.planning.strategy import (
    DEFAULT_DEADLINE,
    PlannerStrategy,
    Strategy,
    check_arguments,
)
from qrobot.planning.tours import shorten_tours
from qrobot.problem import Instance
from qrobot.problem.fleets import what_is_enough
from qrobot.problem.formats import instance_of
from qrobot.warehouse import under_policy

__all__ = [
    "DEFAULT_DEADLINE",
    "check_objective",
    "result_of",
    "run_with_fallback",
    "solve",
    "strategy_of",
]

T = TypeVar("T")

UNDER_POLICIES = ("auto", "exact", "batching", "fcfs", "seed", "savings")
"""Backends that batch orders for the lengths of a policy's ways."""


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
    objective: str = "distance",
    routing: str = "exact",
    stop: Stop | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    **options: Any,
) -> Result:
    """Plan who collects what, in which sequence, at the least cost.

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
    objective
        What shall be small: ``distance``; ``time``, the seconds that all robots together work;
        ``makespan``, until the last robot is back; ``lateness`` of orders after their due times;
        ``trips``; ``robots``; or a weighted sum such as ``distance=1,makespan=2``.
    routing
        How trips are walked: ``exact``, by shortest tours, or by a policy: ``s-shape``,
        ``return``, ``midpoint`` (these in one block), ``largest-gap``, ``combined`` or
        ``aisle-by-aisle``. Orders are then batched for the lengths of its ways.
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
        objective=objective,
        routing=routing,
        stop=stop,
        on_progress=on_progress,
    )
    instance = under_policy(instance_of(instance), routing)
    limits = Stop(deadline, max_work, parent=stop)
    aim = objective_named(objective)

    def answer(name: str, strategy: Strategy) -> Result:
        stop = strategy.limits(limits)
        if (reason := reason_infeasible(instance)) is not None:
            raise InfeasibleError(reason)
        with _stop_on_interrupt(stop):
            run = run_with_places(instance, strategy.name, stop, int(seed), on_progress, aim)
            if run is None:
                run = Run(instance, stop, int(seed), on_progress, objective=aim)
                strategy.plan(run)
                shorten_tours(run)
                bound_from_below(run)
            elif not run.finished:
                plan_after_places(run, strategy)
                shorten_tours(run)
        return result_of(run, name)

    def first() -> Result:
        strategy = strategy_of(backend)
        strategy.take(options, control=control, max_cost=max_cost)
        check_objective(strategy, aim, instance)
        _check_routing(strategy, instance)
        return answer(backend, strategy)

    if fallback is None:
        return first()
    second = _local(fallback)
    check_objective(second, aim, instance)
    _check_routing(second, instance)

    def instead(name: str) -> Result:
        known = second.known_options(options)
        second.take(known, control=control and second.capabilities.control, max_cost=max_cost)
        return answer(name, second)

    found = run_with_fallback(first, fallback, instead, primary_name=backend)
    if found.note is None:
        return found.value
    notes = (*found.value.notes, found.note)
    return replace(found.value, backend=backend, answered_by=found.backend, notes=notes)


def strategy_of(name: str) -> Strategy:
    """Return the way to run a backend by name.

    Raises
    ------
    InputError
        When no backend has that name.
    MissingExtraError
        When its software is not installed.
    """
    backend = get(name)
    if isinstance(backend, Strategy):
        return backend
    if isinstance(backend, Planner):
        return PlannerStrategy(backend)
    from qrobot.planning.sampling import SamplerStrategy  # loads dimod, which takes its time

    return SamplerStrategy(backend)


def _local(name: str) -> Strategy:
    """Return a fallback; refuse one that may fail like the backend it stands for."""
    try:
        strategy = strategy_of(name)
    except InputError as error:
        raise error.at("fallback") from None
    if not strategy.capabilities.local:
        raise InputError(
            f"backend {name} is remote itself", field="fallback", advice="name a local one, as auto"
        )
    return strategy


@dataclass(frozen=True, slots=True)
class Fallback(Generic[T]):
    """An answer, the name of the backend that gave it, and a note when another one was asked."""

    value: T
    backend: str
    note: str | None = None


def run_with_fallback(
    primary: Callable[[], T],
    fallback_name: str | None = None,
    fallback: Callable[[str], T] | None = None,
    *,
    primary_name: str,
) -> Fallback[T]:
    """Call a backend; when it fails, call the fallback by its name and say so.

    Raises
    ------
    BackendError
        When the primary failed and there is no fallback, or that failed too: the message
        then names both. Bad input and infeasible instances are never retried elsewhere.
    """
    try:
        return Fallback(primary(), primary_name)
    except BackendError as error:
        if fallback_name is None or fallback is None or fallback_name == primary_name:
            raise
        reason = str(error)
    try:
        value = fallback(fallback_name)
    except BackendError as error:
        second = str(error)
    else:
        note = f"{primary_name} failed, {fallback_name} answered instead: {reason}"
        return Fallback(value, fallback_name, note)
    raise BackendError(
        f"{primary_name} failed ({reason}), and so did the fallback {fallback_name} ({second})"
    )


@contextmanager
def _stop_on_interrupt(stop: Stop) -> Iterator[None]:
    """Turn the first Ctrl-C into a request to stop; the second interrupts as usual.

    Only in the main thread, and only where the caller has not set a handler of its own.
    """
    if (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ):
        with catch_signals(lambda _: stop.request(), "SIGINT", second="restore"):
            yield
    else:
        yield


def check_objective(strategy: Strategy, objective: Objective, instance: Instance) -> None:
    """Refuse a backend that would make something else small."""
    if objective.common_rate(instance) is not None:
        return
    if not objective.optimised_by(strategy.capabilities.objectives, instance):
        able = [
            name
            for name in ["auto", *names()]
            if available(name) and objective.optimised_by(capabilities(name).objectives, instance)
        ]
        why = {
            "sum": "with unlike robots",
            "schedule": "with deadlines" if instance.has_deadlines else "of trips in sequence",
        }
        raise InputError(
            f"backend {strategy.name} cannot optimise {objective.name} "
            f"{why[objective.form(instance)]}",
            field="objective",
            advice=f"use one of: {', '.join(able)}",
        )


def _check_routing(strategy: Strategy, instance: Instance) -> None:
    """Refuse a backend that knows shortest tours only."""
    if instance.routing != "exact" and strategy.name not in UNDER_POLICIES:
        raise InputError(
            f"backend {strategy.name} plans shortest tours only",
            field="routing",
            advice=f"use one of: {', '.join(UNDER_POLICIES)}",
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
    best, record = run.best, run.record
    if run.infeasible is not None:
        raise InfeasibleError(run.infeasible)
    if best.routes is None:
        raise InfeasibleError(_no_plan(run), proven=False)
    proven = run.finished
    routes = run.instance.in_sequence(best.routes)
    plan = Plan.from_routes(run.instance, routes, best.objective, best.seats)
    with run.timed("check"):
        report = check(plan, run.instance)
    if not report.ok:
        problems = "; ".join(map(str, report.problems))
        raise BackendError(
            f"the checker refused the plan of {' + '.join(record.steps)}: {problems}"
        )
    record.timing.total = run.elapsed
    if proven and record.sampler is not None:
        _count_optimal(run, record.sampler, plan.distance)
    return Result(
        instance=run.instance,
        plan=plan,
        bound=min(best.as_cost(best.bound), plan.cost),
        is_optimal=proven,
        backend=backend,
        steps=tuple(record.steps),
        seed=run.seed,
        work=record.work,
        ended=_ending(run, proven),
        sampler=record.sampler,
        timing=record.timing,
        notes=tuple(record.notes),
        measures=report.measures,
    )


def _no_plan(run: Run) -> str:
    """Return why a run has no plan, and what to do."""
    steps = ", ".join(run.record.steps) or "none"
    enough = what_is_enough(run.instance)
    if not (run.out_of_time or run.stop(max(run.record.work.values(), default=0))):
        return (
            f"no plan was found by {steps} ({run.elapsed:.1f} s); whether one exists is not known: "
            f"use another backend; {enough}"
        )
    limits = "it was interrupted" if run.stop.requested else "the limits were reached"
    return (
        f"no plan was found before {limits} ({run.elapsed:.1f} s, steps: {steps}); whether one "
        f"exists is not known: give more time; {enough}"
    )


def _count_optimal(run: Run, report: SamplerReport, least: float) -> None:
    """Say how many reads are optimal plans, now that the optimum is proven."""
    if run.record.reads is None or not report.reads:
        return
    limit = least * (1 + TIE)
    lengths, random = run.record.reads
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
