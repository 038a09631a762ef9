"""`solve`: choice of strategy, deadline, decode, repair, polish, bound, result."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from qrobot.planning.result import Result, SamplerReport, Timing
from qrobot.planning.run import Progress
from qrobot.planning.solving import DEFAULT_DEADLINE, solve

if TYPE_CHECKING:
    from qrobot.planning.remote_jobs import collect, estimate, submit

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


def __getattr__(name: str) -> Any:
    # Loaded on first use: they need dimod, which takes longer to load than all of the rest.
    if name not in ("collect", "estimate", "submit"):
        raise AttributeError(f"module 'qrobot.planning' has no attribute {name!r}")
    return getattr(importlib.import_module("qrobot.planning.remote_jobs"), name)
