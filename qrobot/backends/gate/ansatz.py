"""Which circuit: QAOA, and two for VQE, with the first parameters of each.

- ``qaoa``: E. Farhi, J. Goldstone and S. Gutmann, arXiv:1411.4028 (2014). Parameters are the
  gammas in units of 1 / spread of the cost, then the betas.
- ``hardware``: layers of RY and chains of CZ, which any device runs without routing
  (A. Kandala et al., Nature 549 (2017) 242).
- ``problem``: QAOA with an angle of its own for each field and each mixer and one a layer for
  all couplings (after R. Herrman et al., Scientific Reports 12 (2022) 6781, who give the
  couplings theirs too). It entangles what the model couples and starts from QAOA's angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qrobot._arrays import Floats
from qrobot.backends.gate.analytic import best_layer, ramp
from qrobot.backends.gate.circuit import Circuit, Gate
from qrobot.backends.gate.form import Form, Term
from qrobot.errors import InputError

__all__ = ["ANSATZES", "Ansatz", "make_ansatz"]


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
