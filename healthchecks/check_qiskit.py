# %% [markdown]
# # Qiskit: circuits, and what a machine makes of them
#
# Qiskit writes quantum circuits, rewrites them for the gates that a machine has, and computes small
# ones exactly. qRobot's QAOA and VQE for IBM's machines are built with it. Its core is Rust,
# compiled for each processor.

# %%
from qiskit import transpile
from qiskit.quantum_info import Statevector

from qrobot.health import known
from qrobot.health.checks.qiskit import CHECK, circuit
from qrobot.health.lesson import draw, table, verdict

made = circuit()
print(made.draw("text", fold=110))

# %% [markdown]
# This is one layer of QAOA (Farhi, Goldstone and Gutmann 2014, arXiv 1411.4028) for four spins:
# the energy turns phases, $e^{-i\gamma E}$, and a mixer $e^{-i\beta \sum_k X_k}$ lets the states
# interfere. Qubit 0 is the last letter of a state's name: Qiskit counts from the right.
#
# ## The same on hardware gates
#
# A machine may know three gates only. The picture changes, the state must not:

# %%
lowered = transpile(made, basis_gates=["rz", "sx", "cx"], optimization_level=2, seed_transpiler=1)
table(
    ["circuit", "depth", "gates"],
    [
        (name, made_of.depth(), str(dict(made_of.count_ops())))
        for name, made_of in (("as written", made), ("for hardware", lowered))
    ],
)
print("overlap of the states:", abs(Statevector(made).inner(Statevector(lowered))))

# %%
chances = Statevector(lowered).probabilities()
energy = known.energies(known.all_spins(known.QUBITS))
draw(lambda axes: axes.scatter(energy, chances))
print("mean energy", chances @ energy, " by guessing", energy.mean())

# %% [markdown]
# One dot a state: its energy, and its chance, which was 1/16 before. The angles were chosen to show
# mistakes, not to be good: here high energies became likelier.
#
# ## The check
#
# The mean energy by Qiskit's estimator, and the probabilities of all 16 states of the transpiled
# circuit, against the same product of matrices in plain numpy (`known.qaoa_probabilities`, ten
# lines).

# %%
verdict(CHECK, ["mean energy", *(f"P({k:04b})" for k in range(16))])

# %% [markdown]
# ## Try it yourself
#
# 1. Change `known.GAMMA` and `known.BETA` (a sign is enough to begin with) and look for the lowest
#    mean energy of one layer.
# 2. Transpile with `coupling_map=[[0, 1], [1, 2], [2, 3]]`. How many more `cx` does a line cost?
