"""docplex -> QuadraticProgram -> binary quadratic model, by the libraries' own converters.

Each family of constraints gets its own weight, so each goes through the converters alone.
"""

from __future__ import annotations

import warnings
from typing import Any

import dimod

from qrobot._extras import load
from qrobot.errors import InputError
from qrobot.models.penalties import Penalties

__all__ = ["bqm_from_docplex"]

WEIGHTS = {
    "step": "step",
    "depot": "step",
    "visit": "visit",
    "capacity": "capacity",
    "order": "same_robot",
    "detour": "detour",
}
"""The weight of each family of constraints: a field of `Penalties`."""


def bqm_from_docplex(model: Any, penalties: Penalties) -> dimod.BinaryQuadraticModel:
    """Return the penalty form of a docplex model.

    `qiskit_optimization` translates the model and its constraints: an equation becomes the
    weighted square of its deviation, x + y <= 1 the weighted product x y. Meant for
    models of some hundred variables; `build_model` makes the same much faster.

    Parameters
    ----------
    model
        From `picking_docplex` with a slack.
    penalties
        The weights; `shift` means nothing here.

    Returns
    -------
    dimod.BinaryQuadraticModel
        Binary, float64, with the names and the sequence of the model's variables.

    Raises
    ------
    InputError
        When the capacity is an inequality, or constraints are missing or not known.
    MissingExtraError
        When qiskit-optimization is not installed.
    """
    translators = load("qiskit_optimization.translators", "the penalty form of a docplex model")
    with warnings.catch_warnings():
        # A capacity without weights and slack is 0 = M: a constant of the energy.
        warnings.filterwarnings("ignore", "Trivial constraint")
        program = translators.from_docplex_mp(model)
    families = _families(program)
    if penalties.detour and "detour" not in families and program.get_num_vars():
        raise InputError(
            "the docplex model has no constraints against detours, for its distances need none",
            field="penalties.detour",
            advice="give 0",
        )
    bqm = dimod.BinaryQuadraticModel(dimod.BINARY)
    for variable in program.variables:
        bqm.add_variable(variable.name)
    _add(bqm, program.objective)
    for family, constraints in families.items():
        weight = float(getattr(penalties, WEIGHTS[family]))
        if weight:
            _add(bqm, _penalty(program, constraints, weight))
    return bqm


def _families(program: Any) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for constraint in program.linear_constraints:
        family = constraint.name.partition("[")[0]
        if family not in WEIGHTS:
            raise InputError(
                f"constraint {constraint.name!r} has no weight",
                field="model",
                advice="give a model of picking_docplex",
            )
        if family == "capacity" and constraint.sense.label != "==":
            raise InputError(
                "the capacity is an inequality",
                field="slack",
                advice="build the docplex model with slack 'exact' or 'paper'",
            )
        found.setdefault(family, []).append(constraint)
    return found


def _penalty(program: Any, constraints: list[Any], weight: float) -> Any:
    """Return the objective that the libraries' converters make of constraints alone."""
    from qiskit_optimization import QuadraticProgram
    from qiskit_optimization.converters import LinearEqualityToPenalty, LinearInequalityToPenalty

    alone = QuadraticProgram()
    for variable in program.variables:
        alone.binary_var(variable.name)
    for given in constraints:
        alone.linear_constraint(given.linear.coefficients, given.sense, given.rhs, given.name)
    products = LinearInequalityToPenalty(penalty=weight).convert(alone)
    return LinearEqualityToPenalty(penalty=weight).convert(products).objective


def _add(bqm: dimod.BinaryQuadraticModel, objective: Any) -> None:
    bqm.offset += objective.constant
    for name, value in objective.linear.to_dict(use_name=True).items():
        bqm.add_linear(name, value)
    for (one, two), value in objective.quadratic.to_dict(use_name=True).items():
        if one == two:
            bqm.add_linear(one, value)  # x x = x
        else:
            bqm.add_quadratic(one, two, value)
