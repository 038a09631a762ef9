"""`solve`: choice of strategy, deadline, decode, repair, polish, bound, result."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from qrobot.planning.own_trips import EachRobot, OwnTrip
from qrobot.planning.result import Result, SamplerReport, Timing
from qrobot.planning.run import Progress
from qrobot.planning.solving import DEFAULT_DEADLINE, solve

if TYPE_CHECKING:
    from qrobot.planning.each_robot import route_each
    from qrobot.planning.ranking import RankedOrder, rank_orders
    from qrobot.planning.remote_jobs import collect, estimate, submit
    from qrobot.planning.replanning import Replan, replan
    from qrobot.planning.state import RobotState, State, read_state, state_at

__all__ = [
    "DEFAULT_DEADLINE",
    "EachRobot",
    "OwnTrip",
    "Progress",
    "RankedOrder",
    "Replan",
    "Result",
    "RobotState",
    "SamplerReport",
    "State",
    "Timing",
    "collect",
    "estimate",
    "rank_orders",
    "read_state",
    "replan",
    "route_each",
    "solve",
    "state_at",
    "submit",
]


_LAZY = {
    "RankedOrder": "qrobot.planning.ranking",
    "Replan": "qrobot.planning.replanning",
    "RobotState": "qrobot.planning.state",
    "State": "qrobot.planning.state",
    "collect": "qrobot.planning.remote_jobs",
    "estimate": "qrobot.planning.remote_jobs",
    "rank_orders": "qrobot.planning.ranking",
    "read_state": "qrobot.planning.state",
    "replan": "qrobot.planning.replanning",
    "route_each": "qrobot.planning.each_robot",
    "state_at": "qrobot.planning.state",
    "submit": "qrobot.planning.remote_jobs",
}
"""Loaded on first use: remote jobs need dimod, which takes longer to load than all of the rest."""


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'qrobot.planning' has no attribute {name!r}")
    return getattr(importlib.import_module(_LAZY[name]), name)
