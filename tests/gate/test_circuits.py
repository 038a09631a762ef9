"""Circuits against the subspace: same amplitudes, in numpy, Qiskit and Braket."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from oracles import paper_shaped

from qrobot.backends.gate.circuit import (
    Circuit,
    Gate,
    circuit_facts,
    elementary,
    qasm,
)
from qrobot.backends.gate.constrained import (
    export_circuit,
    subspace_circuit,
    two_level,
)
from qrobot.backends.gate.feasible import FeasibleSet, feasible_set
from qrobot.backends.gate.state.general import state
from qrobot.backends.gate.state.subspace import SubspaceQAOA
from qrobot.errors import InputError
from qrobot.models import build_model

GAMMAS, BETAS = np.array([0.03, 0.07]), np.array([-0.8, 0.4])

CASES = [(2, 1), (3, 1), (2, 2)]
MIXERS = ["swap", "swap-all", "grover"]


def within(circuit: Circuit, plans: FeasibleSet, slack: str | None = None) -> np.ndarray:
    """Return the circuit's amplitudes on the plans."""
    return state(circuit)[[circuit.index(plans.assignment(k, slack)) for k in range(plans.size)]]


def fidelity(a: np.ndarray, b: np.ndarray) -> float:
    return abs(np.vdot(a, b)) ** 2


@pytest.mark.parametrize("mixer", MIXERS)
@pytest.mark.parametrize("case", CASES, ids=lambda c: f"n{c[0]}K{c[1]}")
def test_the_circuit_is_the_subspace(case: tuple[int, int], mixer: str) -> None:
    plans = feasible_set(paper_shaped(*case, 0))
    circuit = subspace_circuit(plans, mixer, GAMMAS, BETAS)
    expected = SubspaceQAOA.of(plans, mixer).state(GAMMAS, BETAS)
    found = within(circuit, plans)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert fidelity(found, expected) > 1 - 1e-9


@pytest.mark.parametrize("mixer", MIXERS)
@pytest.mark.parametrize(("case", "slack"), [((3, 1), "paper"), ((2, 2), "exact")])
def test_with_slack_the_qubits_are_the_models(
    case: tuple[int, int], slack: str, mixer: str
) -> None:
    instance = paper_shaped(*case, 0)
    plans = feasible_set(instance)
    circuit = subspace_circuit(plans, mixer, GAMMAS[:1], BETAS[:1], slack=slack)
    model = build_model(instance, encoding="reduced", slack=slack)
    assert [label for label in circuit.labels if label != "ancilla"] == model.variables
    expected = SubspaceQAOA.of(plans, mixer).state(GAMMAS[:1], BETAS[:1])
    assert fidelity(within(circuit, plans, slack), expected) > 1 - 1e-9


@pytest.mark.parametrize("name", ["rx", "ry"])
@pytest.mark.parametrize(("a", "b"), [(0b000, 0b111), (0b101, 0b010), (0b110, 0b010)])
def test_two_levels_turn_alone(a: int, b: int, name: str) -> None:
    bits = [{q: one >> q & 1 for q in range(3)} for one in (a, b)]
    angle = 0.7
    c, s = math.cos(angle / 2), math.sin(angle / 2)
    for start in range(8):
        gates = [Gate("x", (q,)) for q in range(3) if start >> q & 1]
        circuit = Circuit(3, (*gates, *two_level(*bits, name, angle)))
        expected = np.zeros(8, dtype=complex)
        expected[start] = 1.0
        if start in (a, b):
            other, sign = (b, 1) if start == a else (a, -1)
            expected[start], expected[other] = c, (sign * s if name == "ry" else -1j * s)
        np.testing.assert_allclose(state(circuit), expected, atol=1e-12)


def test_mixers_without_a_circuit_are_refused() -> None:
    with pytest.raises(InputError, match="not a mixer"):
        subspace_circuit(feasible_set(paper_shaped(2, 1, 0)), "blender", [0.1], [0.1])


def circuits(layers: int = 2) -> list[Circuit]:
    return [
        subspace_circuit(
            feasible_set(paper_shaped(*case, 0)), mixer, GAMMAS[:layers], BETAS[:layers]
        )
        for case in CASES
        for mixer in ("swap", "grover")
    ]


