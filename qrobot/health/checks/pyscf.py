"""PySCF: the hydrogen molecule in STO-3G, by Hartree-Fock and with all configurations."""

import math
from typing import Any

from qrobot.health.check import Check

# In hartree, of the bonding (1) and the other orbital (2), at 1.401 bohr = 0.7414 angstrom.
H11, H22, J11, J22, K12 = -1.252477, -0.475934, 0.674493, 0.697397, 0.181287
DISTANCE = 1.401
"""Bohr."""


def answer() -> list[float]:
    """Return the energies (hartree) at 1.4 bohr by RHF, and at 0.7414 angstrom by full CI."""
    from pyscf import fci, gto, scf

    def field(distance: float, unit: str) -> Any:
        atoms = f"H 0 0 0; H 0 0 {distance}"
        return scf.RHF(gto.M(atom=atoms, unit=unit, basis="sto-3g", verbose=0)).run()

    return [field(1.4, "Bohr").e_tot, fci.FCI(field(0.7414, "Angstrom")).kernel()[0]]


def expected() -> list[float]:
    """Return the published energy, and the lower of two states made of published integrals."""
    both, none = 2 * H11 + J11, 2 * H22 + J22
    ground = (both + none) / 2 - math.hypot((none - both) / 2, K12)
    return [-1.1167, ground + 1 / DISTANCE]


CHECK = Check(
    __name__,
    title="H2 in STO-3G",
    group="science",
    imports=("pyscf.gto", "pyscf.scf", "pyscf.fci"),
    distributions=("pyscf",),
    source="Szabo and Ostlund 1989, section 3.5.2 (RHF, four digits); the integrals of Whitfield, "
    "Biamonte and Aspuru-Guzik 2011, arXiv 1001.3855 (full CI)",
    tolerance=1e-4,
    extra="science",
)
