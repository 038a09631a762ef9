"""The door to the models: an instance in, a binary quadratic model with its meaning out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import dimod
import numpy as np
import numpy.typing as npt

from qrobot._files import StrPath
from qrobot._notebook import shown_name
from qrobot.errors import InputError
from qrobot.models.assemble import assemble
from qrobot.models.encodings import compact_layout, paper_layout
from qrobot.models.layout import VariableLayout
from qrobot.models.penalties import Encoding, Penalties
from qrobot.models.potentials import potentials_of
from qrobot.models.samples import (
    Decoded,
    Reads,
    bits_of,
    decode_row,
    decode_rows,
    encode_routes,
)
from qrobot.models.slack import Slack
from qrobot.problem import Instance
from qrobot.problem.formats import instance_of

__all__ = ["ENCODINGS", "PickingModel", "Symmetry", "build_model", "check_choice", "model_for"]

ENCODINGS: tuple[Encoding, ...] = ("compact", "reduced", "full")
Symmetry = Literal["keep", "break"]

DIGITS = 2.0**31
"""Largest square of a capacity, in constraint weights: leaves 7 digits for the distances."""


@dataclass(frozen=True, eq=False, repr=False)
class PickingModel:
    """A binary quadratic model of an instance, and what its variables mean.

    The energy of every plan that keeps to all constraints is its distance.

    Parameters
    ----------
    instance
        The question.
    layout
        The variables.
    penalties
        The weights of the constraints in use.
    bqm
        The model: binary, float64, in the order of ``layout.labels``.
    slack
        Kind of the slack binaries.
    symmetry
        ``keep`` or ``break``.
    """

    instance: Instance
    layout: VariableLayout
    penalties: Penalties
    bqm: dimod.BinaryQuadraticModel
    slack: Slack
    symmetry: Symmetry

    def __repr__(self) -> str:
        return (
            f"<PickingModel of {shown_name(self.instance.name)}: {self.encoding}, "
            f"{self.num_variables} variables, {self.bqm.num_interactions} couplings>"
        )

    @property
    def encoding(self) -> Encoding:
        """Name of the encoding."""
        return self.layout.encoding

    @property
    def num_variables(self) -> int:
        """Number of binary variables: the qubits."""
        return self.layout.size

    @property
    def variables(self) -> list[str]:
        """Names of the variables: ``x[t,i,p]`` and ``slack[p,b]``; p counts from 1."""
        return self.layout.labels

    def decode(self, sample: Mapping[Any, Any]) -> Decoded:
        """Return routes, violations, energy and distance of one sample.

        Parameters
        ----------
        sample
            A value for every variable: 0 and 1, booleans, or spins.
        """
        bits = bits_of(self.layout, sample)
        energy = float(self.bqm.energy((bits, self.layout.labels)))
        return decode_row(self.instance, self.layout, bits, energy)

    def decode_all(self, samples: dimod.SampleSet) -> Reads:
        """Judge all samples of a set at once.

        Parameters
        ----------
        samples
            Over this model's variables, binary or spin.
        """
        return decode_rows(self.instance, self.layout, self.matrix(samples))

    def matrix(self, samples: dimod.SampleSet) -> npt.NDArray[np.int8]:
        """Return samples as 0 and 1, shape (samples, variables) in this model's order."""
        where = {label: k for k, label in enumerate(samples.variables)}
        columns = [where[label] for label in self.layout.labels]
        return np.asarray(samples.record.sample[:, columns] > 0, dtype=np.int8)

    def encode(self, routes: Sequence[Sequence[int]]) -> dict[str, int]:
        """Return the sample that stands for routes.

        Parameters
        ----------
        routes
            For each vehicle its nodes (item index + 1) in sequence; vehicles left out stay
            home. When a route is too heavy for its vehicle, the heaviest load goes to the
            largest one and so on.

        Raises
        ------
        InputError
            When the model has no variables for these routes.
        """
        bits = self.encode_bits(routes)
        return dict(zip(self.layout.labels, bits.tolist(), strict=True))

    def encode_bits(self, routes: Sequence[Sequence[int]]) -> npt.NDArray[np.int8]:
        """Return the same as an array in this model's order, shape (variables,)."""
        return encode_routes(self.instance, self.layout, routes, canonical=self.symmetry == "break")

    def energy_of(self, routes: Sequence[Sequence[int]]) -> float:
        """Return the energy of routes: their distance when they keep to all constraints."""
        return float(self.bqm.energy((self.encode_bits(routes), self.layout.labels)))


