"""What a sampler must be able to do so that its jobs can outlive the process."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from qrobot._parameters import Parameter
from qrobot.jobs.job import Answer, Estimate, RemoteJob, State
from qrobot.jobs.retry import Backoff

if TYPE_CHECKING:
    import dimod

__all__ = ["LIMITS", "PARAMETERS", "JobOptions", "Keep", "RemoteService"]

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


def check_limits(parameters: Mapping[str, Any]) -> None:
    """Check the limits of a remote job's life (`JobOptions`) before any work.

    Raises
    ------
    InputError
        When one is of no use.
    """
    for name, limit in LIMITS.items():
        limit.check(name, parameters.get(name))


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
    """

    timeout: float | None = None
    max_cost: float | None = None
    dry_run: bool = False
    wait: bool = True
    interrupt_function: Callable[[], bool] | None = None
    context: dict[str, Any] | None = None
    backoff: Backoff = field(default_factory=Backoff)

    @classmethod
    def take_from(cls, parameters: dict[str, Any]) -> JobOptions:
        """Return the options among sampling parameters, and take them out of there.

        Raises
        ------
        InputError
            When one is of no use.
        """
        check_limits(parameters)
        taken = {name: parameters.pop(name) for name in PARAMETERS if name in parameters}
        given = {name: value for name, value in taken.items() if value is not None}
        return cls(**given, backoff=Backoff(timeout=given.get("timeout")))
