"""Models as files for other programs: an LP of docplex, dimod's files, coordinates."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from typing import Any

import dimod
import numpy as np

from qrobot._files import StrPath, path_text, write_bytes_atomic
from qrobot._json import json_text
from qrobot.errors import InputError
from qrobot.models.model import build_model
from qrobot.models.penalties import Penalties
from qrobot.problem import Instance
from qrobot.problem.formats import instance_of

__all__ = ["FORMATS", "ModelFormat", "coordinates", "export_model", "format_of"]

Written = tuple[bytes, dict[str, Any]]
"""The contents of a file, and what is told of it."""


@dataclasses.dataclass(frozen=True, slots=True)
class ModelFormat:
    """A kind of file that holds a model."""

    name: str
    """As reports have it"""
    ending: str
    """What people are advised to end its files with"""
    write: Callable[[Instance, Any, Any, Any], Written]
    """Takes the instance, encoding, slack and penalties as `export_model` does"""


def format_of(path: StrPath) -> ModelFormat:
    """Return the format that a file's ending asks for.

    Raises
    ------
    InputError
        When the ending is another.
    """
    ending = os.path.splitext(path_text(path))[1].lower()
    if ending not in FORMATS:
        *others, last = (known.ending for known in FORMATS.values())
        raise InputError(
            f"the ending {ending!r} does not name a format",
            source=os.fspath(path),
            advice=f"use {', '.join(others)} or {last}",
        )
    return FORMATS[ending]


def export_model(
    instance: Instance | StrPath,
    path: StrPath,
    encoding: str | None = None,
    slack: str | None = None,
    penalties: str | Mapping[str, float] | Penalties | None = "safe",
) -> dict[str, Any]:
    """Write the model of an instance to a file; its ending chooses what is written.

    Parameters
    ----------
    instance
        The question, or the path of its file.
    path
        ``.lp``: the constrained model, from docplex. ``.bqm.json`` or ``.json``: the
        penalty form, to be read by `dimod.BinaryQuadraticModel.from_serializable`.
        ``.bqm``: the same, for `dimod.BinaryQuadraticModel.from_file`.
        ``.coo``: the same as coordinates, see `coordinates`.
    encoding
        None is ``reduced`` for an LP and ``compact`` for a penalty form.
    slack
        ``exact`` or ``paper``; None is ``exact`` for a penalty form, and leaves the
        capacity of an LP an inequality.
    penalties
        Of a penalty form: ``safe`` (the lowest energy is the best plan, see
        `Penalties.safe`), ``measured`` (what samples best here; the lowest energy need not be
        a plan), or weights by name.

    Returns
    -------
    dict
        What was written, as plain data: ``format``, ``encoding``, ``slack``,
        ``variables``, ``couplings`` (products in the objective), ``constraints``,
        ``penalties`` (None in an LP), ``ground_state_is_plan`` (whether that is proven), and
        ``offset`` (the constant) and ``offset_in_file`` (whether a reader gets it).

    Raises
    ------
    InputError
        When an option or the ending is unknown, the model too large, or the file cannot
        be written.
    InfeasibleError
        When the compact encoding proves that no plan exists.
    MissingExtraError
        When docplex is needed and not installed.
    """
    known = format_of(path)
    data, report = known.write(instance_of(instance), encoding, slack, penalties)
    write_bytes_atomic(path, data)
    return {"format": known.name} | report


def _lp(instance: Instance, encoding: Any, slack: Any, _penalties: Any) -> Written:
    from qrobot.models.docplex import lp_text, picking_docplex

    encoding = encoding or "reduced"
    model = picking_docplex(instance, encoding, slack)
    objective = model.objective_expr
    quadratic = objective.number_of_quadratic_terms if objective.is_quad_expr() else 0
    return lp_text(model).encode(), {
        "encoding": encoding,
        "slack": slack,
        "variables": model.number_of_variables,
        "couplings": quadratic,
        "constraints": model.number_of_constraints,
        "penalties": None,
        # The paper's slack may end one short of the capacity: no robot can stay empty then.
        "ground_state_is_plan": slack != "paper",
        "offset": 0.0,
        "offset_in_file": True,
    }


def _penalty_form(
    contents: Callable[[dimod.BinaryQuadraticModel], bytes], *, offset: bool = True
) -> Callable[[Instance, Any, Any, Any], Written]:
    """Return what writes a penalty form; `offset` tells whether its files keep the constant."""

    def write(instance: Instance, encoding: Any, slack: Any, penalties: Any) -> Written:
        model = build_model(instance, encoding or "compact", slack or "exact", penalties)
        return contents(model.bqm), {
            "encoding": model.encoding,
            "slack": model.slack,
            "variables": model.num_variables,
            "couplings": model.bqm.num_interactions,
            "constraints": 0,
            "penalties": dataclasses.asdict(model.penalties),
            # The proof of the safe weights wants a slack that reaches the whole capacity.
            "ground_state_is_plan": penalties == "safe" and model.slack == "exact",
            "offset": float(model.bqm.offset),
            "offset_in_file": offset,
        }

    return write


def _json(bqm: dimod.BinaryQuadraticModel) -> bytes:
    return (json_text(bqm.to_serializable()) + "\n").encode()


def _binary(bqm: dimod.BinaryQuadraticModel) -> bytes:
    with bqm.to_file() as file:
        return bytes(file.read())


def coordinates(bqm: dimod.BinaryQuadraticModel) -> str:
    """Return a model as lines ``i j bias``, as `dimod.serialization.coo` reads them.

    Other than dimod's own writer it rounds nothing, and keeps in comments what the format
    has no place for: the constant and the names of the variables. The energy of all zeros is
    0 in this format whatever is written, so a reader's energies lack the constant. A variable
    that has no bias is written with bias 0, so that none is lost.
    """
    names = list(bqm.variables)
    linear, (rows, columns, values), offset = bqm.to_numpy_vectors(variable_order=names)
    lines = [f"# vartype={bqm.vartype.name}", f"# offset={_digits(offset)}"]
    lines += [f"# variable {k} {name}" for k, name in enumerate(names)]
    lines += [f"{k} {k} {_digits(bias)}" for k, bias in enumerate(linear)]
    pairs = sorted(
        (min(i, j), max(i, j), value)
        for i, j, value in zip(rows.tolist(), columns.tolist(), values.tolist(), strict=True)
    )
    lines += [f"{i} {j} {_digits(value)}" for i, j, value in pairs]
    return "\n".join(lines) + "\n"


def _digits(value: float) -> str:
    """Return all digits without an exponent, which dimod would not read."""
    return np.format_float_positional(value, trim="0")


FORMATS = {
    ".lp": ModelFormat("lp", ".lp", _lp),
    ".json": ModelFormat("bqm", ".bqm.json", _penalty_form(_json)),
    ".bqm": ModelFormat("bqm-binary", ".bqm", _penalty_form(_binary)),
    ".coo": ModelFormat(
        "coo", ".coo", _penalty_form(lambda bqm: coordinates(bqm).encode(), offset=False)
    ),
}
"""The format that each file ending asks for."""
