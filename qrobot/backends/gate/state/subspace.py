"""QAOA within a subspace: exact states of the plans that keep the constraints."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats, States
from qrobot.backends.gate import resources
from qrobot.backends.gate.feasible import FeasibleSet
from qrobot.backends.gate.mixers import GroverMixer, Mixer, OneHotMixer, SwapMixer
from qrobot.errors import InputError

__all__ = ["SubspaceQAOA", "expected_best", "one_hot"]


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
        costs = feasible.costs
        if mixer == "grover":
            start: States = np.full(len(costs), len(costs) ** -0.5 + 0j)
            return cls(costs, GroverMixer(start), start=start, alpha=alpha)
        if mixer in ("swap", "swap-all"):
            pairs = "all" if mixer == "swap-all" else "adjacent"
            return cls(costs, SwapMixer.of(feasible, pairs), alpha=alpha)
        raise InputError(
            f"{mixer!r} is not a mixer", field="mixer", advice="use swap, swap-all or grover"
        )

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
            weight = end - np.maximum(end - self.costs, 0.0) / self.alpha
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
        """Return the mean of the lowest `alpha` and the cost where it ends."""
        if self.alpha == 1.0:
            return float(p @ self.costs / p.sum()), float("inf")
        costs, p = self.costs[self._rising], p[self._rising]
        upto = np.cumsum(p)
        share = self.alpha * upto[-1]
        cut = int(min(np.searchsorted(upto, share), len(upto) - 1))
        before = upto[cut - 1] if cut else 0.0
        end = float(costs[cut])
        return float((p[:cut] @ costs[:cut] + (share - before) * end) / share), end


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
