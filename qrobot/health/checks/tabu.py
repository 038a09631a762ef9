"""tabu: tabu search finds the ground state of eight spins."""

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the lowest energy that was told, and the energy of its state in numpy."""
    from dwave.samplers import TabuSampler

    return known.ground_answer(TabuSampler(), num_reads=2, timeout=5000, num_restarts=20, seed=7)


def expected() -> list[float]:
    """Return the ground state energy, twice."""
    return [known.lowest()] * 2


CHECK = Check(
    __name__,
    title="tabu search, 8 spins",
    group="annealing",
    imports=("dwave.samplers",),
    distributions=("dwave-samplers",),
    source="all 256 states in numpy",
    quick=True,
)
