"""What a remote job is expected to cost, and the refusal of what costs too much.

Prices change and contracts differ: every estimate says what it was reckoned with, and a
variable of the environment replaces each price that is written here. Prices that a service
tells by itself (Braket's device properties) are preferred to ours.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

from qrobot.errors import BackendError, InputError
from qrobot.jobs.job import Estimate

__all__ = [
    "FREE",
    "by_shots",
    "by_time",
    "check_budget",
    "device_price",
    "price",
    "price_source",
    "together",
]

FREE = Estimate(0.0, None, "local: it runs on this machine")
"""Of what nobody bills."""


PRICES: dict[str, tuple[str, float, str]] = {
    # name: (variable that replaces it, US dollars, of what)
    "dwave-hour": ("QROBOT_USD_PER_DWAVE_HOUR", 2000.0, "hour of QPU access"),
    "ibm-second": ("QROBOT_USD_PER_IBM_SECOND", 1.60, "second of QPU time"),
    "braket-task": ("QROBOT_USD_PER_BRAKET_TASK", 0.30, "task on a QPU"),
    # Of a device that does not tell its own: the dearest that we know of.
    "braket-shot": ("QROBOT_USD_PER_BRAKET_SHOT", 0.08, "shot on a QPU"),
    "braket-minute": ("QROBOT_USD_PER_BRAKET_MINUTE", 0.075, "minute of a managed simulator"),
}
"""Published on-demand prices, rounded; yours may differ."""


def price(name: str) -> float:
    """Return a price of `PRICES`, or what its variable says.

    Raises
    ------
    InputError
        When the variable holds no amount of money.
    """
    variable, usd, _ = PRICES[name]
    text = os.environ.get(variable)
    if not text:
        return usd
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise InputError(
            f"the variable {variable} holds no amount of money", advice="give US dollars, as in 1.5"
        )
    return value


def price_source(name: str) -> str:
    """Return where a price of `PRICES` comes from: nobody asks the service for these."""
    variable = PRICES[name][0]
    return f"as {variable} says" if os.environ.get(variable) else "assumed, not looked up"


def by_time(seconds: float, usd_per_second: float, what: str, note: str = "") -> Estimate:
    """Return the estimate of a device that bills by time; `note` says what was assumed."""
    basis = f"{seconds:.3g} s of {what} at {usd_per_second:.4g} USD/s"
    return Estimate(seconds * usd_per_second, seconds, f"{basis}; {note}" if note else basis)


def by_shots(
    shots: int, usd_per_shot: float, usd_per_task: float, tasks: int = 1, note: str = ""
) -> Estimate:
    """Return the estimate of a device that bills by task and shot.

    Parameters
    ----------
    shots
        Of all tasks together.
    note
        What was assumed, in words.
    """
    basis = f"{tasks} task(s) at {usd_per_task:g} USD + {shots} shots at {usd_per_shot:g} USD"
    usd = tasks * usd_per_task + shots * usd_per_shot
    return Estimate(usd, None, f"{basis}; {note}" if note else basis)


def together(parts: Mapping[str, Estimate]) -> Estimate:
    """Return the estimate of several kinds of jobs, by name: unknown when one of them is."""
    seconds = [one.seconds for one in parts.values() if one.seconds is not None]
    known = [one.usd for one in parts.values() if one.usd is not None]
    return Estimate(
        sum(known) if len(known) == len(parts) else None,
        sum(seconds) if seconds else None,
        " + ".join(f"{name}: {one.basis}" for name, one in parts.items()),
    )


def device_price(properties: Any) -> tuple[float, str] | None:
    """Return price and unit in ``AwsDevice.properties``, such as ``(0.0009, "shot")``."""
    cost = getattr(getattr(properties, "service", None), "deviceCost", None)
    usd, unit = getattr(cost, "price", None), getattr(cost, "unit", None)
    return (float(usd), str(unit)) if isinstance(usd, int | float) and unit else None


def check_budget(estimate: Estimate, max_cost: float | None) -> None:
    """Refuse a job that would, or might, cost more than allowed.

    Raises
    ------
    InputError
        When `max_cost` is not an amount.
    BackendError
        When the estimate is above `max_cost`, or unknown while there is a limit.
    """
    if max_cost is None:
        return
    if not max_cost >= 0:
        raise InputError(
            f"{max_cost:g} is not an amount of money",
            field="max_cost",
            advice="give 0 or more dollars",
        )
    if estimate.usd is None:
        raise BackendError(
            f"the cost cannot be estimated ({estimate.basis or 'no price is known'}), so the limit"
            f" of {max_cost:g} USD cannot be kept; nothing was submitted"
        )
    if estimate.usd > max_cost:
        raise BackendError(
            f"the job would cost about {estimate}, more than the limit of {max_cost:g} USD;"
            " nothing was submitted"
        )
