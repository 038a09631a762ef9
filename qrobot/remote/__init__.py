"""The life of jobs on other people's machines: credentials, cost, retries, timing, the store.

This room lies below the backends: remote samplers implement `RemoteService` and hand their
`sample` to `run_job`. It imports nothing of ours but the errors, and no SDK until it must.
"""

from qrobot.remote.circuits import BraketTasks, RuntimeJobs
from qrobot.remote.cost import by_shots, by_time, check_budget, device_price, price
from qrobot.remote.credentials import Presence, presence, require
from qrobot.remote.driver import fetch_job, refresh, run_job
from qrobot.remote.fallback import Fallback, run_with_fallback
from qrobot.remote.job import Answer, Estimate, RemoteJob, State
from qrobot.remote.manage import cancel, fetch, refresh_all
from qrobot.remote.redaction import redact, redact_data, register_secret
from qrobot.remote.retry import Backoff, with_retries
from qrobot.remote.samples import plain
from qrobot.remote.service import LIMITS, PARAMETERS, Keep, Options, RemoteService
from qrobot.remote.store import JobStore, default_path
from qrobot.remote.timing import breakdown, timing_fields

__all__ = [
    "LIMITS",
    "PARAMETERS",
    "Answer",
    "Backoff",
    "BraketTasks",
    "Estimate",
    "Fallback",
    "JobStore",
    "Keep",
    "Options",
    "Presence",
    "RemoteJob",
    "RemoteService",
    "RuntimeJobs",
    "State",
    "breakdown",
    "by_shots",
    "by_time",
    "cancel",
    "check_budget",
    "default_path",
    "device_price",
    "fetch",
    "fetch_job",
    "plain",
    "presence",
    "price",
    "redact",
    "redact_data",
    "refresh",
    "refresh_all",
    "register_secret",
    "require",
    "run_job",
    "run_with_fallback",
    "timing_fields",
    "with_retries",
]
