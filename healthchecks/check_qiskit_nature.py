# %% [markdown]
# # Qiskit Nature: electrons become qubits
#
# Electrons are indistinguishable and their exchange costs a sign; qubits know neither. The Jordan
# and Wigner mapping repairs this: the operator that creates electron $j$ drags a string of $Z$ over
# all qubits before it. Qiskit Nature writes Hamiltonians of molecules and solids, and maps them.

# %%
import numpy as np
from qiskit_nature.second_q.hamiltonians import FermiHubbardModel
from qiskit_nature.second_q.hamiltonians.lattices import LineLattice
from qiskit_nature.second_q.mappers import JordanWignerMapper

from qrobot.health.checks.qiskit_nature import CHECK, HOP, REPULSION
from qrobot.health.lesson import draw, table, verdict


def dimer(repulsion):
    """Return two sites: electrons hop, and repel one another on the same site."""
    line = LineLattice(2).uniform_parameters(-HOP, 0.0)
    return FermiHubbardModel(line, onsite_interaction=repulsion).second_q_op()


print(dimer(REPULSION))
qubits = JordanWignerMapper().map(dimer(REPULSION))
table(
    ["Pauli string", "factor"],
    [(word, float(factor.real)) for word, factor in qubits.simplify().to_list()],
)

# %% [markdown]
# ## Two electrons on two sites
#
# The Hubbard dimer can be solved by hand. With hopping $t$ and repulsion $U$ the lowest energy of
# two electrons is
#
# $$E_0 = \frac{U - \sqrt{U^2 + 16t^2}}{2}.$$
#
# Without repulsion both electrons share the bond, $E_0 = -2t$. With a strong one each stays on its
# site and gains only $-4t^2/U$: the root of magnetism.

# %%
strengths = np.linspace(0, 12, 13)
lowest = [(u - np.sqrt(u * u + 16 * HOP**2)) / 2 for u in strengths]
draw(lambda axes: axes.plot(strengths, lowest, strengths[3:], -4 * HOP**2 / strengths[3:], "--"))

# %% [markdown]
# ## The check
#
# All 16 energies of the dimer, with no to four electrons, against closed forms; and the ground
# state of the electrons of $\mathrm{H}_2$ from six published integrals (Szabo and Ostlund 1989),
# where two configurations mix: an eigenvalue of a matrix of two rows.

# %%
verdict(CHECK, [*(f"dimer {k + 1}" for k in range(16)), "electrons of H2, hartree"])

# %% [markdown]
# ## Try it yourself
#
# 1. To the energy of $\mathrm{H}_2$ add the repulsion of the nuclei, $1/1.4$ hartree, and compare
#    with `check_pyscf`.
# 2. Use `ParityMapper` instead. Which Pauli strings change, and do the energies?
