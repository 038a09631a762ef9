"""IBM Runtime in local mode: a Bell state on a fake, noisy backend."""

import numpy as np

from qrobot.health.check import Check

SHOTS = 8000

MISREAD = ((0.0158, 0.0548), (0.0122, 0.0316))
"""How often qubits 0 and 1 of *ibmq_manila* were read as 1 when they were 0, and as 0 when 1."""


def answer() -> list[float]:
    """Return whether shots were lost, and the parts of 00 and 11."""
    from qiskit import QuantumCircuit
    from qiskit.transpiler import generate_preset_pass_manager
    from qiskit_ibm_runtime import SamplerV2
    from qiskit_ibm_runtime.fake_provider import FakeManilaV2

    backend = FakeManilaV2()
    bell = QuantumCircuit(2)
    bell.h(0)
    bell.cx(0, 1)
    bell.measure_all()
    lowered = generate_preset_pass_manager(
        optimization_level=1, backend=backend, seed_transpiler=1, initial_layout=[0, 1]
    ).run(bell)
    sampler = SamplerV2(mode=backend, options={"simulator": {"seed_simulator": 1}})
    counts = sampler.run([lowered], shots=SHOTS).result()[0].data.meas.get_counts()
    return [float(sum(counts.values()) != SHOTS), *(counts.get(s, 0) / SHOTS for s in ("00", "11"))]


def expected() -> list[float]:
    """Return no loss, and a Bell state as it is read by qubits that err."""
    first, second = (np.array([[1 - up, down], [up, 1 - down]]) for up, down in MISREAD)
    parts = np.kron(second, first) @ [0.5, 0.0, 0.0, 0.5]
    return [0.0, float(parts[0]), float(parts[3])]


CHECK = Check(
    __name__,
    title="a Bell state on a fake backend",
    group="gate model",
    imports=("qiskit_ibm_runtime", "qiskit_ibm_runtime.fake_provider"),
    distributions=("qiskit-ibm-runtime", "qiskit-aer", "qiskit"),
    source="a Bell state and the qubits' published errors of reading, in numpy",
    tolerance=0.03,  # 0.01 for the gates' errors, and 3.5 standard deviations of the shots
    extra="ibm",
)
