"""Who samples or solves: planners, samplers and the registry."""

from qrobot.backends.base import Capabilities, Planner, Routes, Search, Stop
from qrobot.backends.registry import available, capabilities, get, names

__all__ = [
    "Capabilities",
    "Planner",
    "Routes",
    "Search",
    "Stop",
    "available",
    "capabilities",
    "get",
    "names",
]
