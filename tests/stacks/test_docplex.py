"""The docplex model against the vectorised ones, other libraries and other readers."""

from __future__ import annotations

import io
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace

import dimod
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from stacks.figures_energies import (
    all_bits,
    by_dimod,
    by_docplex,
    needs_docplex,
    picking,
    random_bits,
    relative,
    small_cases,
    wide_case,
)
from stacks.pickings import table2
from strategies import instances

from qrobot.errors import InputError, MissingExtraError
from qrobot.models import Penalties, build_model
from qrobot.models.docplex import bqm_from_docplex, lp_text, picking_docplex


@needs_docplex
@pytest.mark.parametrize("name", small_cases())
def test_energies_on_all_assignments(name):
    model = small_cases()[name]
    bits = all_bits(model.num_variables)
    expected = by_dimod(model, bits)
    assert len(bits) == 2**model.num_variables <= 4096
    np.testing.assert_allclose(by_docplex(model, bits), expected, rtol=0, atol=1e-9)


@needs_docplex
@pytest.mark.parametrize("encoding", ["reduced", "full"])
def test_energies_on_random_assignments_of_two_robots_and_four_items(encoding):
    model = wide_case(encoding)
    bits = random_bits(model.num_variables)
    assert bits.shape == (10_000, {"reduced": 48, "full": 68}[encoding])
    found, expected = by_docplex(model, bits), by_dimod(model, bits)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


@needs_docplex
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    instance=instances(min_items=1, max_items=4, max_robots=3),
    encoding=st.sampled_from(["reduced", "full"]),
    slack=st.sampled_from(["exact", "paper"]),
    seed=st.integers(0, 1000),
)
def test_energies_of_any_instance(instance, encoding, slack, seed):
    """Several trips a robot, orders of several items, tables that are no metric, weights 0."""
    try:
        model = build_model(instance, encoding, slack)
    except InputError:
        return  # a capacity whose square swallows the distances
    bits = random_bits(model.num_variables, 200, seed)
    assert relative(by_docplex(model, bits), by_dimod(model, bits)) <= 1e-9


@needs_docplex
@pytest.mark.parametrize("family", ["step", "visit", "capacity", "same_robot", "detour"])
def test_each_weight_counts(family):
    """Every family of constraints is in some case: dropping its weight changes energies."""
    changed = 0.0
    for model in small_cases().values():
        bits = all_bits(model.num_variables)
        less = replace(model.penalties, **{family: 0.0})
        made = picking_docplex(model.instance, model.encoding, model.slack)
        found = bqm_from_docplex(made, less).energies((bits, model.variables))
        rebuilt = build_model(model.instance, model.encoding, model.slack, penalties=less)
        assert relative(found, by_dimod(rebuilt, bits)) <= 1e-9
        changed = max(changed, float(np.abs(found - by_dimod(model, bits)).max()))
    assert changed > 1


@needs_docplex
@pytest.mark.parametrize("name", small_cases())
def test_docplexs_own_values_of_objective_and_constraints(name):
    """Without Qiskit's translation: docplex evaluates what it holds, at random places."""
    model = small_cases()[name]
    made = picking_docplex(model.instance, model.encoding, model.slack)
    weight = {
        "step": model.penalties.step, "depot": model.penalties.step,
        "visit": model.penalties.visit, "capacity": model.penalties.capacity,
        "order": model.penalties.same_robot, "detour": model.penalties.detour,
    }  # fmt: skip
    bits = random_bits(model.num_variables, 50, seed=2)
    for row, expected in zip(bits, by_dimod(model, bits), strict=True):
        point = made.new_solution(dict(zip(model.variables, map(int, row), strict=True)))
        energy = point.get_value(made.objective_expr)
        for constraint in made.iter_linear_constraints():
            over = point.get_value(constraint.lhs) - point.get_value(constraint.rhs)
            family = constraint.name.partition("[")[0]
            # x + y - 1 is positive only where both are 1
            count = over**2 if constraint.sense_string == "EQ" else max(0.0, over)
            energy += weight[family] * count
        assert energy == pytest.approx(expected, rel=1e-9, abs=1e-9)


