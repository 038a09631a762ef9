"""The LP file of the docplex model, as other programs read and solve it."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from oracles import least_distance
from stacks.figures_energies import needs_docplex, picking
from stacks.pickings import table2

from qrobot.models import build_model
from qrobot.models.docplex import lp_name, lp_text, picking_docplex


def read_by_highs(text, folder):
    """Return what HiGHS (the copy within SciPy) finds in an LP file."""
    core = pytest.importorskip(
        "scipy.optimize._highspy._core", reason="this SciPy holds no reader of LP files"
    )
    path = folder / "model.lp"
    path.write_text(text)
    highs = core._Highs()
    highs.setOptionValue("output_flag", False)
    assert highs.readModel(str(path)) == core.HighsStatus.kOk
    return highs.getModel()


def hessian_of(model, size):
    """Return HiGHS' matrix Q of x Q x / 2, symmetric (it keeps the lower triangle)."""
    found = np.zeros((size, size))
    start = list(model.hessian_.start_)
    for column in range(size):
        for k in range(start[column], start[column + 1]):
            row = model.hessian_.index_[k]
            found[row, column] = found[column, row] = model.hessian_.value_[k]
    return found


def rows_of(lp, size):
    """Return the constraints as a matrix with lower and upper bounds."""
    found = np.zeros((lp.num_row_, size))
    start = list(lp.a_matrix_.start_)
    by_columns = len(start) == size + 1
    for outer in range(len(start) - 1):
        for k in range(start[outer], start[outer + 1]):
            inner = lp.a_matrix_.index_[k]
            at = (inner, outer) if by_columns else (outer, inner)
            found[at] = lp.a_matrix_.value_[k]
    return found, np.array(lp.row_lower_), np.array(lp.row_upper_)


LPS = {
    "one robot": (table2(2), "reduced"),
    "whole order": (picking([2, 3, 4], [9, 7], [[0, 1], [2]]), "reduced"),
    "full": (picking([2, 3], [3, 3], [[0], [1]]), "full"),
    "detours": (
        picking([2, 3], [6], [[0], [1]], [[0, 9, 1.5], [1, 0, 40], [2.25, 33, 0]]),
        "reduced",
    ),
}


@needs_docplex
@pytest.mark.parametrize("name", LPS)
def test_another_reader_finds_the_same_model_in_the_lp(name, tmp_path):
    instance, encoding = LPS[name]
    made = picking_docplex(instance, encoding)
    model = read_by_highs(lp_text(made), tmp_path)
    lp, size = model.lp_, made.number_of_variables
    label = {lp_name(v.name): v.name for v in made.iter_variables()}
    assert sorted(lp.col_names_) == sorted(label)  # HiGHS counts them as they occur
    assert list(lp.row_names_) == [lp_name(c.name) for c in made.iter_constraints()]
    assert {kind.name for kind in lp.integrality_} == {"kInteger"}
    assert not np.any(lp.col_lower_)
    assert np.all(np.array(lp.col_upper_) == 1)
    Q, (A, low, high) = hessian_of(model, size), rows_of(lp, size)
    assert Q.any()
    # Plans: what keeps to all rows has the energy of the penalty form, its distance.
    reference = build_model(instance, encoding, "exact")
    routes = [list(p) for p in permutations(range(1, instance.size + 1))]
    seen = 0
    for route in routes:
        for cut in range(instance.size + 1) if len(instance.robots) > 1 else [instance.size]:
            plan = [route[:cut], route[cut:]][: len(instance.robots)]
            sample = reference.encode(plan)
            x = np.array([sample[label[name]] for name in lp.col_names_])
            kept = bool(np.all(A @ x >= low - 1e-9) and np.all(A @ x <= high + 1e-9))
            decoded = reference.decode(sample)
            assert kept == decoded.feasible
            value = lp.offset_ + np.array(lp.col_cost_) @ x + x @ Q @ x / 2
            assert value == pytest.approx(instance.length(plan), rel=1e-9)
            seen += kept
    assert seen


@needs_docplex
@pytest.mark.parametrize("name", LPS)
def test_what_the_lp_asks_for_is_the_best_plan(name, tmp_path):
    """CPLEX is not here: CP-SAT solves what HiGHS read, products as variables of their own."""
    cp_model = pytest.importorskip("ortools.sat.python.cp_model", reason="ortools is not installed")
    instance, encoding = LPS[name]
    model = read_by_highs(lp_text(picking_docplex(instance, encoding)), tmp_path)
    lp, size = model.lp_, model.lp_.num_col_
    Q, (A, low, high) = hessian_of(model, size), rows_of(lp, size)
    cp = cp_model.CpModel()
    x = [cp.new_bool_var(name) for name in lp.col_names_]
    for row, least, most in zip(A, low, high, strict=True):
        load = sum(int(a) * v for a, v in zip(row, x, strict=True) if a)
        assert np.all(row == np.rint(row))
        if np.isfinite(least):
            cp.add(load >= int(least))
        if np.isfinite(most):
            cp.add(load <= int(most))
    scale, cost = 10**6, []
    for i in range(size):
        cost.append(round(scale * (lp.col_cost_[i] + Q[i, i] / 2)) * x[i])
        for j in range(i):
            if Q[i, j]:
                both = cp.new_bool_var(f"{i},{j}")
                cp.add_multiplication_equality(both, [x[i], x[j]])
                cost.append(round(scale * Q[i, j]) * both)
    cp.minimize(sum(cost))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    assert solver.solve(cp) == cp_model.OPTIMAL
    expected = least_distance(instance)
    assert expected is not None
    assert solver.objective_value / scale == pytest.approx(expected[0], abs=1e-4)
