"""IBM Runtime in local mode: a Bell state on a fake, noisy backend."""

from __future__ import annotations

from qrobot.health.check import Check

SHOTS = 2000


def answer() -> list[float]:
    """Return the part of the shots that came back, and the parts of 00 and 11."""
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
        optimization_level=1, backend=backend, seed_transpiler=1
    ).run(bell)
    sampler = SamplerV2(mode=backend, options={"simulator": {"seed_simulator": 1}})
    counts = sampler.run([lowered], shots=SHOTS).result()[0].data.meas.get_counts()
    return [sum(counts.values()) / SHOTS, *(counts.get(s, 0) / SHOTS for s in ("00", "11"))]


def expected() -> list[float]:
    """Return the noiseless state's."""
    return [1.0, 0.5, 0.5]


CHECK = Check(
    module=__name__,
    title="a Bell state on a fake backend",
    group="gate model",
    imports=("qiskit_ibm_runtime", "qiskit_ibm_runtime.fake_provider"),
    distributions=("qiskit-ibm-runtime", "qiskit-aer", "qiskit"),
    answer=answer,
    expected=expected,
    source="the definition of a Bell state; the tolerance is for the fake's noise",
    tolerance=0.1,
    extra="ibm",
)
