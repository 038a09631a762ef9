"""Circuits against the subspace: same amplitudes, in numpy, Qiskit and Braket."""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracles import paper_shaped

from qrobot.backends.gates.circuits import one_hot_program, subspace_program
from qrobot.backends.gates.circuits_braket import to_braket
from qrobot.backends.gates.circuits_qiskit import to_qiskit
from qrobot.backends.gates.feasible import FeasibleSet, feasible_set, x_label
from qrobot.backends.gates.program import Gate, Program, two_level
from qrobot.backends.gates.subspace import SubspaceQAOA, one_hot
from qrobot.errors import InputError
from qrobot.models import build_model

GAMMAS, BETAS = np.array([0.03, 0.07]), np.array([-0.8, 0.4])

CASES = [(2, 1), (3, 1), (2, 2)]
MIXERS = ["swap", "swap-all", "grover"]


def within(program: Program, plans: FeasibleSet, slack: str | None = None) -> np.ndarray:
    """Return the circuit's amplitudes on the plans."""
    return program.state()[[program.index(plans.assignment(k, slack)) for k in range(plans.size)]]


def fidelity(a: np.ndarray, b: np.ndarray) -> float:
    return abs(np.vdot(a, b)) ** 2


@pytest.mark.parametrize("mixer", MIXERS)
@pytest.mark.parametrize("case", CASES, ids=lambda c: f"n{c[0]}K{c[1]}")
def test_the_circuit_is_the_subspace(case: tuple[int, int], mixer: str) -> None:
    plans = feasible_set(paper_shaped(*case, 0))
    program = subspace_program(plans, mixer, GAMMAS, BETAS)
    expected = SubspaceQAOA.of(plans, mixer).state(GAMMAS, BETAS)
    found = within(program, plans)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert fidelity(found, expected) > 1 - 1e-9


@pytest.mark.parametrize("mixer", MIXERS)
@pytest.mark.parametrize(("case", "slack"), [((3, 1), "paper"), ((2, 2), "exact")])
def test_with_slack_the_qubits_are_the_models(
    case: tuple[int, int], slack: str, mixer: str
) -> None:
    instance = paper_shaped(*case, 0)
    plans = feasible_set(instance)
    program = subspace_program(plans, mixer, GAMMAS[:1], BETAS[:1], slack=slack)
    model = build_model(instance, encoding="reduced", slack=slack)
    assert [label for label in program.labels if label != "ancilla"] == model.variables
    expected = SubspaceQAOA.of(plans, mixer).state(GAMMAS[:1], BETAS[:1])
    assert fidelity(within(program, plans, slack), expected) > 1 - 1e-9


@pytest.mark.parametrize("n", [2, 3])
def test_one_hot_circuit(n: int) -> None:
    distances = paper_shaped(n, 1, 1).distances
    program = one_hot_program(distances, 20.0, GAMMAS, BETAS)
    stops = np.indices((n,) * n).reshape(n, -1)
    indices = [
        program.index(x_label(t + 1, int(stops[t, k]) + 1) for t in range(n)) for k in range(n**n)
    ]
    expected = one_hot(distances, 20.0)[0].state(GAMMAS, BETAS)
    np.testing.assert_allclose(program.state()[indices], expected, atol=1e-12)


@pytest.mark.parametrize("name", ["rx", "ry"])
@pytest.mark.parametrize(("a", "b"), [(0b000, 0b111), (0b101, 0b010), (0b110, 0b010)])
def test_two_levels_turn_alone(a: int, b: int, name: str) -> None:
    bits = [{q: one >> q & 1 for q in range(3)} for one in (a, b)]
    angle = 0.7
    c, s = math.cos(angle / 2), math.sin(angle / 2)
    for start in range(8):
        program = Program(("p", "q", "r"))
        program.extend(Gate("x", (q,)) for q in range(3) if start >> q & 1)
        program.extend(two_level(*bits, name, angle))
        expected = np.zeros(8, dtype=complex)
        expected[start] = 1.0
        if start in (a, b):
            other, sign = (b, 1) if start == a else (a, -1)
            expected[start], expected[other] = c, (sign * s if name == "ry" else -1j * s)
        np.testing.assert_allclose(program.state(), expected, atol=1e-12)


def test_mixers_without_a_circuit_are_refused() -> None:
    with pytest.raises(InputError, match="no mixer"):
        subspace_program(feasible_set(paper_shaped(2, 1, 0)), "blender", [0.1], [0.1])


def programs(layers: int = 2) -> list[Program]:
    found = [
        subspace_program(
            feasible_set(paper_shaped(*case, 0)), mixer, GAMMAS[:layers], BETAS[:layers]
        )
        for case in CASES
        for mixer in ("swap", "grover")
    ]
    return [*found, one_hot_program(paper_shaped(2, 1, 1).distances, 20.0, GAMMAS, BETAS)]


def test_qiskit_has_the_same_state() -> None:
    info = pytest.importorskip("qiskit.quantum_info")
    for program in programs():
        state = info.Statevector(to_qiskit(program)).data
        np.testing.assert_allclose(state, program.state(), atol=1e-9)
    assert to_qiskit(programs()[0], measure=True).num_clbits == programs()[0].qubits


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_braket_has_the_same_state() -> None:
    devices = pytest.importorskip("braket.devices")
    for program in programs(layers=1):
        circuit = to_braket(program)
        circuit.state_vector()
        state = devices.LocalSimulator().run(circuit, shots=0).result().values[0]
        shaped = np.asarray(state).reshape((2,) * program.qubits)
        ours = shaped.transpose(range(program.qubits)[::-1]).reshape(-1)
        np.testing.assert_allclose(ours, program.state(), atol=1e-9)
