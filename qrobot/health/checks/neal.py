"""neal: simulated annealing finds the ground state of eight spins."""

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the lowest energy that was told, and the energy of its state in numpy."""
    import neal

    return known.ground_answer(neal.SimulatedAnnealingSampler(), num_reads=100, seed=7)


def expected() -> list[float]:
    """Return the ground state energy, twice."""
    return [known.lowest()] * 2


CHECK = Check(
    __name__,
    title="simulated annealing, 8 spins",
    group="annealing",
    imports=("neal",),
    distributions=("dwave-neal", "dwave-samplers"),
    source="all 256 states in numpy",
    quick=True,
)
