"""Distances and costs as whole numbers, with ties going to fewer trips.

Integer solvers get ``round(distance * scale) * spread`` and pay 1 for each trip. With
``spread`` larger than the number of trips, one more trip never pays for less than one unit
of distance: distance first, trips second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot.problem import Instance

__all__ = ["Whole", "usual_distance", "whole_costs"]

SAMPLED = 500
"""Rows of a large matrix that say what distances are usual."""


@dataclass(frozen=True, slots=True)
class Whole:
    """A way to write distances as whole numbers.

    Parameters
    ----------
    scale
        Units per metre: 1 when all distances are whole.
    spread
        What one unit of distance costs; one trip costs 1.
    exact
        Whether nothing was rounded.
    """

    scale: float
    spread: int
    exact: bool

    def cost(self, lengths: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
        """Return the whole cost of lengths, without the price of trips."""
        return np.rint(lengths * self.scale).astype(np.int64) * self.spread

    def length(self, cost: float) -> float:
        """Return a length in metres that is surely not above what the cost stands for."""
        length = cost / self.spread / self.scale
        # Each trip was rounded by half a unit at most.
        return max(0.0, length if self.exact else length - self.spread / self.scale)


def whole_costs(instance: Instance, resolution: float, trips: int, largest: float) -> Whole:
    """Return how to write an instance's distances as whole numbers.

    Parameters
    ----------
    instance
        Its distances are kept as they are when they are whole already.
    resolution
        Otherwise: units in a distance of the usual size. One long way, such as that to a
        place far off, does not coarsen the others.
    trips
        The most trips that a plan can have.
    largest
        No plan may cost more.
    """
    d = instance.stop_distances
    # Every stop is entered once, and every trip comes home.
    longest = float(d[:, 1:].max(axis=0).sum() + trips * d[1:, 0].max(initial=0.0))
    room = largest / (trips + 1) / max(longest, 1e-300)
    if room >= 1.0 and bool((d == np.round(d)).all()):
        return Whole(1.0, trips + 1, True)
    return Whole(min(resolution / usual_distance(instance), room), trips + 1, False)


def usual_distance(instance: Instance) -> float:
    """Return the median of the ways that useful plans may contain, 1 when none is long."""
    d = instance.stop_distances
    d = d[:: 1 + len(d) // SAMPLED]
    useful = np.sort(d[(d > 0.0) & (d < instance.longest_useful)])
    if not useful.size:
        return 1.0
    # numpy's own median imports its masked arrays, a tenth of the time of a start.
    return float((useful[(len(useful) - 1) // 2] + useful[len(useful) // 2]) / 2.0)
