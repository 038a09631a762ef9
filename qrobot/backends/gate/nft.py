"""One parameter at a time, each to its very best: Nakanishi, Fujii and Todo.

As one angle of a rotation exp(-i angle P / 2) turns, every probability goes along
a + b cos + c sin (K. M. Nakanishi, K. Fujii and S. Todo, Physical Review Research 2 (2020)
043158), so three distributions tell all others, and the objective along the whole turn, CVaR
too, is known without another run. Two new runs a parameter: the third is the point itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from qrobot._arrays import Floats

__all__ = ["SWEEPS", "Turns", "nft"]


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
