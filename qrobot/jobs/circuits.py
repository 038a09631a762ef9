"""Jobs of circuits: what the services of gate-model machines share.

The samplers build and start circuits; these adapters keep what was started alive beyond
the process: a job is opened again by its id alone. Variable k of the model is qubit k.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from typing import TYPE_CHECKING, Any, ClassVar

from qrobot.errors import RemoteError
from qrobot.jobs.job import Answer, Estimate, Keep, RemoteJob, State

__all__ = ["CircuitJobs", "instant", "samples_of"]

if TYPE_CHECKING:
    import dimod
    import numpy as np
    import numpy.typing as npt

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


def samples_of(bits: npt.NDArray[np.int8], job: RemoteJob) -> dimod.SampleSet:
    """Return measured bits as the samples of a job's model, with what was kept beside it."""
    import dimod

    bqm = job.bqm()
    values = 2 * bits - 1 if bqm.vartype is dimod.SPIN else bits
    info = dict(job.context.get("info") or {})
    return dimod.SampleSet.from_samples_bqm((values, list(bqm.variables)), bqm, info=info)


def instant(moment: Any) -> float | None:
    """Return a datetime, or a text of one, as Unix seconds."""
    if isinstance(moment, str):
        try:
            moment = datetime.fromisoformat(moment)
        except ValueError:
            return None
    return float(moment.timestamp()) if isinstance(moment, datetime) else None
