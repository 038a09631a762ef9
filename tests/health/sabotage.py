"""How to break each stack a little: what a check must notice.

Every entry names something of the SDK (not of the check) and how to spoil it.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np

Spoil = Callable[[Any], Any]


def after(change: Callable[[Any], Any]) -> Spoil:
    """Spoil a function's result."""

    def spoil(original: Any) -> Any:
        @functools.wraps(original, updated=())
        def spoiled(*args: Any, **options: Any) -> Any:
            return change(original(*args, **options))

        return spoiled

    return spoil


def worse(found: Any) -> Any:
    """Raise the energies of a sample set by a thousandth."""
    found.record.energy = found.record.energy + 1e-3
    return found


def turned(original: Any) -> Any:
    """Make a PennyLane rotation half a percent too large."""
    return lambda angle, *rest, **options: original(angle * 1.005, *rest, **options)


def turned_method(original: Any) -> Any:
    """Make a Braket rotation half a percent too large."""
    return lambda self, qubit, angle: original(self, qubit, angle * 1.005)


def steeper(original: Any) -> Any:
    """Make a gradient half a percent too large."""
    return lambda *args, **options: lambda x: original(*args, **options)(x) * 1.005


def without_a_chain(found: dict[Any, Any]) -> dict[Any, Any]:
    return found | {0: []}


def without_an_edge(graph: Any) -> Any:
    graph.remove_edge(*next(iter(graph.edges)))
    return graph


def other_probabilities(data: dict[str, Any]) -> dict[str, Any]:
    if "probabilities" in data:
        return data | {"probabilities": data["probabilities"] * 1.001}
    return data


def one_more(found: Any) -> Any:
    found._fval += 1
    return found


def higher(found: Any) -> Any:
    found.eigenvalue += 1e-3
    return found


def flipped_first(original: Any) -> Any:
    """Begin every circuit of IBM's sampler with all qubits flipped."""

    def run(self: Any, pubs: Any, **options: Any) -> Any:
        changed = []
        for circuit in pubs:
            other = circuit.copy_empty_like()
            other.x(range(circuit.num_qubits))
            changed.append(other.compose(circuit))
        return original(self, changed, **options)

    return run


def longer(result: Any) -> Any:
    plan = dataclasses.replace(result.plan, distance=result.plan.distance + 1e-3)
    return dataclasses.replace(result, plan=plan)


def with_a_constant(program: Any) -> Any:
    program.objective.constant += 1e-3
    return program


def stronger(original: Any) -> Any:
    """Make every value of a Braket time series a fifth larger."""
    return lambda self, time, value: original(self, time, value * 1.2)


def with_other_energies(found: dict[str, Any]) -> dict[str, Any]:
    return found | {"energies": [energy + 1e-3 for energy in found["energies"]]}


def with_worse_samples(state: Any) -> Any:
    return state.updated(samples=worse(state.samples))


def with_one_more(original: Any) -> Any:
    """Minimize something that is one too much."""
    return lambda self, symbol: original(self, symbol + self.constant(1))


def compiled_wrong(original: Any) -> Any:
    def compiled(function: Any) -> Any:
        return after(lambda sums: tuple(total * 1.001 for total in sums))(original(function))

    return compiled


class Farther:
    """A result of PyVRP that tells one metre too much."""

    def __init__(self, result: Any) -> None:
        self.best, self.result = self, result

    def distance(self) -> int:
        return int(self.result.best.distance()) + 1

    def routes(self) -> Any:
        return self.result.best.routes()


def one_above(original: property) -> property:
    assert original.fget is not None
    return property(after(lambda value: value + 1)(original.fget))


def without_a_cell(notebook: Any) -> Any:
    del notebook.cells[-1]
    return notebook


def with_another_value(notebook: Any) -> Any:
    notebook.cells[-1].outputs[0]["data"]["text/plain"] = "2521"
    return notebook


def upside_down(model: Any) -> Any:
    """Turn every sign of a model."""
    model.scale(-1)
    return model


def all_up(found: Any) -> Any:
    found.record.sample[:] = 1
    return found


def put_back_up(state: Any) -> Any:
    """Forget what a part of a workflow found."""
    samples = state.samples.from_samples_bqm(
        dict.fromkeys(state.problem.variables, 1), state.problem
    )
    return state.updated(samples=samples)


def dead(_: Any) -> Any:
    """Sample a part of a workflow by saying yes."""

    def sample(self: Any, state: Any, **options: Any) -> Any:
        part = state.subproblem
        up = state.samples.from_samples_bqm(dict.fromkeys(part.variables, 1), part)
        return state.updated(subsamples=up)

    return sample


def farther_apart(original: Any) -> Any:
    """Make the atoms' interaction a tenth too large."""
    return lambda *args, **options: original(
        *args, **options | {"rydberg_interaction_coef": 1.1 * 5.42e-24}
    )


def with_one_shot_less(counts: dict[str, int]) -> dict[str, int]:
    return counts | {"00": counts["00"] - 1}


def with_moved_couplers(graph: Any) -> Any:
    """Let the first couplers of the list lead to other qubits; their number stays."""
    for start, end in list(graph.edges)[:5]:
        other = next(q for q in graph if q != start and not graph.has_edge(start, q))
        graph.remove_edge(start, end)
        graph.add_edge(start, other)
    return graph


