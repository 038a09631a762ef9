"""qRobot: order picking and batching for warehouse robots, quantum and classical.

>>> import qrobot
>>> instance = qrobot.read("orders.json")        # doctest: +SKIP
>>> result = qrobot.solve(instance, deadline=5)  # doctest: +SKIP
>>> print(result.summary())                      # doctest: +SKIP
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from qrobot._version import __version__
from qrobot.errors import (
    BackendError,
    CredentialsError,
    InfeasibleError,
    InputError,
    MissingExtraError,
    QRobotError,
    RemoteError,
)

if TYPE_CHECKING:
    from qrobot.plan import CheckReport, Plan, Trip, check
    from qrobot.planning import Result, solve
    from qrobot.problem import Instance, Item, Order, Robot
    from qrobot.problem.formats import read, write
    from qrobot.report import plot

__all__ = [
    "BackendError",
    "CheckReport",
    "CredentialsError",
    "InfeasibleError",
    "InputError",
    "Instance",
    "Item",
    "MissingExtraError",
    "Order",
    "Plan",
    "QRobotError",
    "RemoteError",
    "Result",
    "Robot",
    "Trip",
    "__version__",
    "check",
    "plot",
    "read",
    "solve",
    "write",
]

# Loaded on first use: `qrobot --help` and `import qrobot` must stay light on a Pi.
_LAZY = {
    "CheckReport": "qrobot.plan",
    "Instance": "qrobot.problem",
    "Item": "qrobot.problem",
    "Order": "qrobot.problem",
    "Plan": "qrobot.plan",
    "Result": "qrobot.planning",
    "Robot": "qrobot.problem",
    "Trip": "qrobot.plan",
    "check": "qrobot.plan",
    "plot": "qrobot.report",
    "read": "qrobot.problem.formats",
    "solve": "qrobot.planning",
    "write": "qrobot.problem.formats",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'qrobot' has no attribute {name!r}")
    value = getattr(importlib.import_module(_LAZY[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