def test_qiskit_has_the_same_state() -> None:
    info = pytest.importorskip("qiskit.quantum_info")
    from qrobot.backends.qiskit.sampler import circuit_of

    for circuit in circuits():
        found = info.Statevector(circuit_of(circuit)).data
        np.testing.assert_allclose(found, state(circuit), atol=1e-9)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_braket_has_the_same_state() -> None:
    devices = pytest.importorskip("braket.devices")
    from qrobot.backends.braket.sampler import circuit_of

    for circuit in circuits(layers=1):
        made = circuit_of(circuit)
        made.state_vector()
        found = devices.LocalSimulator().run(made, shots=0).result().values[0]
        shaped = np.asarray(found).reshape((2,) * circuit.qubits)
        ours = shaped.transpose(range(circuit.qubits)[::-1]).reshape(-1)
        np.testing.assert_allclose(ours, state(circuit), atol=1e-9)


def test_gates_of_one_and_two_qubits_do_the_same() -> None:
    for circuit in circuits(layers=1):  # a second has the same gates with other angles
        found = elementary(circuit)
        assert all(len(gate.controls) + len(gate.qubits) <= 2 for gate in found.gates)
        np.testing.assert_allclose(state(found), state(circuit), atol=1e-9)


def test_qiskit_reads_the_written_circuit() -> None:
    pytest.importorskip("qiskit_qasm3_import")
    from qiskit import qasm3
    from qiskit.quantum_info import Statevector

    for circuit in circuits(layers=1):
        if circuit_facts(circuit).gates > 2000:
            continue  # Qiskit takes a second for a thousand statements
        read = qasm3.loads(qasm(circuit, "a comment\nof two lines"))
        facts = circuit_facts(circuit)
        assert read.num_clbits == read.num_qubits == facts.qubits
        read.remove_final_measurements()
        assert sum(read.count_ops().values()) == facts.gates
        assert read.num_nonlocal_gates() == facts.two_qubit_gates
        assert read.depth() == facts.depth
        np.testing.assert_allclose(Statevector(read).data, state(circuit), atol=1e-9)


def test_an_open_parameter_is_not_written() -> None:
    with pytest.raises(ValueError, match="open parameters"):
        qasm(Circuit(1, (Gate("rx", (0,), 0),), 1))


@pytest.mark.parametrize(
    ("case", "mixer"),
    [((3, 1), "swap"), ((3, 1), "swap-all"), ((2, 1), "grover"), ((1, 2), "swap")],
)
def test_measuring_an_exported_circuit_gives_plans_only(
    tmp_path: Path, case: tuple[int, int], mixer: str
) -> None:
    pytest.importorskip("qiskit_qasm3_import")
    from qiskit import qasm3
    from qiskit.quantum_info import Statevector

    instance = paper_shaped(*case, 0)
    report = export_circuit(instance, tmp_path / "plan.qasm", mixer, layers=1)
    read = qasm3.load(str(tmp_path / "plan.qasm"))
    read.remove_final_measurements()
    probabilities = np.abs(Statevector(read).data) ** 2
    plans = feasible_set(instance)
    labels = subspace_circuit(plans, mixer, [0.1], [0.1]).labels
    at = {label: k for k, label in enumerate(labels)}
    indices = [sum(1 << at[x] for x in plans.assignment(k)) for k in range(plans.size)]
    assert probabilities[indices].sum() == pytest.approx(1.0, abs=1e-9)
    best = [indices[k] for k in plans.optimal]
    assert probabilities[best].sum() == pytest.approx(report["optimum_probability"], abs=1e-9)
    assert report["optimum_probability"] > report["random_plan_probability"]


def test_a_circuit_needs_a_mixer_and_layers(tmp_path: Path) -> None:
    instance = paper_shaped(2, 1, 0)
    with pytest.raises(InputError, match="'blender' is not a mixer"):
        export_circuit(instance, tmp_path / "x.qasm", "blender")
    with pytest.raises(InputError, match="0 layers"):
        export_circuit(instance, tmp_path / "x.qasm", layers=0)
