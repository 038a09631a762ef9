"""Sampler jobs of Qiskit Runtime: opened again by their id, found by their tag."""

from __future__ import annotations

from typing import Any, ClassVar

from qrobot.backends.qiskit.account import service
from qrobot.jobs.circuits import CircuitJobs, instant, samples_of
from qrobot.jobs.job import Answer, RemoteJob, State

__all__ = ["RuntimeJobs"]


class RuntimeJobs(CircuitJobs):
    """Sampler jobs of Qiskit Runtime; `start` should set the job tag to the label."""

    service = "ibm"
    title = "IBM Quantum"
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
