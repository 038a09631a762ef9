"""Algorithms of optimisers: each calls the objective until it has arrived, or a call raises.

What is counted and kept, and what ends a search early, is in `optimisers`. `nelder_mead` and `bfgs`
search the few angles of `tune`, the same on every machine: scipy is not part of the base
installation.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Protocol

import numpy as np

from qrobot._arrays import Floats

__all__ = ["SWEEPS", "Slope", "Turns", "Value", "adam", "bfgs", "nelder_mead", "nft", "spsa"]


Value = Callable[[Floats], float]
Slope = Callable[[Floats], tuple[float, Floats]]

FLAT = 3
"""Directions without any difference after which SPSA has arrived."""


def spsa(
    value: Value, start: Floats, rng: np.random.Generator, budget: int, step: float = 0.3
) -> None:
    """Minimise by differences along random directions until none tells a difference.

    Gains are those of J. C. Spall, IEEE Transactions on Automatic Control 37 (1992) 332; steps are
    in units of the differences seen, so energies need no scale.
    """
    point, stable = start.copy(), budget / 20
    scale, flat = 0.0, 0
    value(start)
    for k in count():
        width = 0.15 / (k + 1) ** 0.101
        way = rng.choice(np.array([-1.0, 1.0]), start.size)
        rise = (value(point + width * way) - value(point - width * way)) / (2 * width)
        flat = 0 if abs(rise) > 1e-9 * scale else flat + 1
        if flat == FLAT:
            return
        scale = 0.9 * scale + 0.1 * abs(rise) if scale else abs(rise)
        gain = step * ((stable + 1) / (k + 1 + stable)) ** 0.602
        point = point - gain * rise / max(scale, 1e-12) * way


def adam(slope: Slope, start: Floats, step: float = 0.1) -> None:
    """Minimise by gradients and their moments (D. P. Kingma and J. Ba, arXiv:1412.6980)."""
    steepest = 0.0
    point, mean, square = start.copy(), np.zeros(start.size), np.zeros(start.size)
    for k in count(1):
        _, way = slope(point)
        steepest = max(steepest, float(np.abs(way).max()))
        if float(np.abs(way).max()) <= 1e-9 * steepest or steepest < 1e-12:
            return
        mean = 0.9 * mean + 0.1 * way
        square = 0.99 * square + 0.01 * way**2
        root = np.sqrt(square / (1 - 0.99**k))
        point = point - step * (mean / (1 - 0.9**k)) / (root + 1e-12)


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


SWEEPS = 4
"""Most passes of NFT over all parameters; most searches end after two or three."""

GRID, FINER = 16, (9, 9)
"""Angles that are looked at on a full turn, then around the best."""

SETTLED = 1e-4
"""A pass that lowers the objective by less than this share of its fall ends the search."""


def nft(
    turns: Turns,
    start: Floats,
    run: Callable[[Floats], Floats],
    reach: Callable[[Floats, float], None],
    rng: np.random.Generator,
) -> None:
    """Take one parameter at a time to its very best.

    As one angle of a rotation exp(-i angle P / 2) turns, every probability goes along
    a + b cos + c sin (K. M. Nakanishi, K. Fujii and S. Todo, Physical Review Research 2 (2020)
    043158), so three distributions tell all others, and the objective along the whole turn,
    CVaR too, is known without another run. Two new runs a parameter: the third is the point
    itself.

    Parameters
    ----------
    turns, start
        The objective, and first parameters, shape (size,).
    run
        Runs the circuit once and returns the distribution.
    reach
        Told of parameters and the objective that they are known to have, without a run.
    rng
        Of the sequence of the parameters.
    """
    point = start.copy()
    first = last = np.inf
    for _ in range(SWEEPS):
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


def nelder_mead(value: Value, start: Floats, steps: Floats, tolerance: float = 1e-4) -> None:
    """Minimise by a simplex (J. A. Nelder and R. Mead, The Computer Journal 7 (1965) 308).

    Parameters
    ----------
    value
        The objective.
    start, steps
        First point, and how far the others lie from it, each of shape (m,).
    tolerance
        Stop when the simplex is smaller than this part of `steps` and of its first spread of
        values.
    """
    points = [start.astype(np.float64), *(start + np.diag(steps))]
    values = [value(point) for point in points]
    first = max(values) - min(values)
    while True:
        order = np.argsort(values, kind="stable")
        points, values = [points[k] for k in order], [values[k] for k in order]
        size = float(np.max(np.abs(np.array(points[1:]) - points[0]) / np.abs(steps)))
        if size < tolerance or values[-1] - values[0] <= tolerance**2 * first:
            return
        centre = np.mean(points[:-1], axis=0)
        reflected = centre + (centre - points[-1])
        reached = value(reflected)
        if reached < values[0]:
            wide = centre + 2 * (centre - points[-1])
            wide_value = value(wide)
            if wide_value < reached:
                reflected, reached = wide, wide_value
        elif reached >= values[-2]:
            towards = reflected if reached < values[-1] else points[-1]
            narrow = centre + (towards - centre) / 2
            narrow_value = value(narrow)
            if narrow_value < min(reached, values[-1]):
                reflected, reached = narrow, narrow_value
            elif reached >= values[-1]:
                for k in range(1, len(points)):
                    points[k] = points[0] + (points[k] - points[0]) / 2
                    values[k] = value(points[k])
                continue
        points[-1], values[-1] = reflected, reached


def bfgs(slope: Slope, start: Floats, *, step: float = 0.1, tolerance: float = 1e-6) -> None:
    """Minimise by gradients (J. Nocedal and S. J. Wright, Numerical Optimization, 2006, chapter 6).

    Parameters
    ----------
    slope
        The objective and its gradient.
    start
        First point, shape (m,).
    step
        Length of the first step.
    tolerance
        Stop when a step promises less than this part of all that was gained so far.
    """
    point = start.astype(np.float64)
    value, way_up = slope(point)
    first = least = value
    inverse = np.eye(point.size) * (step / max(float(np.linalg.norm(way_up)), 1e-300))
    while True:
        way = -inverse @ way_up
        promise = float(way_up @ way)
        if promise >= 0:
            inverse = np.eye(point.size) * (step / max(float(np.linalg.norm(way_up)), 1e-300))
            way = -inverse @ way_up
            promise = float(way_up @ way)
        if -promise <= max(tolerance * (first - least), 1e-12 * abs(first)):
            return
        factor = 1.0
        while True:
            trial = point + factor * way
            trial_value, trial_slope = slope(trial)
            least = min(least, trial_value)
            if trial_value <= value + 1e-4 * factor * promise:
                break
            factor /= 2
            if factor < 1e-6:
                return
        moved, turned = trial - point, trial_slope - way_up
        along = float(moved @ turned)
        if along > 1e-12:
            left = np.eye(point.size) - np.outer(moved, turned) / along
            inverse = left @ inverse @ left.T + np.outer(moved, moved) / along
        point, value, way_up = trial, trial_value, trial_slope
