"""What `solve` and its parts take: each argument and option checked before any work."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from qrobot._parameters import Parameter
from qrobot.backends import Stop

__all__ = ["ARGUMENTS", "MODEL_OPTIONS", "ROUNDS", "check_arguments"]

ARGUMENTS: Mapping[str, Parameter] = {
    "backend": Parameter("text", optional=False),
    "deadline": Parameter("number", 0, above=True),
    "max_work": Parameter("whole", 1),
    "seed": Parameter("whole", 0, optional=False),
    "control": Parameter("flag", optional=False),
    "max_cost": Parameter("number", 0),
    "fallback": Parameter("text"),
    "objective": Parameter("text", optional=False),
    "stop": Parameter("object", also=(Stop,)),
    "on_progress": Parameter("function"),
}
"""What each argument of `solve` takes."""

MODEL_OPTIONS = ("encoding", "slack", "penalties")
"""Options of the model, which `qrobot.models.build_model` checks."""

ROUNDS = Parameter("whole", 1)


def check_arguments(**given: Any) -> None:
    """Refuse an argument of the wrong type or out of range.

    Raises
    ------
    InputError
        Names the argument, its value and what is allowed.
    """
    for name, value in given.items():
        ARGUMENTS[name].check(name, value)
