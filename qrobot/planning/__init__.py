"""`solve`: choice of strategy, deadline, decode, repair, polish, bound, result."""

from qrobot.planning.remote_jobs import collect, estimate, submit
from qrobot.planning.result import Result, SamplerReport, Timing
from qrobot.planning.run import Progress
from qrobot.planning.solving import DEFAULT_DEADLINE, solve

__all__ = [
    "DEFAULT_DEADLINE",
    "Progress",
    "Result",
    "SamplerReport",
    "Timing",
    "collect",
    "estimate",
    "solve",
    "submit",
]
