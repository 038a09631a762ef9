"""QAOA within a subspace: exact states of the plans that keep the constraints, and their mixers.

S. Hadfield et al., "From the quantum approximate optimization algorithm to a quantum
alternating operator ansatz", Algorithms 12 (2019) 34; A. Baertschi and S. Eidenbenz, "Grover
mixers for QAOA", IEEE QCE (2020) 72. Each mixer is one product of exponentials in a fixed order,
the same here and in the circuits of `constrained`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, States
from qrobot.backends.gate import resources
from qrobot.backends.gate.feasible import FeasibleSet
from qrobot.backends.gate.form import below, tail
from qrobot.errors import InputError

__all__ = [
    "MIXERS",
    "GroverMixer",
    "Mixer",
    "OneHotMixer",
    "SubspaceQAOA",
    "SwapMixer",
    "check_mixer",
    "expected_best",
    "one_hot",
    "transpositions",
]


MIXERS = ("swap", "swap-all", "grover")
"""Of the plans of a feasible set."""


def check_mixer(name: str) -> None:
    """Refuse a name that is not in `MIXERS`."""
    if name not in MIXERS:
        raise InputError(
            f"{name!r} is not a mixer", field="mixer", advice=f"use one of {', '.join(MIXERS)}"
        )


class Mixer(Protocol):
    """A family of unitaries U(beta)."""

    beta_range: tuple[float, float]

    def apply(self, state: States, beta: float) -> States:
        """Return U(beta) state; the given array may be used up."""
        ...

    def slope(self, bra: States, ket: States, beta: float) -> tuple[States, States, float]:
        """Undo U(beta) on both and return them and 2 Re <bra| U' U^-1 |ket>."""
        ...


class GroverMixer:
    """exp(-i beta |s><s|) with the start state s: all states that cost the same stay equal.

    Parameters
    ----------
    start
        The state s, shape (N,).
    """

    beta_range = (-math.pi, math.pi)

    def __init__(self, start: States) -> None:
        self.start = start

    def apply(self, state: States, beta: float) -> States:
        """Return U(beta) state."""
        share = complex(np.vdot(self.start, state)) * (np.exp(-1j * beta) - 1)
        state += share * self.start
        return state

    def slope(self, bra: States, ket: States, beta: float) -> tuple[States, States, float]:
        """Undo U(beta) on both and return them and the derivative."""
        into, out = complex(np.vdot(bra, self.start)), complex(np.vdot(self.start, ket))
        return self.apply(bra, -beta), self.apply(ket, -beta), 2 * (into * out).imag


class SwapMixer:
    """Product of exp(-i beta S) over exchanges S of two positions of the sequence.

    S exchanges the two stops and is the identity where that would leave the feasible set; it is
    its own inverse, so exp(-i beta S) = cos beta - i sin beta S.

    Parameters
    ----------
    partners
        For each exchange, in sequence, the state that each state goes to, shape (N,).
    """

    beta_range = (-math.pi / 2, math.pi / 2)

    def __init__(self, partners: Sequence[npt.NDArray[np.intp]]) -> None:
        self.partners = list(partners)

    @classmethod
    def of(cls, feasible: FeasibleSet, pairs: str = "adjacent") -> SwapMixer:
        """Return the mixer of a feasible set; `pairs` is ``adjacent`` or ``all``."""
        exchanges = transpositions(feasible.sequences.shape[1], pairs)
        needed = feasible.size * (8 * len(exchanges) + 80)
        resources.require(needed, f"{len(exchanges)} exchanges of {feasible.size:,} states")
        return cls([feasible.swapped(a, b) for a, b in exchanges])

    def apply(self, state: States, beta: float) -> States:
        """Return U(beta) state."""
        for partner in self.partners:
            state = _exchange(state, partner, beta)
        return state

    def slope(self, bra: States, ket: States, beta: float) -> tuple[States, States, float]:
        """Undo U(beta) on both and return them and the derivative."""
        total = 0.0
        for partner in reversed(self.partners):
            total += 2 * float(np.vdot(bra, ket[partner]).imag)
            bra, ket = _exchange(bra, partner, -beta), _exchange(ket, partner, -beta)
        return bra, ket, total


