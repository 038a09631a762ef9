"""Jobs of circuits: Amazon Braket's quantum tasks and Qiskit Runtime's jobs.

The samplers build and start circuits; these adapters keep what was started alive beyond
the process: a job is opened again by its id alone. Variable k of the model is qubit k.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any, ClassVar

from qrobot.errors import RemoteError
from qrobot.remote import ibm
from qrobot.remote.aws import session
from qrobot.remote.job import Answer, Estimate, RemoteJob, State
from qrobot.remote.service import Keep

if TYPE_CHECKING:
    import dimod
    import numpy as np
    import numpy.typing as npt

__all__ = ["ADAPTERS", "BraketTasks", "CircuitJobs", "RuntimeJobs"]

Start = Callable[[str], Any]
"""Starts the circuit under a label (a tag at the service); returns the SDK's job object."""


class CircuitJobs:
    """What both services share; a `RemoteService` for one circuit.

    Parameters
    ----------
    name
        Of the backend.
    start
        Starts the circuit; not needed to open jobs again.
    device
        Its name.
    cost
        What the job is expected to cost.
    sdk
        The SDK's session or service, when it is not the default one.
    kept
        Plain data that another process needs to find the job, such as a region.
    """

    service: ClassVar[str]
    title: str

    def __init__(
        self,
        name: str,
        start: Start | None = None,
        *,
        device: str = "",
        cost: Estimate | None = None,
        sdk: Any = None,
        kept: dict[str, Any] | None = None,
    ) -> None:
        self.name = name
        self._start = start
        self._device = device
        self._cost = cost or Estimate(None, None, "no price is known")
        self._sdk = sdk
        self._kept = dict(kept or {})
        self._open: dict[str, Any] = {}

    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:
        """Return what was reckoned when the circuit was built."""
        del bqm, parameters
        return self._cost

    def submit(
        self, bqm: dimod.BinaryQuadraticModel, *, label: str, keep: Keep, **parameters: Any
    ) -> tuple[str, str]:
        """Start the circuit."""
        del bqm, parameters
        if self._start is None:
            raise RemoteError(f"{self.title}: there is no circuit to start")
        keep({"service": self.service, **self._kept})
        job = self._start(label)
        remote_id = self.id_of(job)
        self._open[remote_id] = job
        return remote_id, self._device

    def opened(self, job: RemoteJob) -> Any:
        """Return the SDK's object of a job."""
        if job.remote_id not in self._open:
            self._open[job.remote_id] = self.reopen(job)
        return self._open[job.remote_id]

    def id_of(self, job: Any) -> str:
        """Return the service's id of an SDK's object."""
        raise NotImplementedError

    def reopen(self, job: RemoteJob) -> Any:
        """Return the SDK's object of a job that another process started."""
        raise NotImplementedError

    def poll(self, job: RemoteJob) -> tuple[State, str]:
        """Return the state of a job and why it failed."""
        raise NotImplementedError

    def fetch(self, job: RemoteJob) -> Answer:
        """Return one row a shot, in the sequence that they were measured in.

        What the sampler kept beside the job under ``info`` is in the samples' info.
        """
        raise NotImplementedError

    def cancel(self, job: RemoteJob) -> None:
        """Ask the service to drop a job."""
        self.opened(job).cancel()

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its label, where it can be asked for."""
        del job
        return None


class BraketTasks(CircuitJobs):
    """Quantum tasks of Amazon Braket; `start` should set the tag ``qrobot`` to the label."""

    service = "braket"
    title = "Amazon Braket"
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
            _samples(found[:, columns], job),
            run=None if milliseconds is None else float(milliseconds) / 1e3,
            received=_instant(about.get("createdAt")),
            solved=_instant(about.get("endedAt")),
        )


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
            self._sdk = ibm.service()
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
            _samples(bits[:, : job.variables], job),
            run=usage.get("qpu_charge_time_seconds", usage.get("quantum_seconds")),
            received=_instant(stamps.get("created")),
            solved=_instant(stamps.get("finished")),
        )

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its tag."""
        found = self.runtime.jobs(job_tags=[job.id], limit=1)
        return self.id_of(found[0]) if found else None


ADAPTERS: dict[str, type[CircuitJobs]] = {one.service: one for one in (BraketTasks, RuntimeJobs)}
"""By what a job's context calls its service: they open jobs whose sampler has no say in it."""


def _samples(bits: npt.NDArray[np.int8], job: RemoteJob) -> dimod.SampleSet:
    import dimod

    bqm = job.bqm()
    values = 2 * bits - 1 if bqm.vartype is dimod.SPIN else bits
    info = dict(job.context.get("info") or {})
    return dimod.SampleSet.from_samples_bqm((values, list(bqm.variables)), bqm, info=info)


def _instant(moment: Any) -> float | None:
    """Return a datetime, or a text of one, as Unix seconds."""
    if isinstance(moment, str):
        try:
            moment = datetime.fromisoformat(moment)
        except ValueError:
            return None
    return float(moment.timestamp()) if isinstance(moment, datetime) else None
