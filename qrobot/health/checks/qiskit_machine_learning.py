"""Qiskit Machine Learning: a kernel by state vectors and by circuits."""

import math

import numpy as np

from qrobot.health.check import Check

POINTS = ((0.1, 0.2), (0.6, -0.3), (-0.4, 0.9))


def answer() -> list[float]:
    """Return the kernel matrix of a product map, by state vectors and by circuits."""
    from qiskit.circuit.library import z_feature_map
    from qiskit.primitives import StatevectorSampler
    from qiskit_machine_learning import kernels
    from qiskit_machine_learning.state_fidelities import ComputeUncompute

    points = np.array(POINTS)
    product = z_feature_map(2, reps=1)
    by_states = kernels.FidelityStatevectorKernel(feature_map=product).evaluate(points)
    sampler = StatevectorSampler(default_shots=64, seed=1)
    by_shots = kernels.FidelityQuantumKernel(
        feature_map=product,
        fidelity=ComputeUncompute(sampler),
        evaluate_duplicates="all",
    ).evaluate(points)
    # What shots give of two equal points is sure; of others it is not.
    return [*by_states.ravel().tolist(), *by_shots.diagonal().tolist()]


def expected() -> list[float]:
    """Return products of ``cos(x - y)**2``: H, then a phase of 2 x, on each qubit."""
    matrix = [
        math.prod(math.cos(a - b) ** 2 for a, b in zip(x, y, strict=True))
        for x in POINTS
        for y in POINTS
    ]
    return [*matrix, *(1.0 for _ in POINTS)]


CHECK = Check(
    __name__,
    title="fidelity kernels",
    group="gate model",
    imports=("qiskit_machine_learning.kernels",),
    distributions=("qiskit-machine-learning", "qiskit"),
    source="closed form: products of cos(x - y)**2",
    extra="science",
)
