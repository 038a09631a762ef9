# %% [markdown]
# # Aer: a quantum computer in C++
#
# Aer simulates circuits fast, with or without noise. A real machine never shows probabilities: it
# is run many times (shots) and each run gives one outcome. Aer does both, and qRobot uses it to
# try QAOA and VQE before a machine is paid for.

# %%
from qiskit import QuantumCircuit, transpile
from qiskit_aer import AerSimulator

from qrobot.health.checks.aer import CHECK, SHOTS
from qrobot.health.lesson import table, verdict

device = AerSimulator(method="statevector", seed_simulator=1)
ghz = QuantumCircuit(3)
ghz.h(0)
ghz.cx(0, 1)
ghz.cx(1, 2)
ghz.measure_all()
print(ghz.draw("text"))

# %% [markdown]
# ## Shots scatter
#
# The state $(|000\rangle + |111\rangle)/\sqrt 2$ gives 000 or 111, each with one half, and nothing
# else. The share of 111 in $N$ shots scatters by $\frac{1}{2\sqrt N}$: four times the shots, half
# the error.

# %%
rows = []
for shots in (16, 64, 256, 1024, 4096, 16384):
    counts = device.run(transpile(ghz, device), shots=shots).result().get_counts()
    rows.append((shots, counts.get("111", 0) / shots, 0.5 / shots**0.5))
table(["shots", "share of 111", "expected scatter around 0.5"], rows)

# %% [markdown]
# ## The check
#
# The exact probabilities of the QAOA layer of `check_qiskit`, against matrices in numpy. Then a
# thousand shots of the state above: no outcome other than 000 and 111, and none of the shots lost.
# How often each of the two came is chance and is not asked.

# %%
verdict(CHECK, [*(f"P({k:04b})" for k in range(16)), "other outcomes", f"shots of {SHOTS}"])

# %% [markdown]
# ## Try it yourself
#
# 1. Put `ghz.h(range(3))` before the measurement. Which outcomes vanish, and why those?
# 2. `method="matrix_product_state"` holds 40 qubits of this state. Why not 40 qubits of any state?
