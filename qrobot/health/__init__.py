"""Checks with known answers: proof that the installed stacks compute, and compute right.

Every check imports one stack and lets it compute something whose answer is known from
elsewhere. Each runs in a process of its own, so that nothing it does can end the run.
"""

from qrobot.health.check import Check, difference
from qrobot.health.checks import all_checks, choose
from qrobot.health.model import SCHEMA, CheckResult, report
from qrobot.health.runner import Limits, run

__all__ = [
    "SCHEMA",
    "Check",
    "CheckResult",
    "Limits",
    "all_checks",
    "choose",
    "difference",
    "report",
    "run",
]
