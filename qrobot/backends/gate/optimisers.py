"""Optimisers by name, each within a budget of evaluations and with one history.

Our own are in `algorithms`; scipy, imported when asked for, has more. ``none`` looks at the first
parameters only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from types import TracebackType

import numpy as np

from qrobot._arrays import Floats
from qrobot._extras import load
from qrobot.backends.gate.algorithms import Slope, Turns, Value, adam, nft, spsa
from qrobot.errors import BackendError, InputError

__all__ = ["GRADIENT", "OPTIMISERS", "Evaluations", "Found", "minimise"]


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


class _SpentError(Exception):
    """The budget is used up, or somebody asked to stop."""


class Evaluations:
    """An objective within a budget; `found` keeps the best and the history.

    An optimiser runs in a ``with`` block, which an evaluation ends when the budget is spent or
    somebody asks to stop::

        with Evaluations(value, start, budget=60) as runs:
            nelder_mead(runs.value, start, steps)

    Parameters
    ----------
    value
        The objective.
    start
        First parameters, shape (m,): what `found` has until something is evaluated.
    budget
        Most evaluations.
    slope
        The objective and its gradient.
    turns
        The objective as ``nft`` needs it.
    interrupted
        Asked before each evaluation.
    """

    def __init__(
        self,
        value: Value,
        start: Floats,
        *,
        budget: int,
        slope: Slope | None = None,
        turns: Turns | None = None,
        interrupted: Callable[[], bool] | None = None,
    ) -> None:
        self._value, self._slope, self.turns = value, slope, turns
        self.found, self.budget, self._interrupted = Found(start.copy()), budget, interrupted
        self._ended = False

    def __enter__(self) -> Evaluations:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None
    ) -> bool:
        return kind is _SpentError

    def value(self, point: Floats) -> float:
        """Return the objective."""
        self._ready()
        reached = self._value(np.asarray(point, dtype=np.float64))
        self._note(point, reached)
        return reached

    def slope(self, point: Floats) -> tuple[float, Floats]:
        """Return the objective and its gradient."""
        assert self._slope is not None
        self._ready()
        reached, way = self._slope(np.asarray(point, dtype=np.float64))
        self._note(point, reached)
        return reached, way

    def distribution(self, point: Floats) -> Floats:
        """Return the distribution that the objective is taken over."""
        assert self.turns is not None
        self._ready()
        reached = self.turns.distribution(point)
        self._note(point, self.turns.of(reached))
        return reached

    def _ready(self) -> None:
        if self._interrupted is not None and self._interrupted():
            self._ended = True
        if self._ended or len(self.found.history) >= self.budget:
            raise _SpentError

    def _note(self, point: Floats, reached: float) -> None:
        if not np.isfinite(reached):
            raise BackendError("the objective is not a finite number")
        self.found.history.append(float(reached))
        self.found.offer(point, reached)


def minimise(name: str, runs: Evaluations, rng: np.random.Generator) -> Found:
    """Minimise from the start of `runs`.

    Parameters
    ----------
    name
        One of `OPTIMISERS`; those in `GRADIENT` use the gradient, ``nft`` the turns.
    runs
        The objective.
    rng
        Of SPSA's directions and NFT's sequence.

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
    if name == "nft" and runs.turns is None:
        raise InputError(
            "nft needs exact probabilities and an angle of its own for each parameter",
            field="optimizer",
            advice="use spsa, or the ansatz hardware without shots",
        )
    start = runs.found.parameters
    with runs:
        OPTIMISERS[name if start.size else "none"](runs, start, rng)
    return runs.found


def _nft(runs: Evaluations, start: Floats, rng: np.random.Generator) -> None:
    assert runs.turns is not None
    nft(runs.turns, start, runs.distribution, runs.found.offer, rng)


def _scipy(
    method: str, gradient: bool, runs: Evaluations, start: Floats, _: np.random.Generator
) -> None:
    minimize = load("scipy.optimize", f"optimizer {method.lower()}").minimize
    options: dict[str, float] = {"maxiter": max(runs.budget, 1)}
    if method == "COBYLA":
        options = {"rhobeg": 0.4, "maxiter": max(runs.budget, start.size + 2)}
    function = runs.slope if gradient else runs.value
    minimize(function, start, jac=gradient, method=method, options=options)


OPTIMISERS: dict[str, Callable[[Evaluations, Floats, np.random.Generator], object]] = {
    "none": lambda runs, start, _: runs.value(start),
    "nft": _nft,
    "spsa": lambda runs, start, rng: spsa(runs.value, start, rng, runs.budget),
    "adam": lambda runs, start, _: adam(runs.slope, start),
    "cobyla": partial(_scipy, "COBYLA", False),
    "nelder-mead": partial(_scipy, "Nelder-Mead", False),
    "powell": partial(_scipy, "Powell", False),
    "l-bfgs-b": partial(_scipy, "L-BFGS-B", True),
    "bfgs": partial(_scipy, "BFGS", True),
    "slsqp": partial(_scipy, "SLSQP", True),
}

GRADIENT = frozenset({"l-bfgs-b", "bfgs", "slsqp", "adam"})
