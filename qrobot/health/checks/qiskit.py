"""Qiskit: one layer of QAOA, transpiled to hardware gates, by the reference estimator."""

from typing import Any

from qrobot.health import known
from qrobot.health.check import Check


def circuit() -> Any:
    """Return the circuit of `known.qaoa_probabilities`."""
    from qiskit import QuantumCircuit

    made = QuantumCircuit(known.QUBITS)
    made.h(range(known.QUBITS))
    for k, field in enumerate(known.SMALL_FIELDS):
        made.rz(2 * known.GAMMA * field, k)
    for (i, j), coupling in known.SMALL_COUPLINGS.items():
        made.rzz(2 * known.GAMMA * coupling, i, j)
    made.rx(2 * known.BETA, range(known.QUBITS))
    return made


def answer() -> list[float]:
    """Return the mean energy, and the probabilities of all states after transpiling."""
    from qiskit import transpile
    from qiskit.primitives import StatevectorEstimator
    from qiskit.quantum_info import SparsePauliOp, Statevector

    terms = [("Z", [k], float(field)) for k, field in enumerate(known.SMALL_FIELDS)]
    terms += [("ZZ", [i, j], float(v)) for (i, j), v in known.SMALL_COUPLINGS.items()]
    energy = SparsePauliOp.from_sparse_list(terms, num_qubits=known.QUBITS)
    made = circuit()
    lowered = transpile(
        made, basis_gates=["rz", "sx", "cx"], optimization_level=2, seed_transpiler=1
    )
    mean = StatevectorEstimator().run([(made, energy)]).result()[0].data.evs
    return [float(mean), *Statevector(lowered).probabilities().tolist()]


def expected() -> list[float]:
    """Return the same from matrices."""
    return [known.qaoa_energy(), *known.qaoa_probabilities().tolist()]


CHECK = Check(
    __name__,
    title="a QAOA circuit, transpiled",
    group="gate model",
    imports=("qiskit", "qiskit.primitives", "qiskit.quantum_info"),
    distributions=("qiskit",),
    source="the circuit as matrices in numpy",
    extra="qiskit",
)
