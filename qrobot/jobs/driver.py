"""The life of a remote job, the same for every service."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from qrobot.errors import QRobotError, RemoteError
from qrobot.jobs.cost import check_budget
from qrobot.jobs.job import Answer, Estimate, JobOptions, RemoteJob, RemoteService, pack_model
from qrobot.jobs.redaction import redact
from qrobot.jobs.retry import Kind, classify, with_retries
from qrobot.jobs.samples import add_job, breakdown, empty
from qrobot.jobs.store import JobStore

__all__ = ["fetch_job", "refresh", "run_job"]

if TYPE_CHECKING:
    import dimod

POLL_FIRST, POLL_LONGEST = 0.05, 5.0
"""Seconds between questions about a job: they grow by half each time."""


def run_job(
    service: RemoteService,
    bqm: dimod.BinaryQuadraticModel,
    options: JobOptions | None = None,
    *,
    store: JobStore | None = None,
    **parameters: Any,
) -> dimod.SampleSet:
    """Submit a job, wait for it, and return its samples.

    Parameters
    ----------
    store
        Where the job is kept; default: the user's own.
    **parameters
        Sampling parameters of the device.

    Returns
    -------
    dimod.SampleSet
        ``info["remote"]`` holds the job's id, device, estimate and seconds of each part.

    Raises
    ------
    CredentialsError, RemoteError, BackendError, InputError
        See `with_retries` and `check_budget`. An interrupted or late wait is a RemoteError
        that names the job, which goes on.
    """
    chosen = options or JobOptions()
    if bqm.num_variables == 0:
        import dimod

        return dimod.SampleSet.from_samples_bqm([{}], bqm)  # nothing to ask anybody
    estimate = _call(service, chosen, lambda: service.estimate(bqm, **parameters))
    if chosen.dry_run:
        return empty(bqm, {"dry_run": True, "estimate": estimate.to_dict()})
    check_budget(estimate, chosen.max_cost)
    own = store is None
    kept = JobStore() if store is None else store
    try:
        return _run(service, bqm, chosen, kept, estimate, parameters)
    finally:
        if own:
            kept.close()


def _run(
    service: RemoteService,
    bqm: dimod.BinaryQuadraticModel,
    options: JobOptions,
    store: JobStore,
    estimate: Estimate,
    parameters: dict[str, Any],
) -> dimod.SampleSet:
    job = store.add(
        RemoteJob(
            service.name,
            variables=bqm.num_variables,
            model=pack_model(bqm),
            context=dict(options.context or {}),
            estimate=estimate,
        )
    )

    def keep(context: dict[str, Any]) -> None:
        job.context |= context
        store.update(job)

    kind: Kind = "final"

    def submit() -> tuple[str, str]:
        nonlocal kind
        kind = "final"
        try:
            return service.submit(bqm, label=job.id, keep=keep, **parameters)
        except QRobotError:
            raise
        except Exception as error:
            kind = classify(error)
            raise

    begun = time.perf_counter()
    try:
        job.remote_id, job.device = with_retries(
            submit,
            what=service.title,
            backoff=options.backoff,
            idempotent=False,
            stop=options.interrupt_function,
        )
    except QRobotError as error:
        # A job whose answer was lost may have arrived: `refresh` looks for its label.
        job.state = "submitting" if kind == "lost" else "failed"
        job.problem = redact(error)
        store.update(job)
        raise
    job.state = "queued"
    job.timings["submit"] = time.perf_counter() - begun
    store.update(job)
    if not options.wait:
        return empty(bqm, job.to_dict())
    _wait(service, job, store, options, begun)
    return fetch_job(service, job, store, options=options, begun=begun)


def _wait(
    service: RemoteService, job: RemoteJob, store: JobStore, options: JobOptions, begun: float
) -> None:
    pause = POLL_FIRST
    while True:
        refresh(service, job, store, options)
        if job.state == "done":
            return
        if job.ended:
            why = job.problem or "the service gave no reason"
            raise RemoteError(f"{service.title} job {job.id} {job.state}: {why}")
        stop = options.interrupt_function
        interrupted = stop is not None and stop()
        late = options.timeout is not None and time.perf_counter() - begun > options.timeout
        if interrupted or late:
            why = "was interrupted" if interrupted else f"took longer than {options.timeout:g} s"
            raise RemoteError(
                f"the wait for {service.title} {why}; the job goes on ({job.state}): 'qrobot jobs"
                f" fetch {job.id}' gets it, 'qrobot jobs cancel {job.id}' drops it"
            )
        left = pause
        if options.timeout is not None:
            left = min(left, max(0.0, options.timeout - (time.perf_counter() - begun)) + 0.001)
        _sleep(left, stop)
        pause = min(POLL_LONGEST, pause * 1.5)


def _sleep(seconds: float, stop: Callable[[], bool] | None) -> None:
    end = time.perf_counter() + seconds
    while (left := end - time.perf_counter()) > 0 and not (stop is not None and stop()):
        time.sleep(min(left, 0.1))


def refresh(
    service: RemoteService, job: RemoteJob, store: JobStore, options: JobOptions | None = None
) -> RemoteJob:
    """Ask the service for the state of a job and keep it; return the job."""
    if job.ended:
        return job
    chosen = options or JobOptions()
    before = (job.state, job.remote_id)
    if not job.remote_id:
        found = _call(service, chosen, lambda: service.find(job))
        if found is None:
            return job
        job.remote_id = found
    job.state, problem = _call(service, chosen, lambda: service.poll(job))
    job.problem = redact(problem)
    if (job.state, job.remote_id) != before:
        store.update(job)
    return job


def fetch_job(
    service: RemoteService,
    job: RemoteJob,
    store: JobStore,
    *,
    options: JobOptions | None = None,
    begun: float | None = None,
) -> dimod.SampleSet:
    """Return the samples of a job that is done, and keep them.

    Parameters
    ----------
    service
        The sampler that submitted it.
    store
        Where it is kept; an answer that was fetched before is taken from there.
    begun
        Our clock (`time.perf_counter`) when it was submitted, where this process did it.

    Raises
    ------
    RemoteError
        When the job is not done, or has failed.
    """
    known = store.answer(job)
    if known is not None:
        return known
    refresh(service, job, store, options)
    if job.state != "done":
        why = f"is {job.state}" if not job.problem else f"is {job.state}: {job.problem}"
        raise RemoteError(f"{service.title} job {job.id} {why}; there is nothing to fetch")
    started = time.perf_counter()
    answer = _call(service, options or JobOptions(), lambda: service.fetch(job))
    ended = time.perf_counter()
    submit = job.timings.get("submit", 0.0)
    total = ended - begun if begun is not None else _age(answer, submit, ended - started)
    job.timings = breakdown(
        submit=submit,
        total=total,
        fetch=ended - started,
        run=answer.run,
        received=answer.received,
        solved=answer.solved,
    )
    samples = answer.samples
    add_job(samples, job)
    store.update(job)
    store.keep_answer(job, samples)
    return samples


def _age(answer: Answer, submit: float, fetch: float) -> float:
    """Return what a job took when another process submitted it: our clock cannot tell."""
    run = answer.run or 0.0
    if answer.received is not None and answer.solved is not None:
        run = max(run, answer.solved - answer.received)
    return submit + fetch + run


def _call(service: RemoteService, options: JobOptions, call: Callable[[], Any]) -> Any:
    return with_retries(
        call, what=service.title, backoff=options.backoff, stop=options.interrupt_function
    )