SABOTAGE: dict[str, tuple[str, Spoil]] = {
    # check: (module:attribute.path, how)
    "numpy": ("numpy.linalg:eigvalsh", after(lambda values: values * 1.001)),
    "scipy": ("scipy.linalg:expm", after(lambda matrix: matrix * 1.001)),
    "dimod": ("dimod:BinaryQuadraticModel.energies", after(lambda values: values + 1e-3)),
    "neal": ("neal:SimulatedAnnealingSampler.sample", after(worse)),
    "tabu": ("dwave.samplers:TabuSampler.sample", after(worse)),
    "minorminer": ("minorminer:find_embedding", after(without_a_chain)),
    "dwave-system": ("dwave.system:EmbeddingComposite.sample", after(worse)),
    "dwave-networkx": ("dwave_networkx:pegasus_graph", after(without_an_edge)),
    "qiskit": ("qiskit.quantum_info:Statevector.probabilities", after(lambda p: p * 1.001)),
    "aer": ("qiskit.result:Result.data", after(other_probabilities)),
    "rustworkx": ("rustworkx:floyd_warshall_numpy", after(lambda ways: ways + 1)),
    "qiskit-optimization": (
        "qiskit_optimization.algorithms:MinimumEigenOptimizer.solve",
        after(one_more),
    ),
    "qiskit-algorithms": ("qiskit_algorithms:VQE.compute_minimum_eigenvalue", after(higher)),
    "ibm-runtime": ("qiskit_ibm_runtime:SamplerV2.run", flipped_first),
    "docplex": ("docplex.mp.solution:SolveSolution.get_value", after(lambda value: value + 1)),
    "pennylane": ("pennylane:RX", turned),
    "lightning": ("pennylane:grad", steeper),
    "autograd": ("autograd:grad", steeper),
    "braket": ("braket.circuits:Circuit.rx", turned_method),
    "pennylane-braket": ("pennylane:RX", turned),
    "qrobot": ("qrobot:solve", after(longer)),
    "qiskit-finance": (
        "qiskit_finance.applications.optimization:PortfolioOptimization.to_quadratic_program",
        after(with_a_constant),
    ),
    "qiskit-nature": (
        "qiskit_nature.second_q.mappers:JordanWignerMapper.map",
        after(lambda operator: operator * 1.001),
    ),
    "qiskit-machine-learning": (
        "qiskit_machine_learning.kernels:FidelityStatevectorKernel.evaluate",
        after(lambda kernel: kernel * 1.001),
    ),
    "braket-ahs": ("braket.timings:TimeSeries.put", stronger),
    "numba": ("numba:njit", compiled_wrong),
    "searches": ("qrobot.warehouse.kernels:tour_length", after(lambda length: length * 1.001)),
    "dwave-cloud": ("dwave.cloud.coders:decode_qp_numpy", after(with_other_energies)),
    "dwave-hybrid": ("hybrid:ArgMin.next", after(with_worse_samples)),
    "dwave-optimization": ("dwave.optimization:Model.minimize", with_one_more),
    "pyvrp": ("pyvrp:Model.solve", after(Farther)),
    "ortools": ("ortools.sat.python.cp_model:CpSolver.objective_value", one_above),
    "matplotlib": (
        "matplotlib.backends.backend_agg:FigureCanvasAgg.buffer_rgba",
        after(lambda pixels: np.asarray(pixels) // 2),
    ),
    "tensorflow": ("tensorflow:GradientTape.gradient", after(lambda slope: slope * 1.001)),
    "litert": (
        "ai_edge_litert.interpreter:Interpreter.get_tensor",
        after(lambda values: values * 1.001),
    ),
    "pyscf": ("pyscf.gto:Mole.energy_nuc", after(lambda energy: energy * 1.001)),
    "h5py": ("h5py:Dataset.__getitem__", after(lambda values: values * (1 + 1e-12))),
    "jupyter": ("nbclient:NotebookClient.execute", after(with_another_value)),
    "jupytext": ("jupytext:reads", after(without_a_cell)),
}

ALSO: tuple[tuple[str, str, Spoil], ...] = (
    # Faults that these checks once let through.
    ("dwave-system", "dwave.embedding:EmbeddedStructure.embed_bqm", after(upside_down)),
    ("dwave-system", "dwave.system.testing:MockDWaveSampler.sample", after(all_up)),
    ("dwave-hybrid", "hybrid:SplatComposer.next", after(put_back_up)),
    ("dwave-hybrid", "hybrid:TabuSubproblemSampler.next", dead),
    (
        "braket-ahs",
        "braket.analog_hamiltonian_simulator.rydberg.rydberg_simulator:RydbergAtomSimulator.run",
        farther_apart,
    ),
    ("ibm-runtime", "qiskit:QuantumCircuit.h", lambda _: lambda self, qubit: self.ry(1.46, qubit)),
    ("ibm-runtime", "qiskit.primitives:BitArray.get_counts", after(with_one_shot_less)),
    *(
        ("dwave-networkx", f"dwave_networkx:{graph}_graph", after(with_moved_couplers))
        for graph in ("chimera", "zephyr", "pegasus")
    ),
    (
        "jupytext",
        "jupytext:writes",
        after(lambda text: "\n".join(reversed(text.splitlines()))),
    ),
)
