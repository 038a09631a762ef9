"""Checks with known answers: proof that the installed stacks compute, and compute right.

Every check imports one stack and lets it compute something whose answer is known from
elsewhere. Each runs in a process of its own, so that nothing it does can end the run.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from qrobot.health.check import PROFILES, Check, difference
    from qrobot.health.checks import all_checks, choose
    from qrobot.health.model import SCHEMA, CheckResult, Finding, Report
    from qrobot.health.process import Limits
    from qrobot.health.record import make_report, read_report
    from qrobot.health.runner import run, run_all
    from qrobot.health.system import system_findings

__all__ = [
    "PROFILES",
    "SCHEMA",
    "Check",
    "CheckResult",
    "Finding",
    "Limits",
    "Report",
    "all_checks",
    "choose",
    "difference",
    "make_report",
    "read_report",
    "run",
    "run_all",
    "system_findings",
]

# Loaded on first use: the process of every check passes here, and most of this is not for it.
_LAZY = {
    "PROFILES": "check",
    "SCHEMA": "model",
    "Check": "check",
    "CheckResult": "model",
    "Finding": "model",
    "Limits": "process",
    "Report": "model",
    "all_checks": "checks",
    "choose": "checks",
    "difference": "check",
    "make_report": "record",
    "read_report": "record",
    "run": "runner",
    "run_all": "runner",
    "system_findings": "system",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'qrobot.health' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_LAZY[name]}"), name)
    globals()[name] = value
    return value
