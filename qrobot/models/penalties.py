"""Weights of the constraints: measured ones, provably safe ones, and your own."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from qrobot.errors import InputError
from qrobot.models.fleet import fleet_of
from qrobot.models.potentials import potentials_of
from qrobot.problem import Instance

__all__ = ["Encoding", "Penalties"]

Encoding = Literal["compact", "reduced", "full"]

MAX_LOADS = 200_000
"""Different loads of sets of orders that are looked at for the least overload."""


@dataclass(frozen=True, slots=True)
class Penalties:
    """Weights of the constraints, in units of energy, which are units of distance.

    Parameters
    ----------
    step
        A: of each robot being in exactly one place at each step (and, in the full
        encoding, at the depot at the ends), times the square of the deviation.
    visit
        Of each item being collected exactly once, times the square of the deviation.
    capacity
        B: of load + slack = M, times the square of the deviation in units of weight. Mind
        that squares of units are large numbers.
    same_robot
        Of each pair of items of one order that different robots collect.
    detour
        Added to every way from the depot at a later step than the first, so that breaking
        a trip at the depot never pays. Zero is enough when distances keep the triangle
        inequality at the depot.
    shift
        How much of the potentials to take off the distances, 0 to 1 (compact encoding
        only; see `potentials`).
    """

    step: float
    visit: float
    capacity: float
    same_robot: float
    detour: float = 0.0
    shift: float = 0.0

    def __post_init__(self) -> None:
        """Refuse weights that are not numbers or reward violations."""
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, bool) or not isinstance(value, int | float | np.number):
                raise InputError(
                    f"{value!r} is not a number",
                    field=f"penalties.{field.name}",
                    advice="give a weight of zero or more",
                )
            if not (math.isfinite(value) and value >= 0):
                raise InputError(
                    f"weight {float(value):.12g} is negative or not finite",
                    field=f"penalties.{field.name}",
                    advice="give a weight of zero or more",
                )

    @classmethod
    def measured(cls, instance: Instance, encoding: Encoding = "compact") -> Penalties:
        """Return the weights that sampled best when measured; not proof-safe, so verify.

        The scale of A is the largest distance for the paper's encodings and the spread of
        the distances for the compact one. B is set against the mean square of the item
        weights, so that the unit of weight does not matter. docs/formulation.md tells how
        they were found.
        """
        squares = instance.weights.astype(np.float64) ** 2
        square = float(squares.mean()) if squares.any() else 1.0
        robots = len(fleet_of(instance))
        if encoding == "compact":
            a = _compact_weight(instance, min(robots, _trips_needed(instance) + 1))
            b = a / square
        else:
            small = max(0.0, 1.8 / max(instance.size, 1) - 0.2)
            a = (0.5 + 0.25 * min(robots, 3) + small) * _largest(instance)
            b = (0.5 if robots == 1 else 1.0) * a / square
        return cls(
            step=a,
            visit=a,
            capacity=b,
            same_robot=1.5 * a,
            detour=_detour(instance.distances),
            shift=1.0 if encoding == "compact" else 0.0,
        )

    @classmethod
    def safe(cls, instance: Instance) -> Penalties:
        """Return weights under which the best plan is provably the lowest energy.

        Proof. Let the slack be exact, P the weights step, visit and same_robot, all equal,
        and U < P an upper bound of the distance of every feasible plan. A feasible plan
        leaves each item once and the depot once per trip, so
        U = (sum over items i of max over j of d[i, j]) + T max over j of d[0, j], with T
        the most trips, will do. The capacity weight is P / g^2, with g the least amount by
        which any set of whole orders exceeds any capacity. The shift is 0, so the energy is
        a sum of terms none of which is negative: walked distances, detours, and weighted
        squares or products that count violations.

        An assignment that breaks a step, a visit or a whole order has a deviation of at
        least 1 in it (all sums are whole numbers), so its energy is at least P > U: above
        every feasible plan. One that breaks none of these visits each item once, in whole
        orders; where it overloads a robot, it does so by g or more, which no slack can make
        up for, so its energy is at least (P / g^2) g^2 = P again. One that breaks nothing
        is a plan whatever its slack, and its energy is at least the distance walked, with a
        detour weight on every return to the depot in the middle. Leaving that return out
        changes the distance by d[i, j] - d[i, 0] - d[0, j] <= detour, so decoding it gives
        a plan that is no longer than the energy. Encoded plans reach that: the lowest
        energy is the least distance.

        The price: weights that high freeze an annealer. Use them to prove, not to sample.
        """
        d = instance.distances
        trips = min(len(fleet_of(instance)), max(len(instance.orders), 1))
        longest = float(d[1:].max(axis=1).sum()) + trips * float(d[0].max())
        weight = 1.01 * longest + (1.0 if longest == 0.0 else 0.0)
        return cls(
            step=weight,
            visit=weight,
            capacity=weight / float(_least_overload(instance)) ** 2,
            same_robot=weight,
            detour=_detour(d),
            shift=0.0,
        )

    @classmethod
    def of(
        cls,
        instance: Instance,
        encoding: Encoding,
        given: Penalties | Mapping[str, float] | str | None,
    ) -> Penalties:
        """Return the penalties given or named, the measured ones, or these with some replaced.

        Raises
        ------
        InputError
            When a name is unknown or a weight is unusable.
        """
        if isinstance(given, Penalties):
            return given
        if given == "safe":
            return cls.safe(instance)
        if given == "measured":
            given = None
        if not isinstance(given, Mapping | None):
            raise InputError(
                f"{given!r} does not name weights",
                field="penalties",
                advice='use safe, measured, or some by name, such as {"visit": 30.0}',
            )
        measured = cls.measured(instance, encoding)
        if not given:
            return measured
        names = [field.name for field in dataclasses.fields(cls)]
        for name in given:
            if name not in names:
                raise InputError(
                    f"there is no weight {name!r}",
                    field="penalties",
                    advice=f"use some of {', '.join(names)}",
                )
        return dataclasses.replace(measured, **given)


def _least_overload(instance: Instance) -> int:
    """Return the least amount by which a set of whole orders exceeds a capacity, in units.

    Where no set exceeds any, the least capacity above 0: an overload cannot happen. Where
    there are too many sums to look at, 1: no overload is smaller.
    """
    loads = np.zeros(1, dtype=np.int64)
    for load in instance.order_weights.tolist():
        loads = np.unique(np.concatenate([loads, loads + load]))
        if len(loads) > MAX_LOADS:
            return 1
    rooms = np.unique(instance.capacities)
    first = np.searchsorted(loads, rooms, side="right")
    exceeded = first < len(loads)
    found = loads[first[exceeded]] - rooms[exceeded] if exceeded.any() else rooms[rooms > 0]
    return int(found.min()) if found.size else 1


def _compact_weight(instance: Instance, trips: int) -> float:
    """Return A for the compact encoding; the shorter the trips, the larger."""
    d = instance.distances
    n = len(d) - 1
    if n < 2:
        return _largest(instance)
    # Ways that only mark something would widen the spread of those that are driven.
    spread = float(d[~np.eye(n + 1, dtype=bool) & (d < instance.longest_useful)].std())
    if trips > 1:
        return max((1.7 + 6.5 * (trips / n) ** 2) * spread, 0.25 * _largest(instance))
    # What the two cheapest ways at an item still cost after the shift is what dropping
    # the item would gain at least.
    shifted = potentials_of(instance, several=False).shifted(d)
    legs = (shifted + shifted.T) / 2 + np.diag(np.full(n + 1, np.inf))
    dropped = float(np.sort(legs, axis=1)[:, :2].mean(axis=1).max())
    return max(1.25 * spread, 1.3 * dropped, 0.1 * _largest(instance))


def _trips_needed(instance: Instance) -> int:
    room = int(instance.capacities.max())
    total = int(instance.weights.sum())
    return max(1, -(-total // room)) if room > 0 else 1


def _largest(instance: Instance) -> float:
    """Return the largest distance that a useful plan may contain."""
    d = instance.distances
    return float(d.max(where=d < instance.longest_useful, initial=0.0)) or 1.0


def _detour(d: npt.NDArray[np.float64]) -> float:
    """Return by how much a way over the depot is shorter than the direct one, at most."""
    if len(d) < 3:
        return 0.0
    gain = d[1:, 1:] - d[1:, :1] - d[:1, 1:]
    np.fill_diagonal(gain, 0.0)
    worst = float(gain.max())
    return worst if worst > 1e-9 * float(d.max()) else 0.0
