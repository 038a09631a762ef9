"""What the QPU and the hybrid solvers of D-Wave Leap share: connection, states, answers."""

from __future__ import annotations

from typing import Any

from qrobot.errors import CredentialsError
from qrobot.jobs.credentials import SERVICES
from qrobot.jobs.job import Answer, RemoteJob, State
from qrobot.jobs.redaction import register_secret

__all__ = ["DWaveJobs", "check_token", "connection", "opened", "run_seconds", "seconds_of"]

_STATES: dict[str, State] = {
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


def seconds_of(moment: Any) -> float | None:
    """Return a datetime as Unix seconds."""
    return None if moment is None else float(moment.timestamp())


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


class DWaveJobs:
    """Jobs of a D-Wave client by their ids: state, cancelling, finding, answers.

    Parameters
    ----------
    client
        A ``dwave.cloud.Client``.
    """

    def __init__(self, client: Any) -> None:
        self.client = client
        self._problems: Any = None

    @property
    def problems(self) -> Any:
        """The SDK's resource of problems."""
        if self._problems is None:
            from dwave.cloud.api.resources import Problems

            self._problems = Problems.from_config(self.client.config)
        return self._problems

    def poll(self, job: RemoteJob) -> tuple[State, str]:
        """Return the state of a job and why it failed."""
        found = self.problems.get_problem_status(job.remote_id)
        status = str(getattr(found.status, "value", found.status))
        state = _STATES.get(status, "running")
        why = str(getattr(found, "error_message", "") or "") if state == "failed" else ""
        return state, why

    def cancel(self, job: RemoteJob) -> None:
        """Ask the service to drop a job."""
        self.problems.cancel_problem(job.remote_id)

    def find(self, job: RemoteJob) -> str | None:
        """Return the service's id of a job by its label."""
        found = self.problems.list_problems(label=job.id, max_results=1)
        return str(found[0].id) if found else None

    def answer(self, job: RemoteJob) -> Answer:
        """Return the raw samples of a job and what the service tells about its times."""
        future = self.client.retrieve_answer(job.remote_id)
        samples = future.sampleset
        samples.resolve()
        return Answer(
            samples,
            run=run_seconds(samples.info),
            received=seconds_of(future.time_received),
            solved=seconds_of(future.time_solved),
        )

    def close(self) -> None:
        """Give up the connection of this object; the client's own stays."""
        if self._problems is not None:
            self._problems.close()
            self._problems = None


def run_seconds(info: dict[str, Any]) -> float | None:
    """Return the device's own seconds: QPU access, or run time of a hybrid solver."""
    timing = info.get("timing")
    for numbers in (info, timing if isinstance(timing, dict) else {}):
        for name in ("run_time", "qpu_access_time"):
            if isinstance(value := numbers.get(name), int | float):
                return float(value) / 1e6
    return None
