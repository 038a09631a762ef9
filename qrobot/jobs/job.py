"""A remote job as plain data that outlives the process, its options, and who can run one."""

from __future__ import annotations

import secrets
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol, runtime_checkable

from qrobot._parameters import Parameter
from qrobot.errors import InputError
from qrobot.jobs.retry import Backoff

__all__ = [
    "ENDED",
    "LIMITS",
    "PARAMETERS",
    "STATES",
    "Answer",
    "Estimate",
    "JobOptions",
    "Keep",
    "RemoteJob",
    "RemoteService",
    "State",
    "pack_model",
]

if TYPE_CHECKING:
    import dimod

State = Literal["submitting", "queued", "running", "done", "failed", "cancelled"]

STATES: tuple[State, ...] = ("submitting", "queued", "running", "done", "failed", "cancelled")

ENDED: frozenset[State] = frozenset({"done", "failed", "cancelled"})
"""States that a job does not leave."""

Keep = Callable[[dict[str, Any]], None]
"""Keeps plain data beside the job, on the disk, before it is submitted."""

LIMITS: dict[str, Parameter] = {
    "timeout": Parameter("number", 0, above=True),
    "max_cost": Parameter("number", 0),
    "dry_run": Parameter("flag"),
    "wait": Parameter("flag"),
    "interrupt_function": Parameter("function"),
    "context": Parameter("names"),
}
"""What each parameter of a remote job's life takes; see `JobOptions`."""

PARAMETERS: dict[str, list[str]] = {name: [] for name in LIMITS}
"""Sampling parameters that every remote sampler takes; see `JobOptions`."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a job is expected to cost, before it is submitted.

    Parameters
    ----------
    usd
        US dollars; ``None`` when nobody can tell.
    seconds
        Billed seconds of the device; ``None`` when it does not bill by time.
    basis
        How it was reckoned, in words that a person can check.
    """

    usd: float | None
    seconds: float | None = None
    basis: str = ""

    def __str__(self) -> str:
        money = "unknown" if self.usd is None else f"{self.usd:.4g} USD"
        return f"{money} ({self.basis})" if self.basis else money

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {"usd": self.usd, "seconds": self.seconds, "basis": self.basis}


@dataclass(slots=True)
class Answer:
    """What a remote sampler fetched.

    Parameters
    ----------
    samples
        Resolved samples over the variables of the submitted model.
    run
        Seconds that the device itself worked, as the service tells; ``None``: not told.
    received, solved
        When the service took and finished the job, by its own clock, Unix seconds.
    """

    samples: dimod.SampleSet
    run: float | None = None
    received: float | None = None
    solved: float | None = None