class OneHotMixer:
    """XY mixer of each step: product of exp(-i beta (XX + YY) / 2) over pairs of nodes.

    It keeps one node a step, not one step a node: the subspace has n**n states. Pairs go round
    the ring, (0, 1), (2, 3), .. then (1, 2), .. and the closing pair last.

    Parameters
    ----------
    nodes, steps
        Values of one step, and number of steps; a state has nodes**steps amplitudes, the last
        step's node running fastest.
    """

    beta_range = (-math.pi / 2, math.pi / 2)

    def __init__(self, nodes: int, steps: int) -> None:
        self.nodes, self.steps = nodes, steps

    @staticmethod
    def pairs(nodes: int) -> list[tuple[int, int]]:
        """Return the pairs of the ring in the sequence in which they are applied."""
        ring = [(k, k + 1) for k in range(0, nodes - 1, 2)]
        ring += [(k, k + 1) for k in range(1, nodes - 1, 2)]
        return [*ring, (nodes - 1, 0)] if nodes > 2 else ring

    def step(self, beta: float) -> tuple[States, States]:
        """Return the unitary of one step and its derivative times its inverse."""
        U = np.eye(self.nodes, dtype=np.complex128)
        G = np.zeros_like(U)
        for a, b in self.pairs(self.nodes):
            one = np.eye(self.nodes, dtype=np.complex128)
            one[a, a] = one[b, b] = math.cos(beta)
            one[a, b] = one[b, a] = -1j * math.sin(beta)
            U, G = one @ U, one @ G @ one.conj().T
            G[a, b] += -1j
            G[b, a] += -1j
        return U, G

    def apply(self, state: States, beta: float) -> States:
        """Return U(beta) state."""
        U = self.step(beta)[0]
        for axis in range(self.steps):
            state = self._along(U, state, axis)
        return state

    def slope(self, bra: States, ket: States, beta: float) -> tuple[States, States, float]:
        """Undo U(beta) on both and return them and the derivative."""
        U, G = self.step(beta)
        total = sum(
            2 * float(np.vdot(bra, self._along(G, ket, axis)).real) for axis in range(self.steps)
        )
        inverse = U.conj().T
        for axis in range(self.steps):
            bra, ket = self._along(inverse, bra, axis), self._along(inverse, ket, axis)
        return bra, ket, total

    def _along(self, matrix: States, state: States, axis: int) -> States:
        shaped = state.reshape(self.nodes**axis, self.nodes, -1)
        found: States = np.matmul(matrix, shaped).reshape(-1)
        return found


def transpositions(length: int, pairs: str = "adjacent") -> list[tuple[int, int]]:
    """Return pairs of positions in the sequence in which they are exchanged.

    ``adjacent`` goes even then odd, (0, 1), (2, 3), .. (1, 2), ..; ``all`` by distance.
    """
    if pairs == "all":
        return [(a, a + d) for d in range(1, length) for a in range(length - d)]
    return [(a, a + 1) for first in (0, 1) for a in range(first, length - 1, 2)]


def _exchange(state: States, partner: npt.NDArray[np.intp], beta: float) -> States:
    other = state[partner]
    other *= -1j * math.sin(beta)
    state = state * math.cos(beta)
    state += other
    return state


