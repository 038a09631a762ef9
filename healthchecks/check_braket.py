# %% [markdown]
# # Amazon Braket: one interface, many machines
#
# Braket sends circuits to machines of several makers, and to a simulator on this computer. The
# check uses the local one, `braket_sv`, which keeps the whole state vector: $2^n$ complex numbers
# for $n$ qubits. Much is loaded and compiled when it is first used, so a first run is slower than a
# second. That is not a fault.

# %%
import time

from braket.circuits import Circuit
from braket.devices import LocalSimulator

from qrobot.health.checks.braket import CHECK, SHOTS
from qrobot.health.lesson import table, verdict

device = LocalSimulator("braket_sv")
ghz = Circuit().h(0).cnot(0, 1).cnot(1, 2)
print(ghz)

# %%
rows = []
for attempt in ("first run", "second run"):
    begun = time.perf_counter()
    counts = device.run(ghz, shots=SHOTS).result().measurement_counts
    rows.append((attempt, time.perf_counter() - begun, str(dict(counts))))
table(["", "seconds", "outcomes"], rows)

# %% [markdown]
# ## Which end is qubit 0?
#
# With one qubit flipped the order shows. Braket writes qubit 0 on the left, Qiskit on the right.
# Forgetting this swaps orders in a decoded plan, and nothing crashes: so the check compares all 16
# probabilities of a circuit without symmetry.

# %%
flipped = device.run(Circuit().x(0).i(1).i(2), shots=1).result().measurement_counts
print("X on qubit 0 of three:", dict(flipped))

# %% [markdown]
# ## The check
#
# One layer of QAOA for four spins, exactly (`shots=0`), against matrices in plain numpy; then shots
# of the GHZ state above, where only 000 and 111 may come.

# %%
verdict(CHECK, [*(f"P({k:04b})" for k in range(16)), "other outcomes", f"shots of {SHOTS}"])

# %% [markdown]
# ## Try it yourself
#
# 1. `LocalSimulator("braket_dm")` knows noise. Add `.depolarizing(0, 0.1)`: which outcomes appear?
# 2. On a paid machine each shot costs. What does `qrobot solve --dry-run` say before it sends?
