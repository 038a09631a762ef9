# %% [markdown]
# # PySCF: the energy of a molecule
#
# Chemistry is where quantum computers are expected to pay first, and PySCF is where their numbers
# are compared: it computes molecules from nothing but the positions of the nuclei. In 2021 it took
# a Pi half an hour to build; now it is a wheel.
#
# The hydrogen molecule in the smallest basis, STO-3G: one orbital an atom. Hartree-Fock puts both
# electrons into the sum of the two; *full configuration interaction* mixes in the state where both
# are in the difference, and is exact in this basis.

# %%
from pyscf import fci, gto, scf

from qrobot.health.checks.pyscf import CHECK
from qrobot.health.lesson import draw, table, verdict


def energies(distance):
    """Return the energy by Hartree-Fock and the exact one, in hartree; the distance in angstrom."""
    atoms = f"H 0 0 0; H 0 0 {distance}"
    field = scf.RHF(gto.M(atom=atoms, basis="sto-3g", verbose=0)).run()
    return float(field.e_tot), float(fci.FCI(field).kernel()[0])


distances = [0.4, 0.5, 0.6, 0.7414, 0.9, 1.2, 1.6, 2.2, 3.0]
curve = [energies(distance) for distance in distances]
draw(lambda axes: axes.plot(distances, curve, marker="."))
table(
    ["angstrom", "Hartree-Fock", "exact", "missing"],
    [(d, hf, full, hf - full) for d, (hf, full) in zip(distances, curve, strict=True)],
)

# %% [markdown]
# Near the minimum Hartree-Fock is nearly right. Pulled apart, it fails: it insists on both
# electrons in one shared orbital, so half of the time on $\mathrm{H}^+\mathrm{H}^-$. The exact
# curve ends at two atoms, $2 \cdot (-0.4666)$ hartree in this basis. What is missing is called
# correlation, and is what a quantum computer is wanted for.
#
# ## The check
#
# Two published numbers of four digits: Hartree-Fock at 1.4 bohr (Szabo and Ostlund 1989, table
# 3.12), and the exact energy at 0.7414 angstrom (O'Malley et al. 2016, arXiv 1512.06860).

# %%
verdict(CHECK, ["Hartree-Fock, hartree", "exact, hartree"])

# %% [markdown]
# ## Try it yourself
#
# 1. Take the basis `cc-pvdz`. How much lower is the energy, and which of the two gains more?
# 2. One hartree is 2,625 kJ/mol. How strong is the bond, in kJ/mol? (Measured: about 436.)
