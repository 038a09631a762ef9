"""tabu: tabu search finds the ground state of eight spins."""

from __future__ import annotations

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the lowest energy that was told, and the energy of its state in numpy."""
    from dwave.samplers import TabuSampler

    return known.ground_answer(TabuSampler(), num_reads=2, timeout=5000, num_restarts=20, seed=7)


CHECK = Check(
    module=__name__,
    title="tabu search, 8 spins",
    group="annealing",
    imports=("dwave.samplers",),
    distributions=("dwave-samplers",),
    answer=answer,
    expected=known.ground_expected,
    source="all 256 states in numpy",
    quick=True,
)