@needs_docplex
@pytest.mark.parametrize("items", [1, 2])
def test_the_librarys_whole_pipeline_from_the_inequality(items):
    """Qiskit finds slack and penalties by itself; with one weight for all they are ours."""
    from qiskit_optimization.converters import QuadraticProgramToQubo
    from qiskit_optimization.translators import from_docplex_mp

    weights = Penalties(step=50.0, visit=50.0, capacity=50.0, same_robot=50.0)
    instance = table2(items) if items > 1 else picking([3, 4], [13], [[0], [1]])
    program = from_docplex_mp(picking_docplex(instance))
    objective = QuadraticProgramToQubo(penalty=50.0).convert(program).objective
    model = build_model(instance, "reduced", "exact", penalties=weights)
    bits = all_bits(model.num_variables)
    found = [objective.evaluate(row) for row in bits[::7]]
    assert relative(np.array(found), by_dimod(model, bits[::7])) <= 1e-9


# -- manners -------------------------------------------------------------------------------


@needs_docplex
def test_models_have_the_variables_and_constraints_of_the_formulas():
    made = picking_docplex(table2(3))
    assert [v.name for v in made.iter_variables()] == build_model(
        table2(3), "reduced", "exact"
    ).variables[:12]
    names = [c.name for c in made.iter_constraints()]
    assert names == [f"step[{t},1]" for t in (1, 2, 3)] + [f"visit[{i}]" for i in (1, 2, 3)] + [
        "capacity[1]"
    ]
    assert made.get_constraint_by_name("capacity[1]").sense_string == "LE"
    with_slack = picking_docplex(table2(3), slack="paper")
    assert with_slack.number_of_variables == 16
    assert with_slack.get_constraint_by_name("capacity[1]").sense_string == "EQ"
    full = picking_docplex(picking([1, 1], [5, 5], [[0], [1]]), "full")
    ends = [c.name for c in full.iter_constraints() if c.name.startswith("depot")]
    assert ends == ["depot[0]", "depot[3]"]


@needs_docplex
def test_nothing_is_printed_and_names_are_kept(capfd):
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        made = picking_docplex(replace(table2(2), name="a\nMinimize\n é obj: x\n"))
        text = lp_text(made)
    told = capfd.readouterr()
    assert (out.getvalue(), err.getvalue(), told.out, told.err) == ("", "", "", "")
    assert made.get_var_by_name("x[1,0,1]") is not None
    assert text.count("Minimize\n obj:") == 1
    assert text.isascii()
    assert "Problem name: qrobot-a-Minimize-obj-x-\n" in text


@needs_docplex
def test_what_cannot_be_penalised_is_refused():
    instance = table2(2)
    weights = Penalties.measured(instance, "reduced")
    with pytest.raises(InputError, match="inequality"):
        bqm_from_docplex(picking_docplex(instance), weights)
    with pytest.raises(InputError, match="detour"):
        bqm_from_docplex(picking_docplex(instance, slack="exact"), replace(weights, detour=1.0))
    foreign = picking_docplex(instance, slack="exact")
    foreign.add_constraint(foreign.get_var_by_name("x[1,0,1]") == 0, ctname="mine")
    with pytest.raises(InputError, match="mine"):
        bqm_from_docplex(foreign, weights)


@pytest.mark.parametrize(
    ("options", "field"),
    [({"encoding": "compact"}, "encoding"), ({"slack": "wide"}, "slack")],
)
def test_unknown_options_are_refused_by_name(options, field):
    with pytest.raises(InputError, match=field):
        picking_docplex(table2(2), **options)


def test_models_that_are_too_large_are_refused_before_they_are_made():
    large = picking([1], [1] * 2501, [[0]])
    with pytest.raises(InputError, match="5002 binary variables"):
        picking_docplex(large)


def test_the_room_imports_neither_docplex_nor_qiskit():
    code = (
        "import sys, qrobot.models, qrobot.models.docplex; "
        "assert not {'docplex', 'qiskit', 'qiskit_optimization', 'scipy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_an_absent_extra_is_one_sentence(monkeypatch):
    model = dimod.BinaryQuadraticModel("BINARY")
    for module in ("docplex", "docplex.mp", "docplex.mp.model", "docplex.mp.lp_printer",
                   "qiskit_optimization", "qiskit_optimization.translators"):  # fmt: skip
        monkeypatch.setitem(sys.modules, module, None)
    weights = Penalties.measured(table2(2), "reduced")
    for call in (
        lambda: picking_docplex(table2(2)),
        lambda: lp_text(model),
        lambda: bqm_from_docplex(model, weights),
    ):
        with pytest.raises(MissingExtraError, match=r"pip install 'qrobot\[docplex\]'"):
            call()
