"""What the samplers behind D-Wave Leap share: one connection, and the life of their jobs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import dimod

from qrobot._extras import load
from qrobot.backends.base import Capabilities
from qrobot.backends.dwave.jobs import DWaveJobs, check_token, connection, run_seconds
from qrobot.backends.sampler import Parameter, PickingSampler
from qrobot.errors import RemoteError
from qrobot.jobs import (
    LIMITS,
    Answer,
    Backoff,
    Estimate,
    JobOptions,
    Keep,
    RemoteJob,
    State,
    run_job,
    with_retries,
)
from qrobot.jobs.cost import by_time, price, price_source

__all__ = ["DWaveCloudSampler"]


class DWaveCloudSampler(PickingSampler):
    """A sampler behind D-Wave Leap; implements `qrobot.jobs.RemoteService`.

    Parameters
    ----------
    child
        A sampler of dwave-system to use, or a mock of one; default: one made from the SDK's
        own configuration at the first use.
    **config
        For that one, such as ``profile`` or ``endpoint``.
    """

    title = "D-Wave Leap"
    capabilities = Capabilities(kind="sampler", local=False, deterministic=False)
    accepts: Mapping[str, Parameter] = LIMITS

    def __init__(self, child: Any = None, **config: Any) -> None:
        self._given = child
        self._config = config
        self._child: Any = child
        self._device: str | None = None
        self._limit: float | None = None
        self._backoff: Backoff | None = None
        self._asked: Any = None
        self._jobs: DWaveJobs | None = None
        self._local: dict[str, dimod.SampleSet] = {}

    @property
    def properties(self) -> dict[str, Any]:
        """What the solver says about itself, once there is a connection."""
        return dict(self._child.properties) if self._child is not None else {}

    @abstractmethod
    def make_child(self, config: dict[str, Any]) -> Any:
        """Return the sampler of dwave-system."""

    def connect(self, device: str | None = None) -> Any:
        """Return the sampler of dwave-system, made at the first use.

        Raises
        ------
        CredentialsError
            When there is no token (at once, without asking a network), or it is refused.
        RemoteError
            When the service cannot be reached.
        MissingExtraError
            When the SDK is not installed.
        """
        if self._given is not None or (self._child is not None and device in (None, self._device)):
            return self._child
        load("dwave.system", f"backend {self.name}")
        if "token" not in self._config:
            check_token(self._config)
        config = connection(self._config)
        if device is not None:
            config["solver"] = device
        if self._limit is not None:  # one try of the SDK, then ours with their own timeout
            config |= {"request_timeout": min(30.0, self._limit), "http_retry_total": 0}
        self._child = with_retries(
            lambda: self.make_child(config),
            what=self.title,
            backoff=self._backoff,
            stop=self._asked,
        )
        self._device, self._jobs = device, None
        return self._child

    def close(self) -> None:
        """Give up the connection and its threads; the next use makes another one.

        Jobs go on at the service, and nobody waits for them here.
        """
        if self._given is None and self._child is not None:
            jobs, child = self._jobs, self._child
            self._child = self._jobs = None
            if jobs is not None:
                jobs.close()
            child.client.close(wait=False)

    @property
    def jobs(self) -> DWaveJobs | None:
        """The jobs of the connection; ``None`` for a mock, which has no service behind it."""
        if self._jobs is None:
            client = getattr(self.connect(), "client", None)
            self._jobs = DWaveJobs(client) if client is not None else None
        return self._jobs

    def device_name(self) -> str:
        """Return the name of the solver."""
        solver = getattr(self._child, "solver", None)
        name = getattr(solver, "name", None) or self.properties.get("chip_id")
        return str(name or type(self._child).__name__)

    def sample(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> dimod.SampleSet:
        """Submit a model, wait for the answer and return it.

        Parameters
        ----------
        bqm
            Any binary quadratic model.
        **parameters
            Names of `parameters`; those of the job's life are in `qrobot.jobs.JobOptions`.

        Returns
        -------
        dimod.SampleSet
            ``info["remote"]``: the job's id, device, estimate and seconds of each part.

        Raises
        ------
        CredentialsError
            When the token is absent or refused.
        RemoteError
            When the service cannot be reached, fails or is late.
        BackendError
            When the model does not fit, or would cost too much.
        """
        options = JobOptions.take_from(parameters)
        self._limit, self._backoff = options.timeout, options.backoff
        self._asked = options.interrupt_function
        return run_job(self, bqm, options, **parameters)

    def _left(self) -> float:
        """Return the seconds that a run's stop leaves, at least one; ``inf`` without one."""
        left = getattr(self._asked, "remaining", None)
        return max(1.0, float(left)) if isinstance(left, int | float) else float("inf")

    def usd(self, seconds: float, what: str) -> Estimate:
        """Return the cost of so many seconds of this solver."""
        rate = float(self.properties.get("quota_conversion_rate") or 1)
        note = f"price {price_source('dwave-hour')}"
        return by_time(seconds, price("dwave-hour") / 3600 / rate, what, note)

    def id_and_device(self, samples: Any) -> tuple[str, str]:
        """Return the service's id of a job that was just submitted, and the device."""
        if self.jobs is not None:
            remote_id = samples.wait_id(timeout=self._limit or 120.0)
            if remote_id:
                return str(remote_id), self.device_name()
            (samples.resolve if hasattr(samples, "resolve") else samples.result)()  # raises why
            raise RemoteError(f"{self.title} gave the job no id")
        samples.resolve()
        remote_id = str(samples.info.get("problem_id") or f"local-{id(samples)}")
        self._local[remote_id] = samples
        return remote_id, self.device_name()

    def poll(self, job: RemoteJob) -> tuple[State, str]:
        """Return the state of a job and why it failed."""
        if job.remote_id in self._local:
            return "done", ""
        jobs = self.jobs
        return jobs.poll(job) if jobs is not None else ("failed", "the mock forgot the job")

    def raw_answer(self, job: RemoteJob) -> Answer:
        """Return the samples as the solver gave them."""
        if job.remote_id in self._local:
            samples = self._local.pop(job.remote_id)
            return Answer(samples, run=run_seconds(samples.info))
        if self.jobs is None:
            raise RemoteError(f"{self.title} job {job.id} is gone with the mock that ran it")
        return self.jobs.answer(job)

    def cancel(self, job: RemoteJob) -> None:
        """Ask the service to drop a job."""
        if self.jobs is not None:
            self.jobs.cancel(job)

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its label."""
        return self.jobs.find(job) if self.jobs is not None else None

    @abstractmethod
    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:
        """Return what a job would cost."""

    @abstractmethod
    def submit(
        self, bqm: dimod.BinaryQuadraticModel, *, label: str, keep: Keep, **parameters: Any
    ) -> tuple[str, str]:
        """Hand over a job."""

    @abstractmethod
    def fetch(self, job: RemoteJob) -> Answer:
        """Return the samples of a job that is done."""
