"""PennyLane: one layer of QAOA on its reference simulator."""

from qrobot.health import known
from qrobot.health.check import Check


def answer() -> list[float]:
    """Return the probabilities of all states and the mean energy."""
    import pennylane as qml

    device = qml.device("default.qubit", wires=known.QUBITS)
    words = [qml.PauliZ(k) for k in range(known.QUBITS)]
    words += [qml.PauliZ(i) @ qml.PauliZ(j) for i, j in known.SMALL_COUPLINGS]
    factors = [float(v) for v in (*known.SMALL_FIELDS, *known.SMALL_COUPLINGS.values())]

    @qml.qnode(device)  # type: ignore[untyped-decorator]
    def run() -> object:
        for k, field in enumerate(known.SMALL_FIELDS):
            qml.Hadamard(k)
            qml.RZ(2 * known.GAMMA * field, k)
        for pair, coupling in known.SMALL_COUPLINGS.items():
            qml.IsingZZ(2 * known.GAMMA * coupling, pair)
        for k in range(known.QUBITS):
            qml.RX(2 * known.BETA, k)
        # PennyLane counts the first wire as the highest bit.
        wires = range(known.QUBITS - 1, -1, -1)
        return qml.probs(wires=wires), qml.expval(qml.Hamiltonian(factors, words))

    probabilities, mean = run()
    return [*probabilities.tolist(), float(mean)]


def expected() -> list[float]:
    """Return the same from matrices."""
    return [*known.qaoa_probabilities().tolist(), known.qaoa_energy()]


CHECK = Check(
    __name__,
    title="a QAOA circuit",
    group="gate model",
    imports=("pennylane",),
    source="the circuit as matrices in numpy",
    extra="pennylane",
)