@dataclass(slots=True)
class RemoteJob:
    """A job on somebody else's machine.

    Parameters
    ----------
    backend
        Name of the backend that submitted it and can fetch it.
    id
        Our name of the job; it is also its label at the service.
    remote_id
        The service's name of the job; empty until the service has taken it.
    device
        Machine or solver.
    state
        One of `STATES`.
    submitted
        Unix seconds.
    variables
        Number of variables of the model.
    model
        The packed model (see `pack_model`); its labels decode the samples.
    context
        Plain data that fetching and decoding need: an embedding, the instance.
    timings
        Seconds of submit, latency, queue, run and return, once known.
    estimate
        What it was expected to cost.
    problem
        Why it failed, one sentence.
    """

    backend: str
    id: str = field(default_factory=lambda: f"qr-{secrets.token_hex(6)}")
    remote_id: str = ""
    device: str = ""
    state: State = "submitting"
    submitted: float = field(default_factory=time.time)
    variables: int = 0
    model: bytes = b""
    context: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)
    estimate: Estimate = field(default_factory=lambda: Estimate(None))
    problem: str = ""

    @property
    def ended(self) -> bool:
        """Whether the job is over, for good or bad."""
        return self.state in ENDED

    def bqm(self) -> dimod.BinaryQuadraticModel:
        """Return the submitted model with its labels."""
        import dimod

        return dimod.BinaryQuadraticModel.from_file(zlib.decompress(self.model))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data without the model and the context."""
        return {
            "id": self.id,
            "remote_id": self.remote_id,
            "backend": self.backend,
            "device": self.device,
            "state": self.state,
            "submitted": self.submitted,
            "variables": self.variables,
            "timings": dict(self.timings),
            "estimate": self.estimate.to_dict(),
            "problem": self.problem,
        }


def pack_model(bqm: dimod.BinaryQuadraticModel) -> bytes:
    """Return a model as compressed bytes.

    Raises
    ------
    InputError
        When a label is neither number nor text nor a tuple of them.
    """
    import dimod
    import numpy as np

    # A view (such as bqm.spin) or a model of Python objects cannot be written as it is.
    copy = dimod.BinaryQuadraticModel(bqm.vartype, dtype=np.float64)
    copy.add_linear_from(dict(bqm.linear))
    copy.add_quadratic_from(dict(bqm.quadratic))
    copy.offset = float(bqm.offset)
    try:
        with copy.to_file() as file:
            data = file.read()
        same = dimod.BinaryQuadraticModel.from_file(data).variables == copy.variables
    except (TypeError, ValueError):
        same = False
    if not same:
        raise InputError(
            "a label of the model cannot be kept with the job",
            field="bqm",
            advice="use numbers, texts or tuples of them as labels",
        )
    return zlib.compress(data, 6)


@runtime_checkable
class RemoteService(Protocol):
    """A remote sampler's own part; `run_job` does the rest.

    The methods may raise anything: `run_job` turns it into our errors and retries where
    that is safe. None of them waits for the device, apart from `fetch` for the download.
    """

    name: str
    title: str
    """For messages: ``"D-Wave Leap"``."""

    def estimate(self, bqm: dimod.BinaryQuadraticModel, **parameters: Any) -> Estimate:
        """Return what a job would cost; submits nothing that bills."""
        ...

    def submit(
        self, bqm: dimod.BinaryQuadraticModel, *, label: str, keep: Keep, **parameters: Any
    ) -> tuple[str, str]:
        """Hand over a job; return the service's id and the device.

        Parameters
        ----------
        bqm
            The model.
        label
            Our id of the job, to be attached to it at the service.
        keep
            To be called, before handing over, with plain data that `fetch` will need.
        **parameters
            Sampling parameters of the device.
        """
        ...

    def poll(self, job: RemoteJob) -> tuple[State, str]:
        """Return the state of a job and, where it failed, why."""
        ...

    def fetch(self, job: RemoteJob) -> Answer:
        """Return the samples of a job that is done, over the variables of ``job.bqm()``."""
        ...

    def cancel(self, job: RemoteJob) -> None:
        """Ask the service to drop a job."""
        ...

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its label ``job.id``, or ``None``.

        For jobs whose process died between handing over and hearing the id.
        """
        ...


@dataclass(slots=True)
class JobOptions:
    """How a remote job is run; each is a sampling parameter of remote samplers.

    Parameters
    ----------
    timeout
        Seconds to wait for the answer; the job itself goes on. ``None``: no limit.
    max_cost
        US dollars; nothing is submitted when the estimate is above, or unknown.
    dry_run
        Only estimate: the samples are empty, ``info["remote"]["estimate"]`` tells.
    wait
        False: submit, and return empty samples with the job's id in the info.
    interrupt_function
        Asked while waiting; True ends the wait, not the job.
    context
        Plain data to keep beside the job, such as the instance that the model came from.
    backoff
        Of the calls.

    Raises
    ------
    InputError
        When one is of no use: before any work.
    """

    timeout: float | None = None
    max_cost: float | None = None
    dry_run: bool = False
    wait: bool = True
    interrupt_function: Callable[[], bool] | None = None
    context: dict[str, Any] | None = None
    backoff: Backoff = field(default_factory=Backoff)

    def __post_init__(self) -> None:
        for name, limit in LIMITS.items():
            limit.check(name, getattr(self, name))

    @classmethod
    def take_from(cls, parameters: dict[str, Any]) -> JobOptions:
        """Return the options among sampling parameters, and take them out of there."""
        taken = {name: parameters.pop(name) for name in PARAMETERS if name in parameters}
        given = {name: value for name, value in taken.items() if value is not None}
        return cls(**given, backoff=Backoff(timeout=given.get("timeout")))
