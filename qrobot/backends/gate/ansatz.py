"""Which circuit: QAOA, and two for VQE, with the first parameters of each.

- ``qaoa``: E. Farhi, J. Goldstone and S. Gutmann, arXiv:1411.4028 (2014). Parameters are the
  gammas in units of 1 / spread of the cost, then the betas.
- ``hardware``: layers of RY and chains of CZ, which any device runs without routing
  (A. Kandala et al., Nature 549 (2017) 242).
- ``problem``: QAOA with an angle of its own for each field and each mixer and one a layer for
  all couplings (after R. Herrman et al., Scientific Reports 12 (2022) 6781, who give the
  couplings theirs too). It entangles what the model couples and starts from QAOA's angles.

First angles come from the best single layer, whose expectation is known in closed form for any
number of qubits: A. Ozaeta, W. van Dam and P. L. McMahon, "Expectation values from the single-layer
quantum approximate optimization algorithm on Ising problems", Quantum Science and Technology 7
(2022) 045036. No state is simulated, so the search costs milliseconds at 24 qubits and well under a
second a gamma at 200.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.circuit import Circuit, Gate
from qrobot.backends.gate.form import Form, Term
from qrobot.errors import InputError

__all__ = ["ANSATZES", "Ansatz", "best_layer", "expectation", "make_ansatz", "ramp", "waves"]


def waves(form: Form, gamma: float) -> tuple[float, float, float]:
    """Return a, b and c with <D> = mean + a sin 2 beta + b sin 4 beta + c sin^2 2 beta.

    Parameters
    ----------
    form
        The cost D.
    gamma
        Angle of the phase exp(-i gamma D).
    """
    h, J, _ = form.ising
    n = form.qubits
    turn = 2 * gamma
    row = np.prod(np.cos(turn * J), axis=1) if n else np.empty(0)  # J[i, i] is 0, its cosine 1
    a = float((h * np.sin(turn * h) * row).sum())
    b = c = 0.0
    for i in range(n - 1):
        js = i + 1 + np.flatnonzero(J[i, i + 1 :])
        if not js.size:
            continue
        couple = J[i, js]
        # Products over all k but i and j: entry i of a row is 1, entry j is set to 1.
        mine = np.cos(turn * np.broadcast_to(J[i], (js.size, n)))
        mine[np.arange(js.size), js] = 1.0
        theirs = np.cos(turn * J[js])
        theirs[:, i] = 1.0
        plus, minus = np.cos(turn * (J[i] + J[js])), np.cos(turn * (J[i] - J[js]))
        for one in (plus, minus):
            one[:, i] = 1.0
            one[np.arange(js.size), js] = 1.0
        single = np.cos(turn * h[i]) * mine.prod(1) + np.cos(turn * h[js]) * theirs.prod(1)
        b += float((couple * np.sin(turn * couple) * single).sum()) / 2
        double = np.cos(turn * (h[i] + h[js])) * plus.prod(1)
        double -= np.cos(turn * (h[i] - h[js])) * minus.prod(1)
        c -= float((couple * double).sum()) / 2
    return a, b, c


def expectation(form: Form, gamma: float, beta: float) -> float:
    """Return the expectation of the cost after one layer, without simulating it."""
    a, b, c = waves(form, gamma)
    two = 2 * beta
    value = form.mean + a * np.sin(two) + b * np.sin(2 * two) + c * np.sin(two) ** 2
    return float(value)


def best_layer(
    form: Form, *, points: int = 60, angles: int = 181, widest: float = 3.0
) -> tuple[float, float, float]:
    """Return gamma, beta and the expectation of the best layer on a grid, refined once.

    Parameters
    ----------
    form
        The cost.
    points
        Gammas in one sweep, up to `widest` divided by the spread of the cost.
    angles
        Betas in one sweep, over all of them.
    widest
        Largest gamma times spread.
    """
    if not form.qubits or form.spread == 0.0:
        return 0.0, 0.0, form.mean
    unit = widest / form.spread
    gammas = unit * np.arange(1, points + 1) / points
    betas = np.linspace(-np.pi / 2, np.pi / 2, angles)
    found = (np.inf, 0.0, 0.0)
    for step in (unit / points, 0.0):
        for gamma in gammas:
            a, b, c = waves(form, float(gamma))
            values = a * np.sin(2 * betas) + b * np.sin(4 * betas) + c * np.sin(2 * betas) ** 2
            at = int(values.argmin())
            found = min(found, (float(values[at]), float(gamma), float(betas[at])))
        gammas = found[1] + np.linspace(-step, step, 21)
        betas = found[2] + np.linspace(-np.pi / angles, np.pi / angles, 41)
    return found[1], found[2], form.mean + found[0]


def ramp(layers: int, gamma: float, beta: float) -> tuple[Floats, Floats]:
    """Return gammas rising towards `gamma` and betas falling from `beta`, shape (layers,)."""
    at = (np.arange(layers) + 0.5) / layers
    return gamma * at, beta * (1 - at)


ANSATZES = ("qaoa", "hardware", "problem")

NOISE = {"qaoa": 0.02, "hardware": 0.1, "problem": 0.05}
"""Standard deviation of the first parameters: what makes one seed differ from another."""


@dataclass(frozen=True, eq=False)
class Ansatz:
    """A circuit and where its parameters begin.

    Parameters
    ----------
    name
        One of `ANSATZES`.
    circuit
        What is run.
    centre
        First parameters before any noise, shape (circuit.size,).
    """

    name: str
    circuit: Circuit
    centre: Floats

    def start(self, rng: np.random.Generator) -> Floats:
        """Return first parameters."""
        found: Floats = self.centre + rng.normal(0.0, NOISE[self.name], self.circuit.size)
        return found


def make_ansatz(name: str, form: Form, words: Sequence[Term], layers: int) -> Ansatz:
    """Return an ansatz for a model.

    Parameters
    ----------
    name
        One of `ANSATZES`.
    form, words
        The model, and its Ising form.
    layers
        Layers of cost and mixer, or of entanglers (``hardware`` takes 0: a product state).

    Raises
    ------
    InputError
        When the name or the number of layers is of no use.
    """
    least = 0 if name == "hardware" else 1
    if name not in ANSATZES:
        raise InputError(
            f"{name!r} is not an ansatz", field="ansatz", advice=f"use one of {', '.join(ANSATZES)}"
        )
    if layers < least:
        raise InputError(
            f"{layers} layers are too few", field="layers", advice=f"use {least} or more"
        )
    if name == "hardware":
        return _hardware(form.qubits, layers)
    make = _qaoa if name == "qaoa" else _problem
    return make(form, [word for word in words if word.qubits], layers)


def _hardware(qubits: int, layers: int) -> Ansatz:
    gates: list[Gate] = []
    for layer in range(layers + 1):
        gates += [Gate("ry", (q,), layer * qubits + q) for q in range(qubits)]
        if layer < layers:
            gates += [Gate("cz", (q, q + 1)) for q in range(qubits - 1)]
    size = (layers + 1) * qubits
    centre = np.zeros(size)
    centre[size - qubits :] = np.pi / 2  # every assignment equally likely
    return Ansatz("hardware", Circuit(qubits, tuple(gates), size), centre)


def _qaoa(form: Form, words: Sequence[Term], layers: int) -> Ansatz:
    gates, unit = [Gate("h", (q,)) for q in range(form.qubits)], _unit(form)
    for layer in range(layers):
        for coefficient, qubits in words:
            name = "rz" if len(qubits) == 1 else "rzz"
            gates.append(Gate(name, qubits, layer, 2 * coefficient * unit))
        gates += [Gate("rx", (q,), layers + layer, 2.0) for q in range(form.qubits)]
    gammas, betas = _ramp(form, layers)
    return Ansatz(
        "qaoa", Circuit(form.qubits, tuple(gates), 2 * layers), np.concatenate([gammas, betas])
    )


def _problem(form: Form, words: Sequence[Term], layers: int) -> Ansatz:
    n, unit = form.qubits, _unit(form)
    gammas, betas = _ramp(form, layers)
    couplings = [word for word in words if len(word.qubits) == 2]
    fields = np.zeros(n)
    for coefficient, qubits in words:
        if len(qubits) == 1:
            fields[qubits[0]] = coefficient * unit
    gates = [Gate("h", (q,)) for q in range(n)]
    centre: list[float] = []
    for gamma, beta in zip(gammas, betas, strict=True):
        first = len(centre)
        gates += [_coupled(term, first, unit) for term in couplings]
        gates += [Gate("rz", (q,), first + 1 + q) for q in range(n)]
        gates += [Gate("rx", (q,), first + 1 + n + q, 2.0) for q in range(n)]
        centre += [float(gamma), *(2 * gamma * fields), *np.full(n, beta)]
    return Ansatz("problem", Circuit(n, tuple(gates), len(centre)), np.array(centre))


def _coupled(term: Term, slot: int, unit: float) -> Gate:
    return Gate("rzz", term.qubits, slot, 2 * term.coefficient * unit)


def _unit(form: Form) -> float:
    return 1.0 / form.spread if form.spread > 0 else 1.0


def _ramp(form: Form, layers: int) -> tuple[Floats, Floats]:
    """Return gammas (in units) and betas: the best single layer, or a ramp around it."""
    gamma, beta, _ = best_layer(form)
    gamma /= _unit(form)
    if layers == 1:
        return np.array([gamma]), np.array([beta])
    return ramp(layers, 2 * gamma, 2 * beta)
