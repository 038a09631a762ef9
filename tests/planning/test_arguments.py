"""What people hand to the functions of qRobot from Python: taken as meant, or one sentence."""

from __future__ import annotations

import inspect
import json
import math
from pathlib import Path
from typing import Any

import dimod
import numpy as np
import pytest
from oracles import paper_shaped

import qrobot
from qrobot._parameters import Parameter, near
from qrobot.backends import get, names
from qrobot.backends.registry import available
from qrobot.models import build_model, model_for
from qrobot.models.export import export_model
from qrobot.planning import estimate, solve, submit
from qrobot.planning.strategy import ARGUMENTS

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "paper-4-items.json"


def refusal(function: Any, *given: Any, **named: Any) -> str:
    with pytest.raises(qrobot.InputError) as caught:
        function(*given, **named)
    text = str(caught.value)
    assert "\n" not in text
    assert caught.value.advice
    return text


# -- paths in place of what they hold ---------------------------------------------------------


@pytest.mark.parametrize("kind", [str, Path])
def test_every_function_takes_the_path_of_an_instance(kind: type, tmp_path: Path) -> None:
    path = kind(EXAMPLE)
    result = solve(path, backend="exact")
    assert result.instance == qrobot.read(EXAMPLE)
    assert result.cost == solve(qrobot.read(EXAMPLE), backend="exact").cost
    plan = kind(tmp_path / "plan.json")
    result.save(plan)
    for answer in (plan, result.plan, result):
        assert qrobot.check(answer, path).ok
        assert qrobot.check(answer, result.instance).ok
    assert estimate(path, "neal").usd == 0
    assert build_model(path).num_variables == build_model(result.instance).num_variables
    assert model_for(path, "paper").encoding == "reduced"
    assert (
        export_model(path, tmp_path / "model.coo")["variables"] == build_model(path).num_variables
    )
    qrobot.write(path, tmp_path / "copy.json")
    assert qrobot.read(tmp_path / "copy.json") == result.instance
    pytest.importorskip("matplotlib")
    for name, answer in (("a.svg", plan), ("b.svg", result.plan)):
        qrobot.plot(answer, tmp_path / name, path)
        assert (tmp_path / name).read_text().lstrip().startswith("<?xml")


@pytest.mark.parametrize("wrong", [None, 5, {"items": []}, [1], b"file.json", object()])
def test_anything_else_is_refused_by_every_function(wrong: Any, tmp_path: Path) -> None:
    instance = qrobot.read(EXAMPLE)
    plan = solve(instance, backend="exact").plan
    for function in (
        solve,
        build_model,
        model_for,
        lambda one: qrobot.check(plan, one),
        lambda one: estimate(one, "neal"),
        lambda one: submit(one, "dwave-qpu"),
        lambda one: export_model(one, tmp_path / "model.coo"),
        lambda one: qrobot.write(one, tmp_path / "out.json"),
    ):
        told = refusal(function, wrong)
        assert f"an object of class {type(wrong).__name__} is not an instance" in told
        assert "qrobot.read" in told
    assert "is not a plan" in refusal(qrobot.check, wrong, instance)
    assert "is not a path" in refusal(qrobot.read, wrong)
    for function in (
        solve(instance, backend="exact").save,
        lambda path: qrobot.write(instance, path),
        lambda path: export_model(instance, path),
        lambda path: qrobot.plot(plan, path, instance),
    ):
        assert "is not a path" in refusal(function, wrong)
    assert "is empty" in refusal(qrobot.read, "")
    assert not list(tmp_path.iterdir())


def test_what_is_exchanged_is_told() -> None:
    instance = qrobot.read(EXAMPLE)
    result = solve(instance, backend="exact")
    assert "class Instance is not a plan" in refusal(qrobot.check, instance, result.plan)
    assert "class Plan is not an instance" in refusal(solve, result.plan)
    assert "missing.json" in refusal(solve, "missing.json")
    assert "missing.json" in refusal(qrobot.check, "missing.json", instance)


# -- arguments ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        *[("deadline", value) for value in ("5", 0, -1, math.nan, math.inf, True, [5])],
        *[("max_work", value) for value in (2.5, "5", 0, -1, True, math.nan)],
        *[("seed", value) for value in (1.5, "1", -1, True, None, math.nan)],
        *[("max_cost", value) for value in ("1", -1, math.nan, math.inf, True)],
        *[("backend", value) for value in (None, 5, "", ["neal"])],
        *[("fallback", value) for value in (5, "", ["neal"])],
        *[("control", value) for value in (None, 5, "yes")],
        *[("stop", value) for value in (5, "now", True)],
        *[("on_progress", value) for value in (5, "print")],
    ],
)
def test_arguments_of_the_wrong_kind_are_refused_by_name(name: str, wrong: Any) -> None:
    told = refusal(solve, qrobot.read(EXAMPLE), **{name: wrong})
    assert told.startswith(f"{name}: {wrong!r} is not ")


