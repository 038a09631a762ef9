"""PennyLane Lightning: an adjoint gradient, in C++."""

import math

from qrobot.health.check import Check

A, B = 0.4, 1.1


def answer() -> list[float]:
    """Return ``<Z>`` of the second qubit after RX(a), RY(b), CNOT, and its gradient."""
    import pennylane as qml
    from pennylane import numpy as pnp

    device = qml.device("lightning.qubit", wires=2)

    @qml.qnode(device, diff_method="adjoint")  # type: ignore[untyped-decorator]
    def run(angles: tuple[float, float]) -> object:
        qml.RX(angles[0], 0)
        qml.RY(angles[1], 1)
        qml.CNOT([0, 1])
        return qml.expval(qml.PauliZ(1))

    angles = pnp.array([A, B], requires_grad=True)
    return [run(angles), *qml.grad(run)(angles)]


def expected() -> list[float]:
    """Return ``cos a cos b`` and its derivatives."""
    return [math.cos(A) * math.cos(B), -math.sin(A) * math.cos(B), -math.cos(A) * math.sin(B)]


CHECK = Check(
    __name__,
    title="an adjoint gradient",
    group="gate model",
    imports=("pennylane", "pennylane_lightning.lightning_qubit"),
    distributions=("pennylane-lightning", "pennylane", "autograd"),
    source="closed form: cos a cos b",
    extra="pennylane",
)
