"""Jobs by name, for `qrobot jobs` and for programs: refresh, fetch, cancel.

Each job is asked for at the backend that submitted it; the life of a job is in `qrobot.jobs`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from qrobot.errors import CredentialsError, InputError, MissingExtraError, RemoteError
from qrobot.jobs.circuits import CircuitJobs
from qrobot.jobs.driver import fetch_job, refresh
from qrobot.jobs.job import RemoteJob, RemoteService
from qrobot.jobs.retry import with_retries
from qrobot.jobs.store import JobStore

if TYPE_CHECKING:
    import dimod

__all__ = ["cancel", "fetch", "refresh_all", "service_of"]

GetBackend = Callable[[str], Any]
"""As `qrobot.backends.get`."""


def _adapters() -> dict[str, type[CircuitJobs]]:
    """Return by service what opens jobs whose sampler has no say in it."""
    from qrobot.backends.braket.jobs import BraketTasks
    from qrobot.backends.qiskit.jobs import RuntimeJobs

    return {one.service: one for one in (BraketTasks, RuntimeJobs)}


def service_of(job: RemoteJob, get_backend: GetBackend) -> RemoteService:
    """Return the backend that submitted a job.

    Raises
    ------
    InputError
        When that backend is not one whose jobs can be fetched.
    """
    adapter = _adapters().get(str(job.context.get("service")))
    if adapter is not None:
        return adapter(job.backend, device=job.device)
    backend = get_backend(job.backend)
    if not isinstance(backend, RemoteService):
        raise InputError(
            f"backend {job.backend} of job {job.id} keeps no jobs", advice="see 'qrobot backends'"
        )
    return backend


def refresh_all(jobs: list[RemoteJob], store: JobStore, get_backend: GetBackend) -> list[str]:
    """Ask the services for the states of jobs that may still run; return what went wrong."""
    from qrobot.jobs.redaction import redact

    troubles: list[str] = []
    unreachable: set[str] = set()
    for job in jobs:
        if job.ended or job.backend in unreachable:
            continue
        try:
            refresh(service_of(job, get_backend), job, store)
        except (CredentialsError, MissingExtraError) as error:
            unreachable.add(job.backend)  # every other job of it would fail alike
            troubles.append(f"{job.backend}: {redact(error)}")
        except Exception as error:
            if isinstance(error, RemoteError) and "cannot be reached" in str(error):
                unreachable.add(job.backend)
            troubles.append(f"{job.backend}, job {job.id}: {redact(error)}")
    return troubles


def fetch(name: str, store: JobStore, get_backend: GetBackend) -> dimod.SampleSet:
    """Return the samples of a job by its name.

    Raises
    ------
    InputError
        When there is no such job.
    RemoteError
        When it is not done, or has failed.
    """
    job = store.get(name)
    kept = store.answer(job)
    return kept if kept is not None else fetch_job(service_of(job, get_backend), job, store)


def cancel(name: str, store: JobStore, get_backend: GetBackend) -> RemoteJob:
    """Ask a service to drop a job; return it with its new state.

    Raises
    ------
    InputError
        When there is no such job, or it is over.
    RemoteError
        When the service cannot be asked.
    """
    job = store.get(name)
    if job.ended:
        raise InputError(f"job {job.id} is {job.state} already", field="job")
    service = service_of(job, get_backend)
    refresh(service, job, store)
    if job.ended:
        return job
    if not job.remote_id:
        job.problem = f"{service.title} never confirmed it, and shows no job labelled {job.id}"
        job.state = "cancelled"
        return store.update(job)
    with_retries(lambda: service.cancel(job), what=service.title)
    job.state = "cancelled"
    return store.update(job)
