"""Programs in gates that every device and simulator has.

Control modifiers are not taken by managed Braket devices, and Braket's local simulator (1.41)
silently drops some of them: a controlled rotation whose control lies inside the register writes
into a copy. So many controls are taken apart here: A. Barenco et al., "Elementary gates for
quantum computation", Physical Review A 52 (1995) 3457, lemmas 7.2, 7.3 and 7.5. The number of
gates grows with the square of the number of controls, and no qubit is added.
"""

from __future__ import annotations

import math

from qrobot.backends.gates.program import Gate, Program

__all__ = ["lowered"]


def lowered(program: Program) -> Program:
    """Return the same circuit with at most these controls, all on 1.

    One control on ``x`` (CNOT), ``phase`` and ``swap``, two on ``x`` (Toffoli), none elsewhere.
    """
    made = Program(program.labels)
    for gate in program.gates:
        zeros = [
            Gate("x", (q,))
            for q, value in zip(gate.controls, gate.control_values, strict=True)
            if not value
        ]
        made.extend([*zeros, *_plain(gate), *zeros])
    return made


def _plain(gate: Gate) -> list[Gate]:
    """Return one gate taken apart; its controls count as being on 1."""
    controls, (*others, target) = gate.controls, gate.targets
    if not controls:
        return [gate]
    if gate.name == "x":
        return _flip(controls, target)
    if gate.name == "phase":
        return _turn(controls, target, gate.angle)
    if gate.name == "swap":
        (other,) = others
        if len(controls) == 1:
            return [Gate("swap", (other, target), controls=controls)]
        between = Gate("x", (other,), controls=(target,))
        return [between, *_flip((*controls, other), target), between]
    # A rotation by half, a flip, half back, a flip: nothing without the flips, all with them.
    if gate.name == "h":
        raise ValueError("a controlled h has no plain form here")
    name, around = (gate.name, []) if gate.name != "rx" else ("rz", [Gate("h", (target,))])
    flip = _flip(controls, target)
    forth, back = (Gate(name, (target,), sign * gate.angle / 2) for sign in (1, -1))
    return [*around, forth, *flip, back, *flip, *around]


def _turn(controls: tuple[int, ...], target: int, angle: float) -> list[Gate]:
    """Return a controlled phase: lemma 7.5, the target lent to the inner flips."""
    gates: list[Gate] = []
    while len(controls) > 1:
        *rest, last = controls
        flip = _flip(tuple(rest), last, lent=(target,))
        gates += [_phase(last, target, angle / 2), *flip, _phase(last, target, -angle / 2), *flip]
        controls, angle = tuple(rest), angle / 2
    return [*gates, _phase(controls[0], target, angle)]


def _phase(control: int, target: int, angle: float) -> Gate:
    return Gate("phase", (target,), angle, (control,))


def _flip(controls: tuple[int, ...], target: int, lent: tuple[int, ...] = ()) -> list[Gate]:
    """Return a controlled flip; `lent` qubits may be in any state and get it back."""
    count = len(controls)
    if count <= 2:
        return [Gate("x", (target,), controls=controls)]
    if not lent:  # nothing to lend: as a phase between two changes of basis
        h = Gate("h", (target,))
        return [h, *_turn(controls, target, math.pi), h]
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
