"""What `solve` and its parts take: each argument and option checked before any work."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from qrobot._parameters import Parameter, near
from qrobot.backends import Planner, Stop
from qrobot.backends.sampler import PickingSampler, check_parameters
from qrobot.errors import InputError

__all__ = ["ARGUMENTS", "MODEL_OPTIONS", "check_arguments", "check_options"]

ARGUMENTS: Mapping[str, Parameter] = {
    "backend": Parameter("text", optional=False),
    "deadline": Parameter("number", 0, above=True),
    "max_work": Parameter("whole", 1),
    "seed": Parameter("whole", 0, optional=False),
    "control": Parameter("flag", optional=False),
    "max_cost": Parameter("number", 0),
    "fallback": Parameter("text"),
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


def check_options(
    backend: str, chosen: Planner | PickingSampler | None, options: Mapping[str, Any]
) -> None:
    """Refuse options that a backend does not take, or not like this.

    Parameters
    ----------
    backend
        Its name.
    chosen
        The backend; ``None`` for ``auto``.
    options
        Those of the model, ``rounds``, and the sampler's own.

    Raises
    ------
    InputError
        With the name that was meant, or what is allowed.
    """
    if chosen is None or isinstance(chosen, Planner):
        if options:
            unknown = sorted(options)
            raise InputError(
                f"backend {backend} takes no option {', '.join(unknown)}",
                field=unknown[0],
                mend=near(unknown[0], ARGUMENTS)
                or "leave it out, or choose a sampler such as neal",
            )
        return
    ROUNDS.check("rounds", options.get("rounds"))
    own = {k: v for k, v in options.items() if k not in (*MODEL_OPTIONS, "rounds")}
    check_parameters(chosen, own, also=(*ARGUMENTS, *MODEL_OPTIONS, "rounds"))
