"""Mixers that keep the constraints, on the states of a subspace.

S. Hadfield et al., "From the quantum approximate optimization algorithm to a quantum
alternating operator ansatz", Algorithms 12 (2019) 34; A. Baertschi and S. Eidenbenz, "Grover
mixers for QAOA", IEEE QCE (2020) 72. Each is one product of exponentials in a fixed order, the
same here and in the circuits of `circuits`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from qrobot._arrays import States
from qrobot.backends.gate import resources
from qrobot.backends.gate.feasible import FeasibleSet

__all__ = ["GroverMixer", "Mixer", "OneHotMixer", "SwapMixer", "transpositions"]


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
