"""The life of jobs on other people's machines: credentials, cost, retries, timing, the store.

This room lies below the backends: remote samplers implement `RemoteService` and hand their
`sample` to `run_job`. It imports nothing of ours but the errors, and no SDK until it must.
"""

from qrobot.jobs.circuits import CircuitJobs
from qrobot.jobs.cost import by_shots, by_time, check_budget, device_price, price
from qrobot.jobs.credentials import Presence, presence, require
from qrobot.jobs.driver import fetch_job, refresh, run_job
from qrobot.jobs.job import (
    LIMITS,
    PARAMETERS,
    Answer,
    Estimate,
    JobOptions,
    Keep,
    RemoteJob,
    RemoteService,
    State,
)
from qrobot.jobs.redaction import redact, redact_data, register_secret
from qrobot.jobs.retry import Backoff, with_retries
from qrobot.jobs.samples import breakdown, json_data, timing_fields
from qrobot.jobs.store import JobStore, default_path

__all__ = [
    "LIMITS",
    "PARAMETERS",
    "Answer",
    "Backoff",
    "CircuitJobs",
    "Estimate",
    "JobOptions",
    "JobStore",
    "Keep",
    "Presence",
    "RemoteJob",
    "RemoteService",
    "State",
    "breakdown",
    "by_shots",
    "by_time",
    "check_budget",
    "default_path",
    "device_price",
    "fetch_job",
    "json_data",
    "presence",
    "price",
    "redact",
    "redact_data",
    "refresh",
    "register_secret",
    "require",
    "run_job",
    "timing_fields",
    "with_retries",
]
