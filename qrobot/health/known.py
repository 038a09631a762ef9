"""Answers from plain numpy: an Ising model by trying all, a circuit by multiplying matrices.

Spin k of state s is +1 where bit k of s is 0, -1 where it is 1. Trips are tried one by one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "COUPLINGS",
    "FIELDS",
    "QUBITS",
    "SMALL_COUPLINGS",
    "SMALL_FIELDS",
    "all_spins",
    "circuits_answer",
    "circuits_expected",
    "energies",
    "energy_of",
    "ground_answer",
    "length",
    "lowest",
    "model",
    "qaoa_energy",
    "qaoa_probabilities",
    "shortest",
    "sum_of_chosen",
]

FIELDS: tuple[int, ...] = (1, -2, 3, -1, 2, -3, 1, -1)
"""Linear terms of the model that annealers minimize."""

COUPLINGS: dict[tuple[int, int], int] = {
    (i, j): (3 * i + 5 * j) % 7 - 3 for j in range(8) for i in range(j)
}
"""Quadratic terms; some are zero."""

QUBITS = 4
"""The circuits use the first spins only."""

SMALL_FIELDS = FIELDS[:QUBITS]
SMALL_COUPLINGS = {pair: value for pair, value in COUPLINGS.items() if max(pair) < QUBITS}

GAMMA, BETA = 0.21, 0.37
"""Angles of the circuit; any will do that is not a multiple of a symmetry."""


def all_spins(count: int) -> NDArray[np.int64]:
    """Return all states of spins, shape ``(2**count, count)``."""
    bits = np.arange(2**count)[:, None] >> np.arange(count) & 1
    return 1 - 2 * bits


def energies(samples: ArrayLike) -> NDArray[np.float64]:
    """Return the energies of states, shape ``(states, spins)``, by the definition."""
    spins = np.asarray(samples, dtype=float)
    count = spins.shape[1]
    total = spins @ np.asarray(FIELDS[:count], dtype=float)
    for (i, j), value in COUPLINGS.items():
        if j < count:
            total = total + value * spins[:, i] * spins[:, j]
    return np.asarray(total)


def energy_of(state: Mapping[int, int]) -> float:
    """Return the energy of one state of all eight spins."""
    return float(energies([[state[k] for k in range(len(FIELDS))]])[0])


def model() -> Any:
    """Return the model of all eight spins as dimod has it."""
    import dimod

    return dimod.BinaryQuadraticModel(dict(enumerate(FIELDS)), COUPLINGS, 0.0, "SPIN")


def lowest() -> float:
    """Return the ground state energy of all eight spins."""
    return float(energies(all_spins(len(FIELDS))).min())


def qaoa_probabilities() -> NDArray[np.float64]:
    """Return the probabilities of all states after one layer of QAOA, by state number.

    ``exp(-i beta sum X) exp(-i gamma E)`` on the uniform state (Farhi, Goldstone and Gutmann
    2014, arXiv 1411.4028): rotations RZ(2 gamma h), RZZ(2 gamma J), RX(2 beta).
    """
    size = 2**QUBITS
    state = np.exp(-1j * GAMMA * energies(all_spins(QUBITS))) / np.sqrt(size)
    mixer = np.array([[np.cos(BETA), -1j * np.sin(BETA)], [-1j * np.sin(BETA), np.cos(BETA)]])
    for _ in range(QUBITS):  # the last axis is worked on and becomes the first
        state = (state.reshape(-1, 2) @ mixer.T).T.reshape(-1)
    return np.asarray(np.abs(state) ** 2)


def qaoa_energy() -> float:
    """Return the mean energy of that state."""
    return float(qaoa_probabilities() @ energies(all_spins(QUBITS)))


def circuits_answer(exact: ArrayLike, counts: Mapping[str, int]) -> list[float]:
    """Return what a simulator says of both circuits as `circuits_expected` has it.

    Parameters
    ----------
    exact
        Probabilities of the QAOA layer, shape ``(2**QUBITS,)``.
    counts
        Shots of a GHZ state of three qubits, by outcome.
    """
    others = sum(n for state, n in counts.items() if state not in ("000", "111"))
    return [*np.asarray(exact, dtype=float).tolist(), float(others), float(sum(counts.values()))]


def circuits_expected(shots: int) -> list[float]:
    """Return the layer's probabilities from matrices; a GHZ state has two outcomes."""
    return [*qaoa_probabilities().tolist(), 0.0, float(shots)]


def ground_answer(sampler: Any, **options: Any) -> list[float]:
    """Return the lowest energy that an annealer tells, and that of its state in numpy."""
    best = sampler.sample(model(), **options).first
    return [best.energy, energy_of(best.sample)]


def sum_of_chosen(values: Sequence[int], bits: Sequence[int]) -> int:
    """Return the sum of the values whose bits are 1."""
    return sum(value * bit for value, bit in zip(values, bits, strict=True))


def length(trips: Iterable[Sequence[int]], between: Callable[[int, int], float]) -> float:
    """Return the length of round trips that begin and end at spot 0."""
    tours = ((0, *trip, 0) for trip in trips)
    return float(sum(between(a, b) for tour in tours for a, b in itertools.pairwise(tour)))


def shortest(weights: Sequence[int], room: int, between: Callable[[int, int], float]) -> float:
    """Return the least length of two trips: every sequence, cut in two at every place.

    Parameters
    ----------
    weights
        Of spots 1, 2 and so on; spot 0 is the depot.
    room
        Largest weight of a trip.
    between
        Distance of two spots.
    """
    best = math.inf
    for order in itertools.permutations(range(1, len(weights) + 1)):
        for cut in range(len(order) + 1):
            trips = (order[:cut], order[cut:])
            if all(sum(weights[spot - 1] for spot in trip) <= room for trip in trips):
                best = min(best, length(trips, between))
    return best
