"""Quantum tasks of Amazon Braket: opened again by their ARN, found by their tag."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any, ClassVar

from qrobot.backends.braket.devices import TITLE, session
from qrobot.errors import RemoteError
from qrobot.jobs.circuits import CircuitJobs, instant, samples_of
from qrobot.jobs.job import Answer, RemoteJob, State

__all__ = ["BraketTasks"]


class BraketTasks(CircuitJobs):
    """Quantum tasks of Amazon Braket; `start` should set the tag ``qrobot`` to the label."""

    service = "braket"
    title = TITLE
    states: ClassVar[dict[str, State]] = {
        "CREATED": "queued", "QUEUED": "queued", "RUNNING": "running", "COMPLETED": "done",
        "FAILED": "failed", "CANCELLING": "running", "CANCELLED": "cancelled",
    }  # fmt: skip

    def id_of(self, job: Any) -> str:
        """Return the ARN of a task."""
        return str(job.id)

    def reopen(self, job: RemoteJob) -> Any:
        """Return the task of an ARN."""
        from braket.aws import AwsQuantumTask

        asked = self._sdk or session(job.remote_id.split(":")[3])
        return AwsQuantumTask(job.remote_id, aws_session=asked)

    def find(self, job: RemoteJob) -> str | None:
        """Return the ARN of a task by its tag, among those of its device since its hour."""
        where = job.context.get("device")
        if not where:
            return None
        asked = self._sdk or session(job.context.get("region"))
        since = datetime.fromtimestamp(job.submitted, UTC) - timedelta(hours=1)
        filters = [
            {"name": "deviceArn", "operator": "EQUAL", "values": [where]},
            {"name": "createdAt", "operator": "GTE", "values": [since.isoformat()]},
        ]
        more: dict[str, str] = {}
        while True:
            page = asked.braket_client.search_quantum_tasks(filters=filters, **more)
            for task in page["quantumTasks"]:
                if task.get("tags", {}).get("qrobot") == job.id:
                    return str(task["quantumTaskArn"])
            if not page.get("nextToken"):
                return None
            more = {"nextToken": page["nextToken"]}

    def poll(self, job: RemoteJob) -> tuple[State, str]:
        """Return the state of a task and why it failed."""
        about = self.opened(job).metadata()
        state = self.states.get(str(about.get("status")), "running")
        return state, str(about.get("failureReason", "")) if state == "failed" else ""

    def fetch(self, job: RemoteJob) -> Answer:
        """Return the measured shots."""
        import numpy as np

        task = self.opened(job)
        about = task.metadata()
        result = task.result()
        if result is None or getattr(result, "measurements", None) is None:
            raise RemoteError(f"{self.title} job {job.id} ended without measurements")
        found = np.asarray(result.measurements, dtype=np.int8)
        qubits = [int(q) for q in result.measured_qubits]
        columns = [qubits.index(k) for k in range(job.variables)]
        extra = getattr(result, "additional_metadata", None)
        simulator = getattr(extra, "simulatorMetadata", None)
        milliseconds = getattr(simulator, "executionDuration", None)
        return Answer(
            samples_of(found[:, columns], job),
            run=None if milliseconds is None else float(milliseconds) / 1e3,
            received=instant(about.get("createdAt")),
            solved=instant(about.get("endedAt")),
        )
