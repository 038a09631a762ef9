"""The published JSON Schema of plans against what is written and what the reader takes."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import paper_shaped
from strategies import instances

import qrobot
from qrobot._json import json_text
from qrobot.plan import Plan
from qrobot.planning.result import Result, SamplerReport

PUBLISHED = Path(qrobot.__file__).parent / "plan" / "plan.schema.json"
SCHEMA = json.loads(PUBLISHED.read_text())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def fields_of(part: dict[str, Any]) -> set[str]:
    return set(part["properties"])


def test_it_is_a_schema_of_this_version() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert SCHEMA["properties"]["schema"]["const"] == "qrobot.plan/1"


@pytest.mark.parametrize(
    ("backend", "more"),
    [
        ("auto", {}),
        ("exact", {}),
        ("neal", {"control": True, "num_reads": 20}),
        ("neal", {"num_reads": 2, "num_sweeps": 1, "rounds": 1}),
        ("qaoa-swap", {}),
    ],
)
def test_whatever_solve_gives_is_valid_and_described(backend: str, more: dict[str, Any]) -> None:
    result = qrobot.solve(paper_shaped(5, 2, 1), backend=backend, max_work=20, **more)
    data = json.loads(json_text(result.to_dict()))
    VALIDATOR.validate(data)
    parts = SCHEMA["$defs"]
    assert set(data) == fields_of(SCHEMA)
    assert set(data["result"]) == fields_of(parts["result"])
    assert set(data["trips"][0]) == fields_of(parts["trip"])
    names = parts["result"]["properties"]["timing"]["propertyNames"]["enum"]
    assert set(data["result"]["timing"]) == set(names)
    if data["result"]["sampler"]:
        assert set(data["result"]["sampler"]) == fields_of(parts["sampler"])
    VALIDATOR.validate(result.plan.to_dict())


@settings(max_examples=30, deadline=None)
@given(instances(multi_trip=True))
def test_plans_of_any_instance_are_valid(instance: qrobot.Instance) -> None:
    try:
        plan = Plan.from_routes(instance, [list(nodes) for nodes in instance.order_nodes])
    except ValueError:
        return  # fewer robots than orders
    VALIDATOR.validate(json.loads(json.dumps(plan.to_dict())))


def test_what_has_no_word_in_json_is_null() -> None:
    instance = paper_shaped(3, 1, 0)
    good = qrobot.solve(instance, backend="exact")
    report = SamplerReport("x", "compact", 1, 0, 0.0, None, None, float("nan"))
    report.details = {"beta_range": [float("inf"), 1.0], "history": ({"a": -float("inf")},)}
    result = Result(instance, good.plan, 0.0, False, "x", sampler=report)
    data = json.loads(json_text(result.to_dict()))
    assert data["result"]["gap"] is None
    assert data["result"]["sampler"]["energy"] is None
    assert data["result"]["sampler"]["details"] == {
        "beta_range": [None, 1.0],
        "history": [{"a": None}],
    }
    VALIDATOR.validate(data)


WRITTEN = qrobot.solve(paper_shaped(4, 2, 0), backend="exact").plan.to_dict()


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("schema",), "qrobot.plan/2"),
        (("schema",), None),
        (("distance",), "far"),
        (("distance",), None),
        (("trips",), {}),
        (("trips", 0), "R1"),
        (("trips", 0, "robot"), 1),
        (("trips", 0, "stops"), "i1"),
        (("trips", 0, "stops", 0), 1),
        (("trips", 0, "orders"), None),
        (("trips", 0, "load"), "heavy"),
        (("trips", 0, "seconds"), "long"),
        (("instance",), 5),
    ],
)
def test_schema_and_reader_refuse_the_same(path: tuple[str | int, ...], value: Any) -> None:
    wrong = copy.deepcopy(WRITTEN)
    place: Any = wrong
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    assert not VALIDATOR.is_valid(wrong)
    with pytest.raises(qrobot.InputError):
        Plan.from_dict(wrong)


@given(st.data())
def test_schema_and_reader_need_the_same(data: st.DataObject) -> None:
    some = copy.deepcopy(WRITTEN)
    part = data.draw(st.sampled_from([some, some["trips"][0]]))
    del part[data.draw(st.sampled_from(sorted(part)))]
    if VALIDATOR.is_valid(some):
        Plan.from_dict(some)
    else:
        with pytest.raises(qrobot.InputError):
            Plan.from_dict(some)


def test_unknown_fields_are_passed_over_by_both() -> None:
    more = copy.deepcopy(WRITTEN) | {"colour": "red"}
    more["trips"][0]["picker"] = "Mira"
    VALIDATOR.validate(more)
    assert Plan.from_dict(more) == Plan.from_dict(WRITTEN)


def test_the_example_of_the_page_is_valid() -> None:
    page = (Path(__file__).parents[2] / "docs" / "formats.md").read_text()
    section = page[page.index("## Plans and results") :]
    text = section.split("```json\n")[1].split("```")[0]
    VALIDATOR.validate(json.loads(text))
    assert Plan.from_dict(json.loads(text)).trips[0].stops
