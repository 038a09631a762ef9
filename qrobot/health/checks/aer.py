"""Aer: the same circuit, exact probabilities and a seeded sample."""

from qrobot.health import known
from qrobot.health.check import Check

SHOTS = 1000


def answer() -> list[float]:
    """Return the probabilities of all states, and the shots of a GHZ state by outcome."""
    from qiskit import QuantumCircuit
    from qiskit_aer import AerSimulator

    from qrobot.health.checks.qiskit import circuit

    # All gates are Aer's own; what transpiling does, the check of qiskit shows.
    device = AerSimulator(method="statevector", seed_simulator=1)
    made = circuit()
    made.save_probabilities()
    exact = device.run(made).result().data()["probabilities"]
    ghz = QuantumCircuit(3)
    ghz.h(0)
    ghz.cx(0, 1)
    ghz.cx(1, 2)
    ghz.measure_all()
    counts = device.run(ghz, shots=SHOTS).result().get_counts()
    return known.circuits_answer(exact, counts)


def expected() -> list[float]:
    """Return the same from matrices; a GHZ state has two outcomes."""
    return known.circuits_expected(SHOTS)


CHECK = Check(
    __name__,
    title="exact and sampled circuits",
    group="gate model",
    imports=("qiskit", "qiskit_aer"),
    distributions=("qiskit-aer", "qiskit"),
    source="the circuit as matrices in numpy; the definition of a GHZ state",
    extra="qiskit",
)
