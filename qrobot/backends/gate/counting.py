"""How many plans have which distance, without making the plans: the Grover mixer beyond n = 9.

With a Grover mixer, states of equal cost keep equal amplitudes (A. Baertschi and S. Eidenbenz,
"Grover mixers for QAOA", IEEE QCE (2020) 72; the compressed simulation is J. Golden et al.,
"Numerical evidence for exponential speed-up of QAOA over unstructured search", IEEE QCE (2023)).
So the exact state needs one amplitude a distance, weighted with the number of plans, and whole
distances are few. The numbers come from a dynamic programme over (visited items, last item)
whose value is a histogram of distances (M. Held and R. M. Karp, SIAM J. 10 (1962) 196, with
counts in place of minima), and for several robots from products of histograms over all splits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, Ints
from qrobot.backends.gate import resources
from qrobot.backends.gate.state.subspace import GroverMixer, SubspaceQAOA
from qrobot.errors import BackendError, InfeasibleError, InputError
from qrobot.models.fleet import fleet_of
from qrobot.problem import Instance
from qrobot.problem.fleets import what_is_enough

__all__ = ["Spectrum", "spectrum"]


MOST_ITEMS = 15
"""More items need too many sets: 15 take about a minute."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Distances of all feasible plans (in the states of `feasible`) and how many have each.

    Parameters
    ----------
    levels
        The distances that occur, rising, shape (L,).
    counts
        Number of plans of each, shape (L,).
    """

    levels: Floats
    counts: Ints

    @property
    def size(self) -> int:
        """Number of plans."""
        return int(self.counts.sum())

    @property
    def optimal(self) -> int:
        """Number of plans of least distance."""
        return int(self.counts[0])

    def qaoa(self, *, alpha: float = 1.0) -> SubspaceQAOA:
        """Return the exact ansatz with the Grover mixer, one amplitude a distance.

        State k stands for the normalised sum of all plans of distance `levels[k]`.
        """
        start = np.sqrt(self.counts / self.counts.sum()) + 0j
        return SubspaceQAOA(self.levels, GroverMixer(start), start=start, alpha=alpha)


def spectrum(instance: Instance) -> Spectrum:
    """Count the feasible plans by distance.

    Raises
    ------
    InputError
        When a distance is not a whole number.
    BackendError
        When there are too many items, or memory is too small, before any of it is taken.
    InfeasibleError
        When no plan fits the capacities.
    """
    d, n = instance.distances, instance.size
    capacities = fleet_of(instance, every_robot=True).capacities
    if not (d == np.round(d)).all():
        raise InputError(
            "plans are counted by whole distances only",
            field="warehouse",
            advice="use rounding 'nearest' on an open floor, or enumerate up to 9 items",
        )
    if n > MOST_ITEMS:
        raise BackendError(f"{n} items are more than the {MOST_ITEMS} that can be counted")
    whole = d.astype(np.int64)
    length = int(whole.max(axis=1, initial=0).sum()) + 1
    robots, units = len(capacities), _units(instance)
    layer = max((math.comb(n, k) * n for k in range(n + 1)), default=1)
    sets = 2 ** len(units) if robots > 1 else 1
    resources.require(
        8 * length * (2 * layer + 8 * sets), f"counting {n} items and distances up to {length:,}"
    )
    tours = _tours(whole, length, units, everything=robots > 1)
    counts = tours[-1] if robots == 1 else _split(instance, capacities, units, tours)
    if robots == 1 and instance.weights.sum() > capacities[0]:
        counts = np.zeros_like(counts)
    levels = np.flatnonzero(counts)
    if not levels.size:
        raise InfeasibleError(
            f"no plan fits the capacities of the robots; {what_is_enough(instance)}"
        )
    return Spectrum(levels.astype(np.float64), counts[levels])


def _units(instance: Instance) -> list[int]:
    """Return what is assigned as a whole, as sets of items: bit i is item i."""
    groups = (
        instance.order_nodes if instance.whole_orders else [(i + 1,) for i in range(instance.size)]
    )
    return [sum(1 << (node - 1) for node in nodes) for nodes in groups]


def _unions(units: list[int]) -> npt.NDArray[np.int64]:
    """Return for each set of units what they have together, shape (2**len(units),)."""
    found = np.zeros(1, dtype=np.int64)
    for unit in units:
        found = np.concatenate([found, found | unit])
    return found


def _tours(d: npt.NDArray[np.int64], length: int, units: list[int], *, everything: bool) -> Ints:
    """Count closed tours by distance: of all items, or of every set of units (row: the set)."""
    n = len(d) - 1
    wanted = {int(items): row for row, items in enumerate(_unions(units))} if everything else {}
    closed = np.zeros((len(wanted) or 1, length), dtype=np.int64)
    if not n or everything:
        closed[0, 0] = 1  # a robot that stays at home
    row_of = wanted if everything else {(1 << n) - 1: 0}
    layer: dict[int, Ints] = {}
    for i in range(n):
        first = np.zeros((n, length), dtype=np.int64)
        first[i, d[0, i + 1]] = 1
        layer[1 << i] = first
    for _ in range(n):
        following: dict[int, Ints] = {}
        for items, paths in layer.items():
            inside = [i for i in range(n) if items >> i & 1]
            if (row := row_of.get(items)) is not None:
                for i in inside:
                    step = int(d[i + 1, 0])
                    closed[row, step:] += paths[i, : length - step]
            for j in range(n):
                if items >> j & 1:
                    continue
                target = following.get(items | 1 << j)
                if target is None:
                    target = following[items | 1 << j] = np.zeros((n, length), dtype=np.int64)
                for i in inside:
                    step = int(d[i + 1, j + 1])
                    target[j, step:] += paths[i, : length - step]
        layer = following
    return closed


def _split(instance: Instance, capacities: Ints, units: list[int], tours: Ints) -> Ints:
    """Count plans of several robots by total distance.

    Products of histograms are products of their Fourier transforms; the numbers stay far below
    2**53 and the distance from whole numbers is checked.
    """
    weights = instance.weights
    items = _unions(units)
    loads = np.array(
        [sum(int(weights[i]) for i in range(len(weights)) if s >> i & 1) for s in items.tolist()]
    )
    # Robots share the items, so only their ways back to the depot add to the bound of one tour.
    room = tours.shape[1] + (len(capacities) - 1) * int(instance.distances[0].max())
    size = 1 << room.bit_length()
    waves = np.fft.rfft(tours, size, axis=1)
    full = len(items) - 1
    so_far = np.where((loads <= capacities[0])[:, None], waves, 0)
    for p, capacity in enumerate(capacities[1:], start=1):
        fits = loads <= capacity
        last = p == len(capacities) - 1
        following = np.zeros_like(so_far)
        for whole in [full] if last else range(full + 1):
            parts = _unions([1 << k for k in range(len(units)) if whole >> k & 1])
            parts = parts[fits[parts]]
            following[whole] = np.einsum("ij,ij->j", waves[parts], so_far[whole ^ parts])
        so_far = following
    found = np.fft.irfft(so_far[full], size)
    counts = np.rint(found)
    if np.abs(found - counts).max() > 0.2 or counts.max(initial=0) > 2.0**50:
        raise BackendError("the counts are too large to be exact")
    return counts.astype(np.int64)
