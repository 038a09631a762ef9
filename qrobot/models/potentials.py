"""Distances shifted by potentials: the same plans at the same energies, easier to find.

Every feasible plan leaves each item once and reaches each item once. Taking u[i] off every
way out of i and v[j] off every way into j therefore changes the energy of all feasible
plans by one constant, which the model adds back. What changes is the energy of everything
else: an item that lies far out no longer gains by being dropped, so weights of constraints
far below the largest distance hold, and an annealer moves more freely.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qrobot._arrays import Floats
from qrobot.problem import Instance

__all__ = ["Potentials", "potentials_of"]


NEAREST = 3
"""Neighbours whose mean distance estimates the ways at an item."""

DEPOT_SHARE = 0.25
"""Of the mean way that items leave to the depot, for the depot's own potential."""


@dataclass(frozen=True, slots=True, eq=False)
class Potentials:
    """What is taken off the ways at each node."""

    leaving: Floats
    """u, taken off every way out of a node, shape (n + 1,)"""
    reaching: Floats
    """v, taken off every way into a node, shape (n + 1,)"""

    def shifted(self, distances: Floats) -> Floats:
        """Return d[i, j] - u[i] - v[j]; an item that follows itself costs nothing extra."""
        shifted = distances - self.leaving[:, None] - self.reaching[None, :]
        items = np.arange(1, len(distances))
        shifted[items, items] = 0.0
        return shifted


def potentials_of(instance: Instance, *, several: bool, scale: float = 1.0) -> Potentials:
    """Return potentials that estimate half of the ways at each node; scale 0 gives none.

    Where several vehicles drive, the depot counts among the neighbours of every item, and has a
    potential of its own.
    """
    d = instance.distances
    n = len(d) - 1
    if n == 0 or scale == 0.0:
        return Potentials(np.zeros(n + 1), np.zeros(n + 1))
    if not several:
        return Potentials(scale * _half(d, NEAREST), scale * _half(d.T, NEAREST))
    leaving, reaching = np.zeros(n + 1), np.zeros(n + 1)
    for way, side in ((d, leaving), (d.T, reaching)):
        near = min(NEAREST - 1, n - 1)
        side[1:] = way[1:, 0] / 2
        if near:
            side[1:] = (near * _half(way[1:, 1:], near) + side[1:]) / (near + 1)
    leaving[0] = DEPOT_SHARE * float((d[0, 1:] - reaching[1:]).mean())
    reaching[0] = DEPOT_SHARE * float((d[1:, 0] - leaving[1:]).mean())
    return Potentials(scale * leaving, scale * reaching)


def _half(way: Floats, nearest: int) -> Floats:
    """Return half of the mean of each row's smallest entries, the diagonal left out."""
    others = way + np.diag(np.full(len(way), np.inf))
    count = min(nearest, len(way) - 1)
    return np.asarray(np.sort(others, axis=1)[:, :count].mean(axis=1) / 2)
