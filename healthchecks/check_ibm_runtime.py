# %% [markdown]
# # IBM Runtime: the way to IBM's machines
#
# `qiskit-ibm-runtime` sends circuits to IBM's quantum computers. For tests it brings snapshots of
# retired ones: `FakeManilaV2` has the five qubits, the couplings and the measured errors of
# *ibmq_manila*, simulated here by Aer. No account, no network.

# %%
from qiskit import QuantumCircuit
from qiskit.transpiler import generate_preset_pass_manager
from qiskit_ibm_runtime.fake_provider import FakeManilaV2

from qrobot.health.checks.ibm_runtime import CHECK, MISREAD, SHOTS
from qrobot.health.lesson import table, verdict

backend = FakeManilaV2()
print(backend.num_qubits, "qubits, coupled:", sorted(backend.coupling_map.get_edges()))
table(
    ["qubit", "T1, microseconds", "error of reading"],
    [
        (k, backend.qubit_properties(k).t1 * 1e6, backend.target["measure"][(k,)].error)
        for k in range(backend.num_qubits)
    ],
)

# %% [markdown]
# ## A machine has its own gates
#
# Runtime accepts only circuits in the machine's gates on the machine's qubits, so every circuit is
# lowered first. The Hadamard becomes rotations; the two qubits are chosen by their errors.

# %%
bell = QuantumCircuit(2)
bell.h(0)
bell.cx(0, 1)
bell.measure_all()
lowered = generate_preset_pass_manager(
    optimization_level=1, backend=backend, seed_transpiler=1
).run(bell)
print(lowered.draw("text", idle_wires=False))

# %% [markdown]
# ## The check
#
# The Bell state $(|00\rangle + |11\rangle)/\sqrt2$ gives 00 and 11 with one half each. A noisy
# machine sometimes says 01 or 10, and it takes 1 for 0 more often than 0 for 1, because an excited
# qubit decays while it is read. How often was measured by IBM, so it can be allowed for: a matrix a
# qubit turns what it is into what is read. The gates' own errors are about 0.01; with the scatter
# of 8,000 shots the tolerance is 0.03. A rotation that is 7 % too small moves the shares by 0.05.
# Every shot must come back.

# %%
table(["qubit", "0 read as 1", "1 read as 0"], [(k, *MISREAD[k]) for k in range(2)])
print(SHOTS, "shots")
verdict(CHECK, ["shots were lost", "share of 00", "share of 11"])

# %% [markdown]
# ## Try it yourself
#
# 1. Chain 20 more pairs of `cx` before the measurement. How fast does the share of 01 and 10 grow?
# 2. Compare `FakeManilaV2` with a newer snapshot of the same `fake_provider`. What improved?
