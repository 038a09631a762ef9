"""The search for angles, the same for every ansatz.

One layer: a guess (closed form, or a coarse grid) and a local search. Several layers: the two
slopes of a linear ramp (gamma rises, beta falls, as in a slow change from mixer to cost;
S. H. Sack and M. Serbyn, Quantum 5 (2021) 491), then all angles by gradients. Gammas are
searched in units of one over the spread of the cost, so that one range suits every model.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.algorithms import bfgs, nelder_mead
from qrobot.backends.gate.ansatz import ramp
from qrobot.backends.gate.optimisers import Evaluations
from qrobot.errors import InputError

__all__ = ["SHARPER", "Layered", "Tuning", "sharpen", "tune"]


SHARPER = (1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
"""Shares of the distribution, one after the other, in `sharpen`."""


class Layered(Protocol):
    """A circuit of layers with two angles each, and what to minimise over them."""

    spread: float
    """Standard deviation of the cost in the uniform state: the unit of 1 / gamma."""

    beta_range: tuple[float, float]
    """Betas worth trying."""

    alpha: float
    """Share of the distribution whose mean is the objective."""

    @property
    def lowest(self) -> float:
        """The least cost of any state."""
        ...

    def guess(self) -> tuple[float, float] | None:
        """Return gamma and beta of one good layer where they are known cheaply."""
        ...

    def value(self, gammas: Floats, betas: Floats) -> float:
        """Return the objective."""
        ...

    def gradient(self, gammas: Floats, betas: Floats) -> tuple[float, Floats, Floats]:
        """Return the objective and its derivatives by gammas and by betas."""
        ...


@dataclass(frozen=True, slots=True)
class Tuning:
    """Angles and how they were found.

    Parameters
    ----------
    gammas, betas
        One of each a layer.
    value
        The objective there.
    evaluations
        Runs of the circuit; one with gradient counts once and costs about four.
    seconds
        Wall-clock time of the search.
    history
        Best value after each evaluation.
    """

    gammas: tuple[float, ...]
    betas: tuple[float, ...]
    value: float
    evaluations: int
    seconds: float
    history: tuple[float, ...] = field(repr=False, default=())


def tune(
    ansatz: Layered,
    layers: int = 1,
    *,
    evaluations: int = 60,
    start: tuple[Sequence[float], Sequence[float]] | None = None,
    gradients: bool = True,
    stop: Callable[[], bool] | None = None,
) -> Tuning:
    """Search for good angles.

    Parameters
    ----------
    ansatz
        What to tune.
    layers
        Number of layers p.
    evaluations
        Most runs of the circuit. 0 returns the start or the guess unchecked.
    start
        Gammas and betas to begin with, from a smaller model or an earlier run: no grid.
    gradients
        Whether several layers are finished by gradients (about four runs each).
    stop
        Asked before every run; the best so far is returned when it says True.

    Raises
    ------
    InputError
        When there are no layers or the start has another number of angles.
    """
    if layers < 1:
        raise InputError(f"{layers} layers are too few", field="layers", advice="use 1 or more")
    if start is not None and not len(start[0]) == len(start[1]) == layers:
        raise InputError(
            f"{len(start[0])} gammas and {len(start[1])} betas do not make {layers} layers",
            field="gammas",
            advice="give one of each a layer",
        )
    began = time.perf_counter()
    unit = 1.0 / ansatz.spread if ansatz.spread > 0 else 1.0
    scale = np.concatenate([np.full(layers, unit), np.ones(layers)])

    def value(point: Floats) -> float:
        angles = point * scale
        return ansatz.value(angles[:layers], angles[layers:])

    def slope(point: Floats) -> tuple[float, Floats]:
        angles = point * scale
        reached, *by_angle = ansatz.gradient(angles[:layers], angles[layers:])
        return reached, np.concatenate(by_angle) * scale

    known = ansatz.guess() if start is None else None
    if start is not None:
        point = np.concatenate([np.asarray(one, dtype=np.float64) for one in start]) / scale
    else:
        # Without anything better: a short ramp that is sure to lower the cost a little.
        gamma, beta = known or (0.5 * unit, -0.3)
        angles = ramp(layers, 2 * gamma, 2 * beta) if layers > 1 else ([gamma], [beta])
        point = np.concatenate(angles) / scale
    with Evaluations(value, point, budget=evaluations, slope=slope, interrupted=stop) as runs:
        if start is None and not (known is not None and layers == 1):
            point = _first(ansatz, layers, known, runs)
        if layers > 1 and gradients:
            bfgs(runs.slope, point)
        else:
            steps = np.concatenate([np.full(layers, 0.2), np.full(layers, 0.08)])
            nelder_mead(runs.value, point, steps, tolerance=1e-2)
    found = runs.found
    angles = (found.parameters * scale).tolist()
    return Tuning(
        gammas=tuple(angles[:layers]),
        betas=tuple(angles[layers:]),
        value=found.value if found.history else float("nan"),
        evaluations=len(found.history),
        seconds=time.perf_counter() - began,
        history=tuple(np.minimum.accumulate(found.history).tolist()),
    )


def _first(
    ansatz: Layered, layers: int, known: tuple[float, float] | None, runs: Evaluations
) -> Floats:
    """Return a first point, in units: the best of a grid, or of ramps around a guess."""
    low, high = ansatz.beta_range

    def at(slopes: Floats) -> float:
        gammas, betas = ramp(layers, *slopes) if layers > 1 else (slopes[:1], slopes[1:])
        return runs.value(np.concatenate([gammas, betas]))

    if known is not None:
        tried = [(2 * known[0] * ansatz.spread * f, 2 * known[1]) for f in (1.0, 0.5)]
    else:
        tried = [(g, b) for g in (0.5, 1.0, 1.7, 2.5) for b in np.linspace(low, high, 8)[1:-1]]
    points = np.array(tried[: max(1, runs.budget // 2)])
    values = [at(point) for point in points]
    left = min(16, runs.budget // 4, runs.budget - len(points))
    if layers > 1:
        with Evaluations(at, points[0], budget=left) as ramps:
            nelder_mead(ramps.value, points[int(np.argmin(values))], np.array([0.4, 0.2]))
    return runs.found.parameters.copy()


def sharpen(
    ansatz: Layered,
    layers: int,
    *,
    evaluations: int = 60,
    alphas: Sequence[float] = SHARPER,
    start: tuple[Sequence[float], Sequence[float]] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Tuning:
    """Search with ever smaller shares of the distribution, each from the angles before.

    The mean leads to a good region, the tail to the optimum: with the Grover mixer this comes
    near the bound of (2 p + 1)^2 where the mean alone stays far below. On hardware a share
    alpha needs many times 1 / alpha shots a run; here the distribution is exact.

    Parameters
    ----------
    ansatz
        What to tune; its `alpha` is changed and put back.
    layers
        Number of layers p.
    evaluations
        Most runs of the circuit for each share.
    alphas
        Shares, falling.
    start
        Gammas and betas to begin with.
    stop
        As in `tune`.
    """
    before, began = ansatz.alpha, time.perf_counter()
    best: Tuning | None = None
    count, history = 0, []
    for alpha in alphas:
        ansatz.alpha = alpha
        found = tune(ansatz, layers, evaluations=evaluations, start=start, stop=stop)
        count += found.evaluations
        history += list(found.history)
        start = (found.gammas, found.betas)
        # The optimum alone fills the share: the objective is flat and says nothing more.
        flat = found.value - ansatz.lowest <= 1e-9 * ansatz.spread
        if best is None or not (flat or found.evaluations == 0):
            best = found
        if flat or (stop is not None and stop()):
            break
    ansatz.alpha = before
    assert best is not None
    return replace(
        best, evaluations=count, seconds=time.perf_counter() - began, history=tuple(history)
    )
