"""What the samplers behind D-Wave Leap share: one connection, and the life of their jobs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import dimod

from qrobot._extras import load
from qrobot.backends.base import Capabilities
from qrobot.backends.sampler import Parameter, PickingSampler
from qrobot.errors import CredentialsError, RemoteError
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
from qrobot.jobs.circuits import instant
from qrobot.jobs.cost import by_time, price, price_source
from qrobot.jobs.credentials import SERVICES
from qrobot.jobs.redaction import register_secret

__all__ = ["DWaveCloudSampler", "answered", "opened"]

STATES: dict[str, State] = {
    "PENDING": "queued",
    "IN_PROGRESS": "running",
    "COMPLETED": "done",
    "FAILED": "failed",
    "CANCELLED": "cancelled",
}


def check_token(config: dict[str, Any]) -> None:
    """Refuse at once, without asking a network, when there is no token.

    Parameters
    ----------
    config
        ``config_file`` and ``profile``, when they are not the default ones.

    Raises
    ------
    CredentialsError
        When the SDK's files and variables hold no token, or cannot be read.
    """
    from dwave.cloud.config import load_config

    named = {name: config[name] for name in ("config_file", "profile") if name in config}
    advice = SERVICES["dwave"][2]
    try:
        found = load_config(**named)
    except Exception as error:
        why = type(error).__name__
    else:
        token = found.get("token")
        register_secret(token)
        if token:
            return
        why = ""
    reason = f" ({why} in the configuration of the D-Wave SDK)" if why else ""
    raise CredentialsError(f"there are no credentials for D-Wave Leap{reason}; {advice}")


def connection(config: dict[str, Any]) -> dict[str, Any]:
    """Return arguments of a D-Wave client that gives up sooner than the SDK would.

    The SDK's own files and variables win over these defaults.
    """
    defaults = {"request_timeout": 30.0, "http_retry_total": 2, "http_retry_backoff_factor": 0.1}
    return {"defaults": defaults} | config


def opened(sampler: Any, config: dict[str, Any]) -> Any:
    """Return a sampler of dwave-system; when it cannot be made, leave no thread behind.

    The SDK starts a dozen threads before it asks for solvers, and forgets them when that
    fails: a robot that tries all day would run out of them.
    """
    made = sampler.__new__(sampler)
    try:
        sampler.__init__(made, **config)
    except Exception:
        client = getattr(made, "client", None)
        if client is not None:
            client.close(wait=False)
        raise
    return made


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
        self._problems: Any = None
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
        self._device, self._problems = device, None
        return self._child

    def close(self) -> None:
        """Give up the connection and its threads; the next use makes another one.

        Jobs go on at the service, and nobody waits for them here.
        """
        if self._given is None and self._child is not None:
            problems, child = self._problems, self._child
            self._child = self._problems = None
            if problems is not None:
                problems.close()
            child.client.close(wait=False)

    @property
    def client(self) -> Any:
        """The SDK's client; ``None`` for a mock, which has no service behind it."""
        return getattr(self.connect(), "client", None)

    @property
    def problems(self) -> Any:
        """The SDK's resource of problems: what the service knows of its jobs by their ids."""
        if self._problems is None:
            from dwave.cloud.api.resources import Problems

            self._problems = Problems.from_config(self.client.config)
        return self._problems

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
        if self.client is not None:
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
        if self.client is None:
            return "failed", "the mock forgot the job"
        found = self.problems.get_problem_status(job.remote_id)
        state = STATES.get(str(getattr(found.status, "value", found.status)), "running")
        why = str(getattr(found, "error_message", "") or "") if state == "failed" else ""
        return state, why

    def future(self, job: RemoteJob) -> Any:
        """Return the SDK's object of a job at the service."""
        if self.client is None:
            raise RemoteError(f"{self.title} job {job.id} is gone with the mock that ran it")
        return self.client.retrieve_answer(job.remote_id)

    def raw_answer(self, job: RemoteJob) -> Answer:
        """Return the samples as the solver gave them."""
        if job.remote_id in self._local:
            samples = self._local.pop(job.remote_id)
            return Answer(samples, run=run_seconds(samples.info))
        future = self.future(job)
        samples = future.sampleset
        samples.resolve()
        return answered(samples, future)

    def cancel(self, job: RemoteJob) -> None:
        """Ask the service to drop a job."""
        if self.client is not None:
            self.problems.cancel_problem(job.remote_id)

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its label."""
        if self.client is None:
            return None
        found = self.problems.list_problems(label=job.id, max_results=1)
        return str(found[0].id) if found else None

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


def answered(samples: dimod.SampleSet, future: Any) -> Answer:
    """Return samples with what the service tells about the times of their job."""
    return Answer(
        samples,
        run=run_seconds(samples.info),
        received=instant(future.time_received),
        solved=instant(future.time_solved),
    )


def run_seconds(info: dict[str, Any]) -> float | None:
    """Return the device's own seconds: QPU access, or run time of a hybrid solver."""
    timing = info.get("timing")
    for numbers in (info, timing if isinstance(timing, dict) else {}):
        for name in ("run_time", "qpu_access_time"):
            if isinstance(value := numbers.get(name), int | float):
                return float(value) / 1e6
    return None
