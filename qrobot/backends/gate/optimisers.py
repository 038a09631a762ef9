"""Optimisers by name, each within a budget of evaluations and with one history.

Own: ``nft`` (one parameter at a time, see `nft`), ``spsa`` (J. C. Spall, IEEE Transactions on
Automatic Control 37 (1992) 332) and ``adam`` (D. P. Kingma and J. Ba, arXiv:1412.6980).
Scipy's, imported when asked for: the rest. ``none`` looks at the first parameters only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from qrobot._arrays import Floats
from qrobot._extras import load
from qrobot.backends.gate.nft import Turns, nft
from qrobot.errors import BackendError, InputError

__all__ = ["GRADIENT", "OPTIMISERS", "Found", "minimise"]

Value = Callable[[Floats], float]
Slope = Callable[[Floats], tuple[float, Floats]]

SCIPY = {
    "cobyla": "COBYLA",
    "nelder-mead": "Nelder-Mead",
    "powell": "Powell",
    "l-bfgs-b": "L-BFGS-B",
    "bfgs": "BFGS",
    "slsqp": "SLSQP",
}
GRADIENT = frozenset({"l-bfgs-b", "bfgs", "slsqp", "adam"})
OPTIMISERS = ("none", "nft", "spsa", "adam", *SCIPY)


FLAT = 3
"""Directions without any difference after which SPSA has arrived."""


class _SpentError(Exception):
    """The budget is used up, or somebody asked to stop."""


@dataclass(slots=True)
class Found:
    """The best parameters of a search.

    Parameters
    ----------
    parameters, value
        Where, and the objective there.
    history
        The objective of each evaluation, in sequence; one with gradient counts once.
    searches
        How many evaluations each start took.
    """

    parameters: Floats
    value: float = np.inf
    history: list[float] = field(default_factory=list)
    searches: list[int] = field(default_factory=list)

    def join(self, later: Found) -> None:
        """Take over a later start's history, and its parameters where they are better."""
        self.history += later.history
        self.searches.append(len(later.history))
        if later.value < self.value:
            self.parameters, self.value = later.parameters, later.value


def minimise(
    name: str,
    value: Value,
    slope: Slope,
    start: Floats,
    *,
    budget: int,
    rng: np.random.Generator,
    turns: Turns | None = None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Found:
    """Minimise from `start`.

    Parameters
    ----------
    name
        One of `OPTIMISERS`.
    value
        The objective.
    slope
        The objective and its gradient, used by the optimisers in `GRADIENT`.
    start
        First parameters, shape (m,).
    budget
        Most evaluations; 0 evaluates nothing.
    rng
        Of SPSA's directions and NFT's sequence.
    turns
        The objective as ``nft`` needs it, where it can be had.
    interrupted
        Asked before each evaluation.

    Raises
    ------
    InputError
        When the optimiser is unknown, or ``nft`` cannot work on this objective.
    BackendError
        When the objective is not finite.
    """
    if name not in OPTIMISERS:
        raise InputError(
            f"{name!r} is not an optimizer",
            field="optimizer",
            mend=f"use one of {', '.join(OPTIMISERS)}",
        )
    if name == "nft" and turns is None:
        raise InputError(
            "nft needs exact probabilities and an angle of its own for each parameter",
            field="optimizer",
            mend="use spsa, or the ansatz hardware without shots",
        )
    counted = _Counted(value, slope, turns, start, budget, interrupted)
    try:
        if name == "none" or start.size == 0:
            counted.value(start)
        elif name == "nft" and turns is not None:
            nft(turns, start, counted.distribution, counted.keep, rng)
        elif name == "spsa":
            _spsa(counted.value, start, budget, rng)
        elif name == "adam":
            _adam(counted.slope, start, budget)
        else:
            _scipy(name, counted.value, counted.slope, start, budget)
    except _SpentError:
        pass
    return counted.found


class _Counted:
    """An objective within a budget: each evaluation is noted, the best is kept."""

    def __init__(
        self,
        value: Value,
        slope: Slope,
        turns: Turns | None,
        start: Floats,
        budget: int,
        interrupted: Callable[[], bool],
    ) -> None:
        self._value, self._slope, self._turns = value, slope, turns
        self._budget, self._interrupted = budget, interrupted
        self.found = Found(start.copy())

    def value(self, point: Floats) -> float:
        self._check_budget()
        reached = self._value(np.asarray(point, dtype=np.float64))
        self._note(point, reached)
        return reached

    def slope(self, point: Floats) -> tuple[float, Floats]:
        self._check_budget()
        reached, way = self._slope(np.asarray(point, dtype=np.float64))
        self._note(point, reached)
        return reached, way

    def distribution(self, point: Floats) -> Floats:
        assert self._turns is not None
        self._check_budget()
        reached = self._turns.distribution(point)
        self._note(point, self._turns.of(reached))
        return reached

    def keep(self, point: Floats, reached: float) -> None:
        if reached < self.found.value:
            self.found.parameters, self.found.value = point.copy(), float(reached)

    def _check_budget(self) -> None:
        if len(self.found.history) >= self._budget or self._interrupted():
            raise _SpentError

    def _note(self, point: Floats, reached: float) -> None:
        if not np.isfinite(reached):
            raise BackendError("the objective is not a finite number")
        self.found.history.append(float(reached))
        self.keep(point, reached)


def _spsa(
    value: Value, start: Floats, budget: int, rng: np.random.Generator, step: float = 0.3
) -> None:
    """Spall's gains; steps are in units of the differences seen, so energies need no scale."""
    point, stable = start.copy(), budget / 20
    scale, flat = 0.0, 0
    value(start)
    for k in range(budget // 2 + 1):
        width = 0.15 / (k + 1) ** 0.101
        way = rng.choice(np.array([-1.0, 1.0]), start.size)
        rise = (value(point + width * way) - value(point - width * way)) / (2 * width)
        flat = 0 if abs(rise) > 1e-9 * scale else flat + 1
        if flat == FLAT:
            return
        scale = 0.9 * scale + 0.1 * abs(rise) if scale else abs(rise)
        gain = step * ((stable + 1) / (k + 1 + stable)) ** 0.602
        point = point - gain * rise / max(scale, 1e-12) * way


def _adam(slope: Slope, start: Floats, budget: int, step: float = 0.1) -> None:
    steepest = 0.0
    point, mean, square = start.copy(), np.zeros(start.size), np.zeros(start.size)
    for k in range(1, budget + 2):
        _, way = slope(point)
        steepest = max(steepest, float(np.abs(way).max()))
        if float(np.abs(way).max()) <= 1e-9 * steepest or steepest < 1e-12:
            return
        mean = 0.9 * mean + 0.1 * way
        square = 0.99 * square + 0.01 * way**2
        root = np.sqrt(square / (1 - 0.99**k))
        point = point - step * (mean / (1 - 0.9**k)) / (root + 1e-12)


def _scipy(name: str, value: Value, slope: Slope, start: Floats, budget: int) -> None:
    minimize = load("scipy.optimize", f"optimizer {name}").minimize
    method = SCIPY[name]
    options: dict[str, float] = {"maxiter": max(budget, 1)}
    if name == "cobyla":
        options["rhobeg"] = 0.4
        options["maxiter"] = max(budget, start.size + 2)
    if name in GRADIENT:
        minimize(slope, start, jac=True, method=method, options=options)
    else:
        minimize(value, start, method=method, options=options)
