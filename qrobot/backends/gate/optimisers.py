"""Optimisers by name, each within a budget of evaluations and with one history.

Own: ``nft`` (below), ``spsa`` (J. C. Spall, IEEE Transactions on Automatic Control 37 (1992)
332) and ``adam`` (D. P. Kingma and J. Ba, arXiv:1412.6980). Scipy, imported when asked for: the
rest. ``none`` looks at the first parameters only.

``nft`` takes one parameter at a time to its very best. As one angle of a rotation
exp(-i angle P / 2) turns, every probability goes along a + b cos + c sin (K. M. Nakanishi,
K. Fujii and S. Todo, Physical Review Research 2 (2020) 043158), so three distributions tell all
others, and the objective along the whole turn, CVaR too, is known without another run. Two new
runs a parameter: the third is the point itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from qrobot._arrays import Floats
from qrobot._extras import load
from qrobot.errors import BackendError, InputError

__all__ = ["GRADIENT", "OPTIMISERS", "SWEEPS", "Found", "Turns", "minimise", "nft"]


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

    def offer(self, point: Floats, value: float) -> None:
        """Keep a point that is better."""
        if value < self.value:
            self.parameters, self.value = point.copy(), float(value)

    def join(self, later: Found) -> None:
        """Take over a later start's history, and its parameters where they are better."""
        self.history += later.history
        self.searches.append(len(later.history))
        self.offer(later.parameters, later.value)


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
            advice=f"use one of {', '.join(OPTIMISERS)}",
        )
    if name == "nft" and turns is None:
        raise InputError(
            "nft needs exact probabilities and an angle of its own for each parameter",
            field="optimizer",
            advice="use spsa, or the ansatz hardware without shots",
        )
    counter = _Counter(value, slope, turns, Found(start.copy()), budget, interrupted)
    try:
        if name == "none" or start.size == 0:
            counter.value(start)
        elif name == "nft" and turns is not None:
            nft(turns, start, counter.distribution, counter.found.offer, rng)
        elif name == "spsa":
            _spsa(counter.value, start, budget, rng)
        elif name == "adam":
            _adam(counter.slope, start, budget)
        else:
            _scipy(name, counter.value, counter.slope, start, budget)
    except _SpentError:
        pass
    return counter.found


class _Counter:
    """Evaluates an objective within a budget, and keeps the best and the history."""

    def __init__(
        self,
        value: Value,
        slope: Slope,
        turns: Turns | None,
        found: Found,
        budget: int,
        interrupted: Callable[[], bool],
    ) -> None:
        self._value, self._slope, self._turns = value, slope, turns
        self.found, self.budget, self.interrupted = found, budget, interrupted

    def value(self, point: Floats) -> float:
        """Return the objective."""
        self._ready()
        reached = self._value(np.asarray(point, dtype=np.float64))
        self._note(point, reached)
        return reached

    def slope(self, point: Floats) -> tuple[float, Floats]:
        """Return the objective and its gradient."""
        self._ready()
        reached, way = self._slope(np.asarray(point, dtype=np.float64))
        self._note(point, reached)
        return reached, way

    def distribution(self, point: Floats) -> Floats:
        """Return the distribution that the objective is taken over."""
        assert self._turns is not None
        self._ready()
        reached = self._turns.distribution(point)
        self._note(point, self._turns.of(reached))
        return reached

    def _ready(self) -> None:
        if len(self.found.history) >= self.budget or self.interrupted():
            raise _SpentError

    def _note(self, point: Floats, reached: float) -> None:
        if not np.isfinite(reached):
            raise BackendError("the objective is not a finite number")
        self.found.history.append(float(reached))
        self.found.offer(point, reached)


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


SWEEPS = 4
"""Most passes over all parameters; most searches end after two or three."""

GRID, FINER = 16, (9, 9)
"""Angles that are looked at on a full turn, then around the best."""

SETTLED = 1e-4
"""A pass that lowers the objective by less than this share of its fall ends the search."""


class Turns(Protocol):
    """An objective over exact distributions, each parameter of which turns one rotation."""

    scales: Floats
    """Angle by parameter, shape (size,)."""

    def distribution(self, parameters: Floats) -> Floats:
        """Return the probabilities of all assignments, in any fixed sequence."""
        ...

    def of(self, distribution: Floats) -> float:
        """Return the objective of a distribution."""
        ...


def nft(
    turns: Turns,
    start: Floats,
    run: Callable[[Floats], Floats],
    reach: Callable[[Floats, float], None],
    rng: np.random.Generator,
    sweeps: int = SWEEPS,
) -> None:
    """Minimise by full turns of one parameter after another.

    Parameters
    ----------
    turns
        The objective.
    start
        First parameters, shape (size,).
    run
        Runs the circuit once, keeps the count and the history, and returns the distribution;
        raises to end the search.
    reach
        Told of parameters and the objective that they are known to have, without a run.
    rng
        Of the sequence of the parameters.
    sweeps
        Most passes.
    """
    point = start.copy()
    first = last = np.inf
    for _ in range(sweeps):
        here = run(point)  # anew each pass: interpolation adds up its rounding
        value = turns.of(here)
        first = value if np.isinf(first) else first
        if last - value <= SETTLED * (first - value):
            return
        last = value
        for k in rng.permutation(point.size):
            ahead, behind = point.copy(), point.copy()
            ahead[k] += np.pi / 2 / turns.scales[k]
            behind[k] -= np.pi / 2 / turns.scales[k]
            plus, minus = run(ahead), run(behind)
            middle = (plus + minus) / 2
            cosine, sine = here - middle, (plus - minus) / 2

            def at(
                angle: float, a: Floats = middle, b: Floats = cosine, c: Floats = sine
            ) -> Floats:
                found: Floats = np.maximum(a + np.cos(angle) * b + np.sin(angle) * c, 0.0)
                return found

            angle, reached = _lowest(lambda turn, at=at: turns.of(at(turn)))  # type: ignore[misc]
            if reached < value:
                point[k] += angle / turns.scales[k]
                here, value = at(angle), reached
                reach(point, value)


def _lowest(value: Callable[[float], float]) -> tuple[float, float]:
    """Return the angle of least value on a full turn, and that value."""
    angles = np.linspace(-np.pi, np.pi, GRID, endpoint=False)
    width = 2 * np.pi / GRID
    for points in (*FINER, 0):
        found = [value(float(angle)) for angle in angles]
        best = int(np.argmin(found))
        angle, least = float(angles[best]), found[best]
        if points:
            angles = angle + np.linspace(-width, width, points)
            width = 2 * width / (points - 1)
    return angle, least
