"""neal: simulated annealing finds the ground state of eight spins."""

from __future__ import annotations

import numpy as np

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the lowest energy that was told, and the energy of its state in numpy."""
    import dimod
    import neal

    model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
    best = neal.SimulatedAnnealingSampler().sample(model, num_reads=100, seed=7).first
    state = np.array([[best.sample[k] for k in range(len(known.FIELDS))]])
    return [best.energy, float(known.energies(state)[0])]


def expected() -> list[float]:
    """Return the ground state energy, twice."""
    return [known.lowest()] * 2


CHECK = Check(
    module=__name__,
    title="simulated annealing, 8 spins",
    group="annealing",
    imports=("neal",),
    distributions=("dwave-neal", "dwave-samplers"),
    answer=answer,
    expected=expected,
    source="all 256 states in numpy",
    quick=True,
)