def build_model(
    instance: Instance | StrPath,
    encoding: Encoding = "compact",
    slack: Slack = "exact",
    penalties: Penalties | Mapping[str, float] | str | None = None,
    symmetry: Symmetry = "keep",
) -> PickingModel:
    """Model an instance as a binary quadratic model.

    Parameters
    ----------
    instance
        The question, or the path of its file; n items, K robots.
    encoding
        ``compact`` (fewest variables, for samplers), or the paper's ``reduced``,
        K n (n + 1) variables and slack, or ``full``, K (n + 1) (n + 2) and slack.
    slack
        ``exact``, or ``paper`` for the paper's ceil(log2 M) binaries a robot.
    penalties
        Weights of the constraints: ``measured`` (the default), ``safe``, or a mapping that
        replaces some of the measured ones.
    symmetry
        ``break`` keeps one of the ways in which equal vehicles can exchange their trips
        (compact encoding only). It saves variables; annealers are better off with
        ``keep``.

    Raises
    ------
    InputError
        When an option is unknown or unusable, or the model would be too large.
    InfeasibleError
        When the compact encoding proves that no plan exists.
    """
    instance = instance_of(instance)
    check_choice("encoding", encoding, ENCODINGS)
    check_choice("slack", slack, ("exact", "paper"))
    check_choice("symmetry", symmetry, ("keep", "break"))
    if symmetry == "break" and encoding != "compact":
        raise InputError(
            f"the {encoding} encoding keeps its symmetry",
            field="symmetry",
            advice="use the compact encoding, or symmetry 'keep'",
        )
    if encoding == "compact":
        layout = compact_layout(instance, slack, break_symmetry=symmetry == "break")
    else:
        layout = paper_layout(instance, encoding, slack)
    weights = Penalties.of(instance, encoding, penalties)
    _check_digits(instance, layout, weights)
    potentials = potentials_of(
        instance,
        several=len(layout.fleet) > 1,
        scale=weights.shift if encoding == "compact" else 0.0,
    )
    bqm = assemble(instance, layout, weights, potentials)
    return PickingModel(instance, layout, weights, bqm, slack, symmetry)


def model_for(
    instance: Instance | StrPath, purpose: Literal["anneal", "gate", "paper"] = "anneal"
) -> PickingModel:
    """Build the model that suits a purpose.

    Parameters
    ----------
    instance
        The question.
    purpose
        ``anneal`` and ``gate`` get the compact encoding, which has the fewest variables
        and samples best; ``paper`` the reduced one with the paper's slack, the model of
        the paper's tables 2 and 3.
    """
    check_choice("purpose", purpose, ("anneal", "gate", "paper"))
    if purpose == "paper":
        return build_model(instance, "reduced", slack="paper")
    return build_model(instance, "compact")


def _check_digits(instance: Instance, layout: VariableLayout, weights: Penalties) -> None:
    """Refuse a capacity whose square would swallow the digits of the distances."""
    rooms = layout.fleet.capacities[layout.summed]
    if not len(rooms):
        return
    room = int(rooms.max())
    scale = max(weights.step, weights.visit, float(instance.distances.max(initial=0.0)))
    if weights.capacity * float(room) ** 2 > DIGITS * scale:
        raise InputError(
            f"capacity {float(room * instance.unit):.12g} is so much larger than the weights that "
            f"energies would lose their digits in the {layout.encoding} encoding",
            field="robots[].capacity",
            advice="use the compact encoding, penalties 'measured', or a capacity no larger than "
            f"the total load {float(int(instance.weights.sum()) * instance.unit):.12g}",
        )


def check_choice(field: str, value: object, known: Sequence[str | None]) -> None:
    """Refuse a value that is not one of those that are known."""
    if value not in known:
        names = ", ".join("none" if name is None else name for name in known)
        raise InputError(f"{value!r} is unknown", field=field, advice=f"use {names}")
