"""IBM Quantum: the account, a machine of it, and its jobs, opened again by id, found by tag."""

from __future__ import annotations

from typing import Any, ClassVar

from qrobot._extras import load
from qrobot.errors import BackendError, CredentialsError
from qrobot.jobs import JobOptions
from qrobot.jobs.circuits import CircuitJobs, instant, samples_of
from qrobot.jobs.credentials import require
from qrobot.jobs.job import Answer, RemoteJob, State
from qrobot.jobs.retry import with_retries

__all__ = ["TITLE", "RuntimeJobs", "machine", "service"]


TITLE = "IBM Quantum"


def service(limits: JobOptions | None = None) -> Any:
    """Return a ``QiskitRuntimeService`` from the SDK's own files and variables.

    Raises
    ------
    CredentialsError
        When there is no account (told without asking a network), or it is refused.
    RemoteError
        When the service cannot be reached.
    """
    limits = limits or JobOptions()
    require("ibm")
    refused = ""

    def opening() -> Any:
        nonlocal refused
        service = load("qiskit_ibm_runtime", TITLE).QiskitRuntimeService
        try:
            return service()
        except (AttributeError, KeyError, TypeError) as error:  # a bogus instance raises these
            refused = type(error).__name__
            return None

    found = with_retries(
        opening, what=TITLE, backoff=limits.backoff, stop=limits.interrupt_function
    )
    if found is None:
        raise CredentialsError(
            f"{TITLE} did not accept the account ({refused}: most often a wrong instance); save"
            " it again with QiskitRuntimeService.save_account"
        )
    return found


def machine(name: str, qubits: int, limits: JobOptions) -> Any:
    """Return a backend of the user's account.

    Parameters
    ----------
    name
        Its name; empty: the least busy one that is large enough.
    qubits
        That it must have.
    limits
        Of the calls.

    Raises
    ------
    BackendError
        When the account has no such machine.
    CredentialsError, RemoteError
        See `service`.
    """
    opened = service(limits)

    def asking() -> Any:
        try:
            if name:
                return opened.backend(name)
            return opened.least_busy(min_num_qubits=qubits, operational=True, simulator=False)
        except Exception as error:
            if type(error).__name__ == "QiskitBackendNotFoundError":
                return None
            raise

    found = with_retries(asking, what=TITLE, backoff=limits.backoff, stop=limits.interrupt_function)
    if found is None:
        wanted = f"is named {name!r}" if name else f"has {qubits} qubits or more"
        raise BackendError(f"no machine of this {TITLE} account {wanted}")
    return found


class RuntimeJobs(CircuitJobs):
    """Sampler jobs of Qiskit Runtime; `start` should set the job tag to the label."""

    service = "ibm"
    title = TITLE
    register = "meas"
    states: ClassVar[dict[str, State]] = {
        "INITIALIZING": "queued", "QUEUED": "queued", "RUNNING": "running", "DONE": "done",
        "ERROR": "failed", "CANCELLED": "cancelled",
    }  # fmt: skip

    @property
    def runtime(self) -> Any:
        """The SDK's service, from its own files and variables."""
        if self._sdk is None:
            self._sdk = service()
        return self._sdk

    def id_of(self, job: Any) -> str:
        """Return the id of a job."""
        return str(job.job_id())

    def reopen(self, job: RemoteJob) -> Any:
        """Return the job of an id."""
        return self.runtime.job(job.remote_id)

    def poll(self, job: RemoteJob) -> tuple[State, str]:
        """Return the state of a job and why it failed."""
        opened = self.opened(job)
        status = opened.status()
        state = self.states.get(str(getattr(status, "name", status)), "running")
        tell = getattr(opened, "error_message", None)
        return state, str(tell() or "") if state == "failed" and callable(tell) else ""

    def fetch(self, job: RemoteJob) -> Answer:
        """Return the measured shots."""
        import numpy as np

        opened = self.opened(job)
        measured = getattr(opened.result()[0].data, self.register)
        bits = np.asarray(measured.to_bool_array(order="little"), dtype=np.int8)
        metrics = opened.metrics() if callable(getattr(opened, "metrics", None)) else {}
        stamps, usage = metrics.get("timestamps", {}), metrics.get("usage", {})
        return Answer(
            samples_of(bits[:, : job.variables], job),
            run=usage.get("qpu_charge_time_seconds", usage.get("quantum_seconds")),
            received=instant(stamps.get("created")),
            solved=instant(stamps.get("finished")),
        )

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its tag."""
        found = self.runtime.jobs(job_tags=[job.id], limit=1)
        return self.id_of(found[0]) if found else None