def test_all_arguments_of_solve_are_declared() -> None:
    own = {
        name for name, p in inspect.signature(solve).parameters.items() if p.kind is p.KEYWORD_ONLY
    }
    assert own == set(ARGUMENTS)


def test_numbers_of_numpy_are_numbers() -> None:
    result = solve(
        EXAMPLE,
        backend="neal",
        seed=np.int64(3),
        max_work=np.int32(20),
        deadline=np.float64(5),
        num_reads=np.int16(5),
        beta_range=np.array([0.1, 3.0]),
    )
    assert json.loads(json.dumps(result.to_dict()))["result"]["seed"] == 3


BACKENDS = ["auto", *[name for name in names() if available(name)]]


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_mistyped_argument_gets_the_near_name_from_every_backend(backend: str) -> None:
    instance = paper_shaped(3, 1, 0)
    for mistyped, meant in (("dead_line", "deadline"), ("maxwork", "max_work"), ("sed", "seed")):
        told = refusal(solve, instance, backend=backend, **{mistyped: 3})
        assert f"backend {backend} takes no option {mistyped}" in told
        assert f"did you mean {meant}?" in told
    assert "did you mean" not in refusal(solve, instance, backend=backend, colour="red")


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_mistyped_option_gets_the_near_name_from_every_sampler(backend: str) -> None:
    chosen = None if backend == "auto" else get(backend)
    if not isinstance(chosen, dimod.Sampler):
        return
    bqm = dimod.BinaryQuadraticModel({"a": -1.0}, {}, 0.0, "BINARY")
    for name in chosen.parameters:
        mistyped = f"{name[:-1]}_"
        assert f"did you mean {name}?" in refusal(chosen.sample, bqm, **{mistyped: 1})
        told = refusal(solve, paper_shaped(3, 1, 0), backend=backend, **{mistyped: 1})
        assert f"did you mean {name}?" in told
    cqm = dimod.ConstrainedQuadraticModel()
    assert "convert it with dimod.cqm_to_bqm" in refusal(chosen.sample, cqm)
    assert "sample_qubo" in refusal(chosen.sample, {("a", "a"): 1.0})


# -- the mechanism ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameter", "right", "wrong"),
    [
        (Parameter("whole", 1, 3), [1, 3, np.int8(2), None], [0, 4, 1.0, "1", True, 10**400]),
        (Parameter("whole", 0), [0, 2**70], [-1, math.inf]),
        (Parameter("number", 0, 1, above=True), [1, 0.5, np.float32(1)], [0, 1.1, math.nan, 1j]),
        (Parameter("number"), [-1e300, 5], [math.inf, "5", None.__class__, [5]]),
        (Parameter("numbers", 0, length=2), [[0, 1], (2, 3), np.ones(2)], [[1], [1, -1], "12"]),
        (Parameter("numbers"), [[], np.zeros(3)], [{"a": 1}, np.float64(1), {1, 2}, [math.nan]]),
        (Parameter("pairs"), [[[0, 1], [2, 3]], []], [[0, 1], [[0, 1, 2]], "ab", 5]),
        (Parameter("flag"), [True, False, np.True_], [0, 1, "true"]),
        (Parameter("choice", choices=("a", "b")), ["a"], ["c", 1, ["a"], "A"]),
        (Parameter("text"), ["a"], ["", "  ", 5, b"a"]),
        (Parameter("names"), [{}, {"a": [1]}], [[], "a", {1: 2}]),
        (Parameter("function"), [print], [5, "print"]),
        (Parameter("number", 0, also=(dict,)), [1, {"a": 1}], [-1, []]),
        (Parameter("whole", optional=False), [1], [None]),
    ],
)
def test_parameters_take_what_they_declare(
    parameter: Parameter, right: list[Any], wrong: list[Any]
) -> None:
    for value in right:
        parameter.check("colour", value)
    for value in wrong:
        told = refusal(parameter.check, "colour", value)
        assert told.startswith("colour: ")
        assert f"is not {parameter.allowed}" in told
        assert len(told) < 300


def test_near_names() -> None:
    known = ["deadline", "max_work", "num_reads"]
    assert near("dead_line", known) == "did you mean deadline?"
    assert near("DeadLine", known) == "did you mean deadline?"
    assert near("reads", known) == "did you mean num_reads?"
    assert near("colour", known) == ""
