"""dimod: energies of all states in both vartypes, and its exhaustive solver."""

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the energies of 16 states as spins and as bits, and the lowest of 256."""
    import dimod

    small = dimod.BinaryQuadraticModel(
        dict(enumerate(known.SMALL_FIELDS)), known.SMALL_COUPLINGS, 0.0, "SPIN"
    )
    spins = known.all_spins(known.QUBITS)
    as_bits = small.change_vartype("BINARY", inplace=False)
    return [
        *small.energies((spins, range(known.QUBITS))),
        *as_bits.energies(((1 + spins) // 2, range(known.QUBITS))),
        dimod.ExactSolver().sample(known.model()).first.energy,
    ]


def expected() -> list[float]:
    """Return the same from the definition."""
    values = known.energies(known.all_spins(known.QUBITS)).tolist()
    return [*values, *values, known.lowest()]


CHECK = Check(
    __name__,
    title="energies of a binary quadratic model",
    group="base",
    imports=("dimod",),
    source="the definition of the energy, over all states, in numpy",
    quick=True,
)
