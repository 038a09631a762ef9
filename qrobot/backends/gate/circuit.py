"""Circuits as plain data: one description that every SDK's translator reads.

Rotations are exp(-i angle P / 2) with P one of X, Y, Z or ZZ; ``phase`` is diag(1, exp(i angle)).
An angle is fixed, or ``scale * parameters[slot]``: several gates may share a parameter. Qubit k is
variable k, and bit k of a state's index.

`lowered` and `elementary` write the same circuit in gates that every device and simulator has.
Control modifiers are not taken by managed Braket devices, and Braket's local simulator (1.41)
silently drops some of them: a controlled rotation whose control lies inside the register writes
into a copy. So many controls are taken apart here: A. Barenco et al., "Elementary gates for
quantum computation", Physical Review A 52 (1995) 3457, lemmas 7.2, 7.3 and 7.5. The number of
gates grows with the square of the number of controls, and no qubit is added.

`qasm` writes a circuit as OpenQASM 3 (A. Cross et al., "OpenQASM 3", ACM Transactions on Quantum
Computing 3 (2022) 12), in gates of its standard library alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qrobot._arrays import Floats

__all__ = [
    "TURNING",
    "Circuit",
    "CircuitFacts",
    "Gate",
    "circuit_facts",
    "elementary",
    "lowered",
    "qasm",
]


TURNING = ("rx", "ry", "rz", "rzz", "phase")
"""Gates that take an angle; ``h``, ``x``, ``cz`` and ``swap`` take none."""


@dataclass(frozen=True, slots=True)
class Gate:
    """One gate.

    Parameters
    ----------
    name
        One of `TURNING`, or ``h``, ``x``, ``cz``, ``swap``.
    qubits
        What it acts on: two for ``rzz``, ``cz`` and ``swap``, else one.
    slot, scale
        Of an angle that is searched: which parameter it turns by, and times what.
    angle
        Of a turn that is fixed (``slot`` is -1), in radians.
    controls, values
        The gate acts where each control qubit has its value; no values: all 1.
    """

    name: str
    qubits: tuple[int, ...]
    slot: int = -1
    scale: float = 1.0
    angle: float = 0.0
    controls: tuple[int, ...] = ()
    values: tuple[int, ...] = ()

    @property
    def control_values(self) -> tuple[int, ...]:
        """Value of each control qubit."""
        return self.values or (1,) * len(self.controls)

    def inverse(self) -> Gate:
        """Return the gate that undoes this one."""
        return self.times(-1.0)

    def times(self, factor: float) -> Gate:
        """Return the same gate with its angle times a factor."""
        return replace(self, angle=self.angle * factor, scale=self.scale * factor)


@dataclass(frozen=True, eq=False)
class Circuit:
    """Gates in sequence on qubits that start in |0>.

    Parameters
    ----------
    qubits
        Number of qubits.
    gates
        In sequence.
    size
        Number of parameters.
    labels
        What each qubit stands for: a variable of the model, or ``ancilla``; may be left out.
    """

    qubits: int
    gates: tuple[Gate, ...]
    size: int = 0
    labels: tuple[str, ...] = ()

    @cached_property
    def rotations(self) -> tuple[Gate, ...]:
        """The gates whose angle is searched, in sequence: angle k belongs to rotation k."""
        return tuple(gate for gate in self.gates if gate.slot >= 0)

    @cached_property
    def _map(self) -> tuple[npt.NDArray[np.intp], Floats]:
        slots = np.array([gate.slot for gate in self.rotations], dtype=np.intp)
        return slots, np.array([gate.scale for gate in self.rotations], dtype=np.float64)

    def angles(self, parameters: Floats) -> Floats:
        """Return the angle of each rotation, shape (rotations,)."""
        slots, scales = self._map
        found: Floats = parameters[slots] * scales
        return found

    def turned(self, angles: Iterable[float] = ()) -> Iterator[tuple[Gate, float]]:
        """Yield each gate with its angle (0 for those that have none)."""
        left = iter(angles)
        for gate in self.gates:
            yield gate, next(left) if gate.slot >= 0 else gate.angle

    def pull_back(self, by_angle: Floats) -> Floats:
        """Return derivatives by parameter from derivatives by angle, shape (size,)."""
        slots, scales = self._map
        found = np.zeros(self.size)
        np.add.at(found, slots, by_angle * scales)
        return found

    def index(self, ones: Iterable[str]) -> int:
        """Return the index of the basis state in which exactly these labels are 1."""
        at = {label: k for k, label in enumerate(self.labels)}
        return sum(1 << at[label] for label in ones)


def lowered(circuit: Circuit) -> Circuit:
    """Return the same circuit with at most these controls, all on 1.

    One control on ``x`` (CNOT), ``phase`` and ``swap``, two on ``x`` (Toffoli), none elsewhere.
    """
    made: list[Gate] = []
    for gate in circuit.gates:
        zeros = [
            Gate("x", (q,))
            for q, value in zip(gate.controls, gate.control_values, strict=True)
            if not value
        ]
        made += [*zeros, *_without_controls(gate), *zeros]
    return replace(circuit, gates=tuple(made))


def elementary(circuit: Circuit) -> Circuit:
    """Return the same circuit with gates of one and two qubits alone.

    What is left: gates without controls, and ``x`` (CNOT) and ``phase`` with one control.
    """
    made: list[Gate] = []
    for gate in lowered(circuit).gates:
        if gate.name == "swap" and gate.controls:
            first, second = gate.qubits
            between = Gate("x", (first,), controls=(second,))
            made += [between, *_toffoli((*gate.controls, first), second), between]
        elif len(gate.controls) == 2:
            made += _toffoli(gate.controls, gate.qubits[0])
        else:
            made.append(gate)
    return replace(circuit, gates=tuple(made))


def _toffoli(controls: Sequence[int], target: int) -> list[Gate]:
    """Return a flip with two controls as six CNOTs and eighths of a turn (Barenco et al., 6)."""
    a, b = controls

    def flip(control: int, to: int) -> Gate:
        return Gate("x", (to,), controls=(control,))

    def turn(qubit: int, sign: int = 1) -> Gate:
        return Gate("phase", (qubit,), angle=sign * math.pi / 4)

    h = Gate("h", (target,))
    return [
        *(h, flip(b, target), turn(target, -1), flip(a, target), turn(target)),
        *(flip(b, target), turn(target, -1), flip(a, target), turn(b), turn(target), h),
        *(flip(a, b), turn(a), turn(b, -1), flip(a, b)),
    ]


def _without_controls(gate: Gate) -> list[Gate]:
    """Return one gate taken apart; its controls count as being on 1."""
    controls, (*others, target) = gate.controls, gate.qubits
    if not controls:
        return [gate]
    if gate.name == "x":
        return _flip(controls, target)
    if gate.name == "phase":
        return _turn(controls, target, replace(gate, controls=(), values=()))
    if gate.name == "swap":
        (other,) = others
        if len(controls) == 1:
            return [Gate("swap", (other, target), controls=controls)]
        between = Gate("x", (other,), controls=(target,))
        return [between, *_flip((*controls, other), target), between]
    # A rotation by half, a flip, half back, a flip: nothing without the flips, all with them.
    if gate.name not in ("rx", "ry", "rz"):
        raise ValueError(f"a controlled {gate.name} has no form here")
    around = [Gate("h", (target,))] if gate.name == "rx" else []
    half = replace(gate, name="rz" if around else gate.name, controls=(), values=()).times(0.5)
    flip = _flip(controls, target)
    return [*around, half, *flip, half.inverse(), *flip, *around]


def _turn(controls: tuple[int, ...], target: int, phase: Gate) -> list[Gate]:
    """Return a controlled phase: lemma 7.5, the target lent to the inner flips."""
    gates: list[Gate] = []
    while len(controls) > 1:
        *rest, last = controls
        flip = _flip(tuple(rest), last, lent=(target,))
        phase = phase.times(0.5)
        half = replace(phase, controls=(last,))
        gates += [half, *flip, half.inverse(), *flip]
        controls = tuple(rest)
    return [*gates, replace(phase, controls=controls)]


def _flip(controls: tuple[int, ...], target: int, lent: tuple[int, ...] = ()) -> list[Gate]:
    """Return a controlled flip; `lent` qubits may be in any state and get it back."""
    count = len(controls)
    if count <= 2:
        return [Gate("x", (target,), controls=controls)]
    if not lent:  # nothing to lend: as a phase between two changes of basis
        h = Gate("h", (target,))
        return [h, *_turn(controls, target, Gate("phase", (target,), angle=math.pi)), h]
    if len(lent) >= count - 2:
        return _ladder(controls, target, lent)
    # Lemma 7.3: two halves over one lent qubit, each lends its own qubits to the other.
    half = -(-count // 2)
    first, second, middle = controls[:half], controls[half:], lent[0]
    up = _flip(first, middle, (*second, target))
    down = _flip((*second, middle), target, first)
    return [*up, *down, *up, *down]


def _ladder(controls: tuple[int, ...], target: int, lent: tuple[int, ...]) -> list[Gate]:
    """Return a flip with a lent qubit a control but two: lemma 7.2, a Toffoli a step."""
    count = len(controls)
    chain = [*lent[: count - 2], target]
    down = [
        Gate("x", (chain[k],), controls=(controls[k + 1], chain[k - 1]))
        for k in range(count - 2, 0, -1)
    ]
    turn = Gate("x", (chain[0],), controls=(controls[0], controls[1]))
    once = [*down, turn, *reversed(down)]
    inner = [*down[1:], turn, *reversed(down[1:])]
    return [*once, *inner]


QASM_NAMES = {"phase": "p"}
QASM_CONTROLLED = {"x": "cx", "phase": "cp"}


@dataclass(frozen=True, slots=True)
class CircuitFacts:
    """What a circuit costs in gates of one and two qubits, before any routing.

    Parameters
    ----------
    qubits
        Number of qubits.
    gates, two_qubit_gates
        How many gates, and how many of them act on two qubits.
    depth
        Layers of gates, each as early as its qubits are free.
    """

    qubits: int
    gates: int
    two_qubit_gates: int
    depth: int


def circuit_facts(circuit: Circuit) -> CircuitFacts:
    """Return what a circuit costs in gates of one and two qubits."""
    free = [0] * circuit.qubits
    gates = elementary(circuit).gates
    for gate in gates:
        touched = (*gate.controls, *gate.qubits)
        layer = 1 + max(free[q] for q in touched)
        for q in touched:
            free[q] = layer
    pairs = sum(len(gate.controls) + len(gate.qubits) == 2 for gate in gates)
    return CircuitFacts(circuit.qubits, len(gates), pairs, max(free, default=0))


def qasm(circuit: Circuit, comment: str = "") -> str:
    """Return a circuit without open parameters as an OpenQASM 3 program that measures every qubit.

    Parameters
    ----------
    circuit
        Its rotations have fixed angles.
    comment
        Lines that stand on top.

    Raises
    ------
    ValueError
        When an angle is still to be searched.
    """
    if circuit.rotations:
        raise ValueError("a circuit with open parameters cannot be written: fix its angles first")
    lines = [f"// {line}" for line in comment.splitlines()]
    lines += ["OPENQASM 3.0;", 'include "stdgates.inc";', ""]
    lines += [f"// q[{k}]: {label}" for k, label in enumerate(circuit.labels)]
    lines += [f"qubit[{circuit.qubits}] q;", f"bit[{circuit.qubits}] c;"]
    lines += [line for gate in elementary(circuit).gates for line in _statements(gate)]
    return "\n".join([*lines, "c = measure q;"]) + "\n"


def _statements(gate: Gate) -> list[str]:
    name = QASM_CONTROLLED[gate.name] if gate.controls else QASM_NAMES.get(gate.name, gate.name)
    qubits = [f"q[{q}]" for q in (*gate.controls, *gate.qubits)]
    if name == "rzz":  # not in the standard library
        flip = f"cx {qubits[0]}, {qubits[1]};"
        return [flip, f"rz({gate.angle!r}) {qubits[1]};", flip]
    angle = f"({float(gate.angle)!r})" if gate.name in TURNING else ""
    return [f"{name}{angle} {', '.join(qubits)};"]
