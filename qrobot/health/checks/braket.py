"""Amazon Braket's local simulator: one layer of QAOA, exactly, and a sampled GHZ state."""

from qrobot.health import known
from qrobot.health.check import Check

SHOTS = 100


def answer() -> list[float]:
    """Return the probabilities of all states, and the shots of a GHZ state by outcome."""
    from braket.circuits import Circuit
    from braket.devices import LocalSimulator

    made = Circuit()
    for k, field in enumerate(known.SMALL_FIELDS):
        made.h(k).rz(k, 2 * known.GAMMA * field)
    for (i, j), coupling in known.SMALL_COUPLINGS.items():
        made.zz(i, j, 2 * known.GAMMA * coupling)
    for k in range(known.QUBITS):
        made.rx(k, 2 * known.BETA)
    # Braket counts the first qubit as the highest bit.
    made.probability(target=range(known.QUBITS - 1, -1, -1))
    device = LocalSimulator("braket_sv")
    exact = device.run(made, shots=0).result().values[0]
    ghz = device.run(Circuit().h(0).cnot(0, 1).cnot(1, 2), shots=SHOTS).result()
    counts = ghz.measurement_counts
    return known.circuits_answer(exact, counts)


def expected() -> list[float]:
    """Return the same from matrices; a GHZ state has two outcomes."""
    return known.circuits_expected(SHOTS)


CHECK = Check(
    __name__,
    title="exact and sampled circuits",
    group="gate model",
    imports=("braket.circuits", "braket.devices"),
    distributions=("amazon-braket-sdk", "amazon-braket-default-simulator"),
    source="the circuit as matrices in numpy; the definition of a GHZ state",
    extra="braket",
)