class SubspaceQAOA:
    """The state U(beta_p) exp(-i gamma_p D) ... U(beta_1) exp(-i gamma_1 D) |s>.

    Parameters
    ----------
    costs
        D of each state, shape (N,).
    mixer
        U.
    start
        The state s, shape (N,); uniform by default.
    alpha
        The objective is the mean of the lowest `alpha` of the distribution; 1: expectation.
    """

    def __init__(
        self, costs: Floats, mixer: Mixer, *, start: States | None = None, alpha: float = 1.0
    ) -> None:
        if not 0.0 < alpha <= 1.0:
            raise InputError(
                f"alpha {alpha:g} is not a share", field="alpha", advice="use 0 < alpha <= 1"
            )
        count = len(costs)
        self.costs, self.mixer, self.alpha = costs, mixer, alpha
        self.start: States = np.full(count, count**-0.5 + 0j) if start is None else start
        weights = np.abs(self.start) ** 2
        self.mean = float(weights @ costs)
        self.spread = float(np.sqrt(weights @ (costs - self.mean) ** 2))
        self.beta_range = mixer.beta_range
        self.lowest = float(costs.min())

    @classmethod
    def of(cls, feasible: FeasibleSet, mixer: str = "swap", *, alpha: float = 1.0) -> SubspaceQAOA:
        """Return the ansatz of a feasible set; `mixer` is ``swap``, ``swap-all`` or ``grover``."""
        check_mixer(mixer)
        costs = feasible.costs
        if mixer == "grover":
            start: States = np.full(len(costs), len(costs) ** -0.5 + 0j)
            return cls(costs, GroverMixer(start), start=start, alpha=alpha)
        pairs = "all" if mixer == "swap-all" else "adjacent"
        return cls(costs, SwapMixer.of(feasible, pairs), alpha=alpha)

    # -- the state -------------------------------------------------------------------

    def state(self, gammas: Floats, betas: Floats) -> States:
        """Return the amplitudes, shape (N,)."""
        state = self.start.copy()
        for gamma, beta in zip(gammas, betas, strict=True):
            state *= np.exp((-1j * float(gamma)) * self.costs)
            state = self.mixer.apply(state, float(beta))
        return state

    def probabilities(self, gammas: Floats, betas: Floats) -> Floats:
        """Return the probability of each state, shape (N,)."""
        found: Floats = np.abs(self.state(gammas, betas)) ** 2
        return found

    # -- the ansatz of `tune` --------------------------------------------------------

    def guess(self) -> tuple[float, float] | None:
        """Return None: no closed form is known for these mixers."""
        return None

    def value(self, gammas: Floats, betas: Floats) -> float:
        """Return the objective."""
        return self._tail(np.abs(self.state(gammas, betas)) ** 2)[0]

    def gradient(self, gammas: Floats, betas: Floats) -> tuple[float, Floats, Floats]:
        """Return the objective and its derivatives, by one run forward and one backward."""
        ket = self.state(gammas, betas)
        value, end = self._tail(np.abs(ket) ** 2)
        weight = self.costs
        if self.alpha < 1.0:
            weight = below(self.costs, end, self.alpha)
        bra = weight * ket
        by_gamma, by_beta = np.zeros(len(gammas)), np.zeros(len(betas))
        for layer in range(len(gammas) - 1, -1, -1):
            bra, ket, slope = self.mixer.slope(bra, ket, float(betas[layer]))
            by_beta[layer] = slope
            by_gamma[layer] = 2 * float(np.vdot(bra, self.costs * ket).imag)
            turn = np.exp((1j * float(gammas[layer])) * self.costs)
            bra *= turn
            ket *= turn
        return value, by_gamma, by_beta

    @cached_property
    def _rising(self) -> npt.NDArray[np.intp]:
        return np.argsort(self.costs, kind="stable")

    def _tail(self, p: Floats) -> tuple[float, float]:
        if self.alpha == 1.0:
            return float(p @ self.costs / p.sum()), float("inf")
        return tail(self.costs[self._rising], p[self._rising], self.alpha)


def one_hot(
    distances: Floats, penalty: float, *, alpha: float = 1.0
) -> tuple[SubspaceQAOA, npt.NDArray[np.bool_]]:
    """Return the ansatz on all n**n assignments of one node a step, and which are tours.

    Parameters
    ----------
    distances
        Between depot (row 0) and n items, shape (n + 1, n + 1).
    penalty
        Cost of an item's visits beside one, squared.
    alpha
        Share of the objective.

    Raises
    ------
    BackendError
        When n**n amplitudes do not fit into memory, before any is made.
    """
    n = len(distances) - 1
    resources.require((n + 120) * n**n, f"holding {n**n:,} states of {n} steps")
    stops = np.indices((n,) * n, dtype=np.uint8).reshape(n, -1)
    costs = distances[0, stops[0] + 1] + distances[stops[-1] + 1, 0]
    for a, b in pairwise(stops):
        costs = costs + distances[a + 1, b + 1]
    excess = sum(((stops == i).sum(axis=0, dtype=np.int16) - 1) ** 2 for i in range(n))
    ansatz = SubspaceQAOA(costs + penalty * excess, OneHotMixer(n, n), alpha=alpha)
    return ansatz, np.asarray(excess == 0)


def expected_best(costs: Floats, probabilities: Floats, shots: int) -> float:
    """Return the expected lowest cost of so many shots."""
    levels, where = np.unique(costs, return_inverse=True)
    mass = np.bincount(where, probabilities, len(levels))
    above = np.concatenate([np.cumsum(mass[::-1])[::-1] / mass.sum(), [0.0]])
    none_below = np.clip(above, 0.0, 1.0) ** shots
    return float(levels @ (none_below[:-1] - none_below[1:]))
