"""What is minimised: the mean energy, or the mean of its lowest tail.

The conditional value at risk (CVaR) with share alpha is the mean of the lowest alpha of the
distribution (P. K. Barkoutsos et al., Quantum 4 (2020) 256). A sampler is judged by its best
reads, so a small alpha asks for what is wanted: some reads of least energy.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.algorithms import Turns
from qrobot.backends.gate.circuit import Circuit
from qrobot.backends.gate.engine import Engine, StateEngine, shift
from qrobot.backends.gate.form import Form, below, tail

__all__ = ["ExactObjective", "ShotObjective", "Tail", "tail_of_samples"]


class Tail:
    """The objective over exact probabilities.

    Parameters
    ----------
    energies
        Of all assignments, shape (2**n,).
    alpha
        Share of the distribution; 1 is the mean.
    """

    def __init__(self, energies: Floats, alpha: float) -> None:
        self.energies, self.alpha = energies, alpha
        self._order = np.argsort(energies, kind="stable") if alpha < 1.0 else None

    def value(self, probabilities: Floats) -> float:
        """Return the objective of a distribution, shape (2**n,)."""
        mean = float(probabilities @ self.weights(probabilities))
        return mean / float(probabilities.sum())

    def weights(self, probabilities: Floats) -> Floats:
        """Return the diagonal whose mean has the objective's value and derivatives here."""
        if self._order is None:
            return self.energies
        upto = np.cumsum(probabilities[self._order])
        at = min(int(np.searchsorted(upto, self.alpha * upto[-1])), upto.size - 1)
        return below(self.energies, float(self.energies[self._order[at]]), self.alpha)


def tail_of_samples(energies: Floats, alpha: float) -> tuple[float, float]:
    """Return the mean of the lowest `alpha` of sampled energies (one at least) and its end."""
    count = max(1, int(np.ceil(alpha * energies.size)))
    lowest = np.partition(energies, count - 1)[:count]
    return float(lowest.mean()), float(lowest.max())


class ExactObjective:
    """From exact probabilities.

    Parameters
    ----------
    engine
        The device.
    energies
        Of all assignments, shape (2**n,).
    alpha
        Share of the distribution.
    """

    def __init__(self, engine: StateEngine, energies: Floats, alpha: float) -> None:
        self.engine, self.tail = engine, Tail(energies, alpha)

    @cached_property
    def turns(self) -> Turns | None:
        """What `nft` needs: ``None`` where a parameter turns several rotations."""
        scales = _scales(self.engine.circuit)
        return None if scales is None else _SortedTail(self.engine, self.tail, scales)

    def value(self, parameters: Floats) -> float:
        """Return the objective."""
        angles = self.engine.circuit.angles(parameters)
        return self.tail.value(self.engine.probabilities(angles))

    def slope(self, parameters: Floats) -> tuple[float, Floats]:
        """Return the objective and its derivatives."""
        circuit = self.engine.circuit
        angles = circuit.angles(parameters)
        weights = self.tail.energies
        if self.tail.alpha < 1.0:
            weights = self.tail.weights(self.engine.probabilities(angles))
        value, by_angle = self.engine.slope(angles, weights)
        return value, circuit.pull_back(by_angle)


class _SortedTail:
    """The exact objective with assignments sorted by energy: a tail is a beginning."""

    def __init__(self, engine: StateEngine, tail: Tail, scales: Floats) -> None:
        self.engine, self.scales, self.alpha = engine, scales, tail.alpha
        self._order = np.argsort(tail.energies, kind="stable")
        self._energies = tail.energies[self._order]

    def distribution(self, parameters: Floats) -> Floats:
        angles = self.engine.circuit.angles(parameters)
        return self.engine.probabilities(angles)[self._order]

    def of(self, distribution: Floats) -> float:
        if self.alpha == 1.0:
            return float(distribution @ self._energies) / float(distribution.sum())
        return tail(self._energies, distribution, self.alpha)[0]


def _scales(circuit: Circuit) -> Floats | None:
    """Return the angle by parameter, or ``None`` where one turns several rotations or none."""
    slots = [gate.slot for gate in circuit.rotations]
    if sorted(slots) != list(range(circuit.size)):
        return None
    found = np.empty(circuit.size)
    found[slots] = [gate.scale for gate in circuit.rotations]
    return found if found.all() else None


class ShotObjective:
    """From measured shots.

    Parameters
    ----------
    engine
        The device.
    form
        The model.
    alpha
        Share of the shots.
    shots
        Of each run.
    rng
        Of the seed of each run.
    """

    def __init__(
        self, engine: Engine, form: Form, alpha: float, shots: int, rng: np.random.Generator
    ) -> None:
        self.engine, self.form, self.alpha = engine, form, alpha
        self.shots, self.rng = shots, rng

    turns = None

    def _energies(self, angles: Floats) -> Floats:
        seed = int(self.rng.integers(2**31))
        return self.form.energies(self.engine.samples(angles, self.shots, seed))

    def value(self, parameters: Floats) -> float:
        """Return the objective."""
        angles = self.engine.circuit.angles(parameters)
        return tail_of_samples(self._energies(angles), self.alpha)[0]

    def slope(self, parameters: Floats) -> tuple[float, Floats]:
        """Return the objective and its derivatives, by two runs a rotation."""
        circuit = self.engine.circuit
        angles = circuit.angles(parameters)
        value, end = tail_of_samples(self._energies(angles), self.alpha)

        def mean(at: Floats) -> float:
            energies = self._energies(at)
            kept = energies if self.alpha == 1.0 else below(energies, end, self.alpha)
            return float(kept.mean())

        return value, circuit.pull_back(shift(mean, angles))
