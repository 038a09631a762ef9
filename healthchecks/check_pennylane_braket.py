# %% [markdown]
# # The Braket plugin of PennyLane
#
# The plugin lets a PennyLane function run on Braket's devices: write once, and change one name to
# go from this simulator to a machine in the cloud. The check proves the joint between the two:
# gates, angles, wires and results are translated right.

# %%
import pennylane as qml

from qrobot.health.checks.pennylane_braket import CHECK, A, B
from qrobot.health.lesson import table, verdict


def run(a, b):
    """Turn two qubits, entangle them, look at both."""
    qml.RX(a, 0)
    qml.RY(b, 1)
    qml.CNOT([0, 1])
    return qml.expval(qml.PauliZ(0)), qml.expval(qml.PauliZ(1))


print(qml.draw(qml.QNode(run, qml.device("default.qubit", wires=2)))(A, B))

# %% [markdown]
# ## One function, two devices

# %%
rows = []
for name in ("default.qubit", "braket.local.qubit"):
    means = qml.QNode(run, qml.device(name, wires=2))(A, B)
    rows.append((name, *(f"{float(mean):.12f}" for mean in means)))
table(["device", "mean of Z, qubit 0", "mean of Z, qubit 1"], rows)

# %% [markdown]
# ## The check
#
# The first qubit is not touched after RX(a): $\langle Z_0\rangle = \cos a$. On the second CNOT
# multiplies, $\langle Z_1\rangle = \cos a \cos b$, as in `check_lightning`. The angles 0.4 and 1.1
# differ, so swapped wires would show.

# %%
verdict(CHECK, ["cos a", "cos a cos b"])

# %% [markdown]
# ## Try it yourself
#
# 1. Ask both devices for `shots=100`. Which digits are left?
# 2. Here gradients by Braket need two circuits an angle. Why does qRobot take Lightning for
#    gradients and Braket for samples?
