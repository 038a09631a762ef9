"""Remote work in parts: what it would cost, hand it over, and make a plan of it later."""

from __future__ import annotations

from typing import Any

from qrobot._files import StrPath
from qrobot.backends import Stop, get
from qrobot.backends.jobs import fetch
from qrobot.backends.sampler import PickingSampler
from qrobot.errors import BackendError, InfeasibleError, InputError
from qrobot.jobs import Estimate, JobStore, with_retries
from qrobot.jobs.cost import FREE
from qrobot.models import build_model
from qrobot.plan.objective import DISTANCE, objective_named
from qrobot.planning.batch_sampling import wants_batches
from qrobot.planning.bounding import bound_from_below
from qrobot.planning.feasibility import reason_infeasible
from qrobot.planning.reads import parameters_of, split_options, take_reads
from qrobot.planning.result import Result
from qrobot.planning.run import Run
from qrobot.planning.sampling import build, use_reads
from qrobot.planning.solving import check_objective, result_of, strategy_of
from qrobot.planning.strategy import DEFAULT_DEADLINE, Strategy, check_arguments
from qrobot.planning.tours import shorten_tours
from qrobot.problem import Instance
from qrobot.problem.formats import instance_of
from qrobot.problem.formats.native import parse_native

__all__ = ["collect", "estimate", "submit"]


def estimate(
    instance: Instance | StrPath,
    backend: str,
    *,
    seed: int = 0,
    max_work: int | None = None,
    **options: Any,
) -> Estimate:
    """Return what one round of `solve` with these arguments would cost; submits nothing.

    Parameters
    ----------
    instance, backend, seed, max_work, **options
        As of `solve`.

    Raises
    ------
    BackendError
        When a remote backend cannot be asked.
    """
    check_arguments(backend=backend, seed=seed, max_work=max_work)
    instance = instance_of(instance)
    strategy = strategy_of(backend)
    strategy.check_options(options)
    if (sampler := strategy.sampler) is None or not instance.orders:
        return FREE
    if wants_batches(instance, sampler, options, Stop()):
        return FREE  # only samplers on this machine are asked for batches
    chosen, sampling = split_options(sampler, options)
    model = build(instance, sampler, chosen)
    asked = parameters_of(sampler, model, sampling, Stop(max_work=max_work), seed)
    life = {"interrupt_function", "context", "max_cost"}
    asked = {name: value for name, value in asked.items() if name not in life}
    if not sampler.runs_remotely(**sampling):
        return sampler.estimate(model.bqm, **asked)
    # The service may have to be asked: its errors are reported as those of every other call.
    title = getattr(sampler, "title", f"backend {sampler.name}")
    return with_retries(lambda: sampler.estimate(model.bqm, **asked), what=title)


def submit(
    instance: Instance | StrPath,
    backend: str,
    *,
    seed: int = 0,
    max_cost: float | None = None,
    objective: str = "distance",
    **options: Any,
) -> dict[str, Any]:
    """Hand an instance over to a remote backend and return at once.

    Parameters
    ----------
    instance, backend, seed, max_cost, objective, **options
        As of `solve`.

    Returns
    -------
    dict
        What is known of the job; its ``id`` (ours) is what `collect` takes.

    Raises
    ------
    InputError
        When the backend has no jobs to hand over.
    BackendError
        When it could not be handed over.
    """
    check_arguments(backend=backend, seed=seed, max_cost=max_cost, objective=objective)
    instance, aim = instance_of(instance), objective_named(objective)
    if not instance.orders:
        raise InputError("there is nothing to collect", field="orders", advice="leave the job out")
    if (reason := reason_infeasible(instance)) is not None:
        raise InfeasibleError(reason)
    strategy = strategy_of(backend)
    sampler = _remote(strategy, options)
    check_objective(strategy, aim, instance)
    chosen, sampling = split_options(sampler, options)
    model = build(instance, sampler, chosen)
    extra: dict[str, Any] = {"wait": False}
    if max_cost is not None:
        extra["max_cost"] = max_cost
    run = Run(instance, Stop(), seed, objective=aim)
    samples = take_reads(run, sampler, model, chosen, sampling | extra)
    job = samples.info.get("remote")
    if not isinstance(job, dict):
        raise BackendError(f"backend {backend} gave the job no name")
    return dict(job)


def collect(job: str, store: JobStore) -> Result:
    """Return the plan of a job that an earlier process handed over.

    Parameters
    ----------
    job
        Our id, or an unmistakable beginning of it.
    store
        Where the jobs are kept.

    Raises
    ------
    InputError
        When there is no such job, or it was submitted without an instance.
    RemoteError
        When it is not done, or has failed.
    """
    kept = store.get(job)
    text = kept.context.get("instance")
    if not isinstance(text, str):
        raise InputError(
            f"job {kept.id} was sampled without an instance",
            field="job",
            advice="leave out what asks for a plan, and take the samples",
        )
    instance = parse_native(text)
    model = build_model(instance, **kept.context.get("model", {}))
    samples = fetch(job, store, get)
    aim = objective_named(kept.context.get("objective", DISTANCE.name))
    seed = int(kept.context.get("seed", 0))
    run = Run(instance, Stop(DEFAULT_DEADLINE), seed, objective=aim)
    run.begin(kept.backend)
    use_reads(run, kept.backend, model, samples)
    shorten_tours(run)
    bound_from_below(run)
    return result_of(run, kept.backend)


def _remote(strategy: Strategy, options: dict[str, Any]) -> PickingSampler:
    sampler = strategy.sampler
    if sampler is None or not sampler.runs_remotely(**options):
        raise InputError(
            f"backend {strategy.name} runs on this machine: there is no job to hand over",
            field="backend",
            advice="wait for it, or name a remote one",
        )
    return sampler
