# %% [markdown]
# # PennyLane: circuits as functions
#
# In PennyLane a circuit is a Python function of its angles, and can be differentiated like one.
# qRobot uses it for QAOA and VQE with gradients. `default.qubit` is its reference simulator: pure
# Python on numpy, slow and easy to trust.

# %%
import numpy as np
import pennylane as qml

from qrobot.health import known
from qrobot.health.checks.pennylane import CHECK
from qrobot.health.lesson import draw, verdict

words = [qml.PauliZ(k) for k in range(known.QUBITS)]
words += [qml.PauliZ(i) @ qml.PauliZ(j) for i, j in known.SMALL_COUPLINGS]
factors = [float(v) for v in (*known.SMALL_FIELDS, *known.SMALL_COUPLINGS.values())]
energy = qml.Hamiltonian(factors, words)


@qml.qnode(qml.device("default.qubit", wires=known.QUBITS))
def mean(gamma, beta):
    """Return the mean energy after one layer of QAOA."""
    for k, field in enumerate(known.SMALL_FIELDS):
        qml.Hadamard(k)
        qml.RZ(2 * gamma * field, k)
    for pair, coupling in known.SMALL_COUPLINGS.items():
        qml.IsingZZ(2 * gamma * coupling, pair)
    for k in range(known.QUBITS):
        qml.RX(2 * beta, k)
    return qml.expval(energy)


print(qml.draw(mean)(known.GAMMA, known.BETA))

# %% [markdown]
# ## Two knobs
#
# One layer of QAOA has two angles: $\gamma$, how long the energy turns the phases, and $\beta$, how
# much is mixed. The mean energy over both is a landscape, and its lowest place is where one samples
# from. Random guessing has the mean 0.

# %%
gammas, betas = np.linspace(0, 0.6, 13), np.linspace(0, np.pi / 2, 13)
landscape = np.array([[float(mean(g, b)) for g in gammas] for b in betas])
low = np.unravel_index(landscape.argmin(), landscape.shape)
draw(lambda axes: axes.contourf(gammas, betas, landscape, levels=20), size=(4, 3))
print("best of the grid:", landscape.min(), "at gamma", gammas[low[1]], "beta", betas[low[0]])
print("ground state of these four spins:", known.energies(known.all_spins(known.QUBITS)).min())

# %% [markdown]
# ## The check
#
# At fixed angles, the probabilities of all 16 states and the mean energy, against matrices in plain
# numpy. Angles were chosen that are not a multiple of a symmetry, so that a wrong sign, a factor of
# two or a swapped qubit shows.

# %%
verdict(CHECK, [*(f"P({k:04b})" for k in range(16)), "mean energy"])

# %% [markdown]
# ## Try it yourself
#
# 1. Add a second layer with angles of its own. How much lower does the mean get?
# 2. PennyLane's first wire is the highest bit, Qiskit's first qubit the lowest. Where in the check
#    is that put right?
