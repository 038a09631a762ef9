"""Two small local optimisers that count every evaluation: the same answer on every machine.

`nelder_mead` needs values only (J. A. Nelder and R. Mead, The Computer Journal 7 (1965) 308);
`bfgs` needs gradients (J. Nocedal and S. J. Wright, Numerical Optimization, 2006, chapter 6).
A handful of angles needs no more, and scipy is not part of the base installation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from qrobot._arrays import Floats

__all__ = ["Minimum", "bfgs", "nelder_mead"]


@dataclass(slots=True)
class Minimum:
    """The best point of a search.

    Parameters
    ----------
    point, value
        Where, and how low.
    evaluations
        Calls of the function; a call with gradient counts once.
    history
        The best value after each call.
    """

    point: Floats
    value: float
    evaluations: int = 0
    history: list[float] = field(default_factory=list)

    def offer(self, point: Floats, value: float) -> float:
        """Count an evaluation and keep the better point; return the value."""
        if value < self.value:
            self.point, self.value = point.copy(), value
        self.evaluations += 1
        self.history.append(self.value)
        return value


def nelder_mead(
    function: Callable[[Floats], float],
    start: Floats,
    steps: Floats,
    *,
    budget: int,
    tolerance: float = 1e-4,
) -> Minimum:
    """Minimise without gradients.

    Parameters
    ----------
    function
        What to minimise.
    start, steps
        First point, and how far the others lie from it, each of shape (m,).
    budget
        Most evaluations.
    tolerance
        Stop when the simplex is smaller than this part of `steps` and of its first spread of
        values.
    """
    best = Minimum(start.copy(), np.inf)

    def at(point: Floats) -> float:
        return best.offer(point, float(function(point)))

    points = [start.astype(np.float64), *(start + np.diag(steps))]
    values = [at(point) for point in points[: max(budget, 1)]]
    if len(values) < len(points):
        return best
    first = max(values) - min(values)
    while best.evaluations < budget:
        order = np.argsort(values, kind="stable")
        points, values = [points[k] for k in order], [values[k] for k in order]
        size = float(np.max(np.abs(np.array(points[1:]) - points[0]) / np.abs(steps)))
        if size < tolerance or values[-1] - values[0] <= tolerance**2 * first:
            break
        centre = np.mean(points[:-1], axis=0)
        reflected = centre + (centre - points[-1])
        value = at(reflected)
        if value < values[0] and best.evaluations < budget:
            wide = centre + 2 * (centre - points[-1])
            wide_value = at(wide)
            if wide_value < value:
                reflected, value = wide, wide_value
        elif value >= values[-2] and best.evaluations < budget:
            towards = reflected if value < values[-1] else points[-1]
            narrow = centre + (towards - centre) / 2
            narrow_value = at(narrow)
            if narrow_value < min(value, values[-1]):
                reflected, value = narrow, narrow_value
            elif value >= values[-1]:
                for k in range(1, len(points)):
                    if best.evaluations >= budget:
                        return best
                    points[k] = points[0] + (points[k] - points[0]) / 2
                    values[k] = at(points[k])
                continue
        points[-1], values[-1] = reflected, value
    return best


def bfgs(
    function: Callable[[Floats], tuple[float, Floats]],
    start: Floats,
    *,
    budget: int,
    step: float = 0.1,
    tolerance: float = 1e-6,
) -> Minimum:
    """Minimise with gradients.

    Parameters
    ----------
    function
        Returns the value and its gradient, shape (m,).
    start
        First point, shape (m,).
    budget
        Most evaluations.
    step
        Length of the first step.
    tolerance
        Stop when a step promises less than this part of all that was gained so far.
    """
    best = Minimum(start.copy(), np.inf)
    point = start.astype(np.float64)
    value, slope = function(point)
    first = best.offer(point, value)
    inverse = np.eye(point.size) * (step / max(float(np.linalg.norm(slope)), 1e-300))
    while best.evaluations < budget:
        way = -inverse @ slope
        promise = float(slope @ way)
        if promise >= 0:
            inverse = np.eye(point.size) * (step / max(float(np.linalg.norm(slope)), 1e-300))
            way = -inverse @ slope
            promise = float(slope @ way)
        if -promise <= max(tolerance * (first - best.value), 1e-12 * abs(first)):
            break
        factor, accepted = 1.0, False
        while best.evaluations < budget:
            trial = point + factor * way
            trial_value, trial_slope = function(trial)
            best.offer(trial, trial_value)
            if trial_value <= value + 1e-4 * factor * promise:
                accepted = True
                break
            factor /= 2
            if factor < 1e-6:
                break
        if not accepted:
            break
        moved, turned = trial - point, trial_slope - slope
        along = float(moved @ turned)
        if along > 1e-12:
            left = np.eye(point.size) - np.outer(moved, turned) / along
            inverse = left @ inverse @ left.T + np.outer(moved, moved) / along
        point, value, slope = trial, trial_value, trial_slope
    return best
