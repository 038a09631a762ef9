"""The PennyLane plugin of Braket: a PennyLane circuit on Braket's local simulator."""

import math

from qrobot.health.check import Check

A, B = 0.4, 1.1


def answer() -> list[float]:
    """Return ``<Z>`` of both qubits after RX(a), RY(b), CNOT."""
    import pennylane as qml

    device = qml.device("braket.local.qubit", wires=2)

    @qml.qnode(device)  # type: ignore[untyped-decorator]
    def run() -> object:
        qml.RX(A, 0)
        qml.RY(B, 1)
        qml.CNOT([0, 1])
        return qml.expval(qml.PauliZ(0)), qml.expval(qml.PauliZ(1))

    return [float(value) for value in run()]


def expected() -> list[float]:
    """Return ``cos a`` and ``cos a cos b``."""
    return [math.cos(A), math.cos(A) * math.cos(B)]


CHECK = Check(
    __name__,
    title="a PennyLane circuit on Braket",
    group="gate model",
    imports=("pennylane", "braket.pennylane_plugin"),
    distributions=("amazon-braket-pennylane-plugin", "pennylane", "amazon-braket-sdk"),
    source="closed form: cos a, cos a cos b",
    extra="edge",
)
