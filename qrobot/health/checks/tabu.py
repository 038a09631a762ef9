"""tabu: tabu search finds the ground state of eight spins."""

from __future__ import annotations

import numpy as np

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the lowest energy that was told, and the energy of its state in numpy."""
    import dimod
    from dwave.samplers import TabuSampler

    model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
    best = TabuSampler().sample(model, num_reads=2, timeout=5000, num_restarts=20, seed=7).first
    state = np.array([[best.sample[k] for k in range(len(known.FIELDS))]])
    return [best.energy, float(known.energies(state)[0])]


def expected() -> list[float]:
    """Return the ground state energy, twice."""
    return [known.lowest()] * 2


CHECK = Check(
    module=__name__,
    title="tabu search, 8 spins",
    group="annealing",
    imports=("dwave.samplers",),
    distributions=("dwave-samplers",),
    answer=answer,
    expected=expected,
    source="all 256 states in numpy",
    quick=True,
)
