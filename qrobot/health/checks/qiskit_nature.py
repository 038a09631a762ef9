"""Qiskit Nature: the whole spectrum of a Hubbard dimer, and the hydrogen molecule."""

import math
from typing import Any

import numpy as np

from qrobot.health.check import Check

HOP, REPULSION = 0.7, 2.3

# H2 at 1.4 bohr in STO-3G, in hartree: A. Szabo and N. S. Ostlund, Modern Quantum Chemistry
# (1989), section 3.5.2; molecular orbitals 1 (bonding) and 2.
H11, H22, J11, J12, J22, K12 = -1.2528, -0.4756, 0.6746, 0.6636, 0.6975, 0.1813


def answer() -> list[float]:
    """Return the 16 energies of the dimer, and the lowest of H2's electrons."""
    from qiskit_nature.second_q.hamiltonians import ElectronicEnergy, FermiHubbardModel
    from qiskit_nature.second_q.hamiltonians.lattices import LineLattice
    from qiskit_nature.second_q.mappers import JordanWignerMapper

    def spectrum(problem: Any) -> list[float]:
        mapped = JordanWignerMapper().map(problem.second_q_op())
        return [float(value) for value in np.linalg.eigvalsh(mapped.to_matrix())]

    line = LineLattice(2).uniform_parameters(-HOP, 0.0)
    hubbard = FermiHubbardModel(line, onsite_interaction=REPULSION)
    repulsions = np.zeros((2, 2, 2, 2))  # in the chemists' notation: (11|22) is J12, (12|12) K12
    repulsions[0, 0, 0, 0], repulsions[1, 1, 1, 1] = J11, J22
    repulsions[0, 0, 1, 1] = repulsions[1, 1, 0, 0] = J12
    for place in ((0, 1, 0, 1), (0, 1, 1, 0), (1, 0, 0, 1), (1, 0, 1, 0)):
        repulsions[place] = K12
    molecule = ElectronicEnergy.from_raw_integrals(np.diag([H11, H22]), repulsions)
    return [*spectrum(hubbard), spectrum(molecule)[0]]


def expected() -> list[float]:
    """Return the closed forms: sectors of 0 to 4 electrons; two configurations of H2."""
    t, u = HOP, REPULSION
    root = math.sqrt(u * u + 16 * t * t)
    one, three = [-t, -t, t, t], [u - t, u - t, u + t, u + t]
    two = [(u - root) / 2, 0, 0, 0, u, (u + root) / 2]
    both, none = 2 * H11 + J11, 2 * H22 + J22
    ground = (both + none) / 2 - math.hypot((none - both) / 2, K12)
    return [*sorted([0, *one, *two, *three, 2 * u]), ground]


CHECK = Check(
    __name__,
    title="a Hubbard dimer and H2",
    group="gate model",
    imports=("qiskit_nature.second_q.hamiltonians", "qiskit_nature.second_q.mappers"),
    distributions=("qiskit-nature", "qiskit"),
    source="closed forms; H2's integrals: Szabo and Ostlund 1989",
    extra="science",
)
