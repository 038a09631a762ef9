"""The paper's model, errata corrected, in docplex: as LP file, and through Qiskit as penalty form.

`picking_docplex` is docs/formulation.md term by term and shares no code with the vectorised
models but the list of vehicles and the coefficients of the slack: each is a test of the other.
docplex and qiskit-optimization are imported when a function needs them.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from itertools import combinations, permutations
from typing import Any, Literal

import dimod

from qrobot._extras import load
from qrobot.errors import InputError
from qrobot.models.fleet import Vehicles, fleet_of
from qrobot.models.layout import MAX_VARIABLES
from qrobot.models.model import check_choice
from qrobot.models.penalties import Penalties
from qrobot.models.slack import Slack, slack_coefficients
from qrobot.problem import Instance

__all__ = ["DOCPLEX_ENCODINGS", "bqm_from_docplex", "lp_name", "lp_text", "picking_docplex"]

DOCPLEX_ENCODINGS: tuple[Literal["reduced", "full"], ...] = ("reduced", "full")

MAX_PAIRS = 200_000
"""More constraints over pairs are refused: docplex takes about 1 kB for each."""

Place = tuple[int, Any]
"""A node and the variable (or the constant 1) that says that a robot is there."""


def picking_docplex(
    instance: Instance,
    encoding: Literal["reduced", "full"] = "reduced",
    slack: Slack | None = None,
) -> Any:
    """Return the constrained model of an instance.

    Variables are called as in `PickingModel.variables`, ``x[t,i,p]`` and ``slack[p,b]``.
    Constraints are called by what they keep: ``step[t,p]``, ``visit[i]``,
    ``capacity[p]``, ``depot[t]`` (full encoding), ``order[...]`` (a pair of items of one
    order on two robots) and ``detour[...]`` (only where a way over the depot is shorter
    than the direct one, as with `Penalties.detour`). Constraints over pairs are
    x + y <= 1.

    Parameters
    ----------
    instance
        The question; n items, K robots.
    encoding
        ``reduced``, K n (n + 1) variables, or ``full``, K (n + 1) (n + 2).
    slack
        None keeps the capacity as an inequality: the model to solve. ``exact`` or
        ``paper`` adds slack binaries and makes it an equation: the model to penalise.

    Returns
    -------
    docplex.mp.model.Model
        Binary, quadratic objective in units of distance, linear constraints; weights are
        in the instance's units.

    Raises
    ------
    InputError
        When an option is unknown, or the model would be too large.
    MissingExtraError
        When docplex is not installed.
    """
    check_choice("encoding", encoding, DOCPLEX_ENCODINGS)
    check_choice("slack", slack, (None, "exact", "paper"))
    fleet = fleet_of(instance, every_robot=True)
    n, robots = instance.size, len(fleet)
    layers = n if encoding == "reduced" else n + 2
    size = robots * (n + 1) * layers
    if size > MAX_VARIABLES:
        raise InputError(
            f"the {encoding} docplex model would have {size} binary variables, more than the "
            f"{MAX_VARIABLES} that one model may have",
            field="encoding",
            advice="plan fewer items at a time, or with fewer robots",
        )
    detours = Penalties.measured(instance, encoding).detour > 0
    pairs = robots * (robots - 1) * layers**2 * sum(1 for _ in _mates(instance))
    pairs += robots * layers * n if detours else 0
    if pairs > MAX_PAIRS:
        raise InputError(
            f"the docplex model would have {pairs} constraints over pairs of variables, more "
            f"than the {MAX_PAIRS} that are written",
            field="orders",
            advice="plan fewer items at a time, or split the orders",
        )
    Model = load("docplex.mp.model", "a docplex model").Model
    name = re.sub(r"[^A-Za-z0-9.-]+", "-", instance.name)[:80]  # goes into a comment of the LP
    model = Model(f"qrobot-{name}", checker="off")
    _Writer(model, instance, fleet, full=encoding == "full").write(slack, detours)
    return model


class _Writer:
    """Writes the formulas into an empty docplex model."""

    def __init__(self, model: Any, instance: Instance, fleet: Vehicles, *, full: bool) -> None:
        self.model, self.instance, self.fleet, self.full = model, instance, fleet, full
        self.n, self.robots = instance.size, range(1, len(fleet) + 1)
        self.steps = range(self.n + 2) if full else range(1, self.n + 1)
        self.x = {
            (t, i, p): model.binary_var(name=f"x[{t},{i},{p}]")
            for p in self.robots
            for t in self.steps
            for i in range(self.n + 1)
        }

    def places(self, t: int, p: int) -> list[Place]:
        """Return where robot p may be at step t; the reduced encoding's ends are constant."""
        if t not in self.steps:
            return [(0, 1)]
        return [(i, self.x[t, i, p]) for i in range(self.n + 1)]

    def write(self, slack: Slack | None, detours: bool) -> None:
        """Write objective and constraints."""
        self.model.minimize(self.model.sum(list(self._ways())))
        for p in self.robots:
            for t in self.steps:
                self._add(self._sum(x for _, x in self.places(t, p)) == 1, f"step[{t},{p}]")
        for i in range(1, self.n + 1):
            visits = self._sum(self.x[t, i, p] for p in self.robots for t in self.steps)
            self._add(visits == 1, f"visit[{i}]")
        for p in self.robots:
            self._capacity(p, slack)
        if self.full:
            for t in (0, self.n + 1):
                ready = self._sum(self.x[t, 0, p] for p in self.robots)
                self._add(ready == len(self.robots), f"depot[{t}]")
        self._orders()
        if detours:
            self._detours()

    def _ways(self) -> Iterator[Any]:
        """Yield x[t-1,i,p] x[t,j,p] d[i,j]."""
        d = self.instance.distances.tolist()
        for p in self.robots:
            for t in range(1, self.n + 2):
                for i, x in self.places(t - 1, p):
                    for j, y in self.places(t, p):
                        if d[i][j]:
                            yield d[i][j] * (x * y)

    def _capacity(self, p: int, slack: Slack | None) -> None:
        room = int(self.fleet.capacities[p - 1])
        weights = [0, *self.instance.weights.tolist()]
        load = self._sum(
            weights[i] * self.x[t, i, p]
            for t in self.steps
            for i in range(1, self.n + 1)
            if weights[i]
        )
        if slack is None:
            if any(weights):
                self._add(load <= room, f"capacity[{p}]")
            return
        bits = slack_coefficients(room, slack).tolist()
        left = [c * self.model.binary_var(name=f"slack[{p},{b}]") for b, c in enumerate(bits)]
        if left or room or any(weights):
            self._add(load + self._sum(left) == room, f"capacity[{p}]")

    def _orders(self) -> None:
        """Forbid two robots to collect of one order."""
        for i, j in _mates(self.instance):
            for p, q in permutations(self.robots, 2):
                for t in self.steps:
                    for u in self.steps:
                        self._apart((t, i, p), (u, j, q), "order")

    def _detours(self) -> None:
        """Forbid to leave the depot at a later step than the first."""
        for p in self.robots:
            for t in self.steps:
                if t < 1 or t + 1 not in self.steps:
                    continue
                for j in range(1, self.n + 1):
                    self._apart((t, 0, p), (t + 1, j, p), "detour")

    def _apart(self, one: tuple[int, int, int], two: tuple[int, int, int], family: str) -> None:
        name = ",".join(map(str, one + two))
        self._add(self.x[one] + self.x[two] <= 1, f"{family}[{name}]")

    def _add(self, constraint: Any, name: str) -> None:
        self.model.add_constraint(constraint, ctname=name)

    def _sum(self, terms: Any) -> Any:
        """Return a sum that is an expression of docplex, even an empty one."""
        return self.model.linear_expr() + self.model.sum(list(terms))


def _mates(instance: Instance) -> Iterator[tuple[int, int]]:
    """Yield the pairs of nodes that belong to one order."""
    for nodes in instance.order_nodes:
        yield from combinations(sorted(nodes), 2)


def lp_name(label: str) -> str:
    """Return the name that a variable or constraint has in LP files: ``x_1_0_2``.

    A bracket begins the quadratic part there; commas and parentheses are read by some
    solvers only.
    """
    return label.replace("[", "_").replace(",", "_").replace("]", "")


def lp_text(model: Any) -> str:
    """Return a model of `picking_docplex` in the LP format, with 12 decimals as docplex has them.

    Raises
    ------
    MissingExtraError
        When docplex is not installed.
    """
    base: Any = load("docplex.mp.lp_printer", "an LP file").LPModelPrinter

    # By itself it would call x[1,0,2] just x3; renaming the variables, or a copy of the
    # model, makes docplex write to the terminal.
    class Printer(base):  # type: ignore[misc]
        def fix_name(self, mobj: Any, *_: object) -> str:
            return lp_name(str(mobj.name))

    text = io.StringIO()
    Printer().printModel(model, text)
    return text.getvalue()


# -- the penalty form ------------------------------------------------------------

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
