"""The published JSON Schema is the models', and says what the reader does."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from strategies import instances

import qrobot
from qrobot.problem.formats.native import to_text
from qrobot.problem.formats.schema import json_schema

PUBLISHED = Path(qrobot.__file__).parent / "problem" / "instance.schema.json"
EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.json"))
ON_MAPS = sorted((Path(__file__).parents[2] / "examples/maps").glob("on-*.json"))
VALIDATOR = jsonschema.Draft202012Validator(json.loads(PUBLISHED.read_text()))


def test_the_published_schema_is_up_to_date() -> None:
    made = json.dumps(json_schema(), indent=1) + "\n"
    assert made == PUBLISHED.read_text(), (
        "run: python -m qrobot.problem.formats.schema > qrobot/problem/instance.schema.json"
    )


def test_the_published_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(json.loads(PUBLISHED.read_text()))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.name)
def test_every_example_is_valid(path: Path) -> None:
    VALIDATOR.validate(json.loads(path.read_text()))


@pytest.mark.parametrize("path", ON_MAPS, ids=lambda p: p.name)
def test_examples_on_maps_are_valid_as_they_are_and_written_whole(path: Path) -> None:
    VALIDATOR.validate(json.loads(path.read_text()))
    VALIDATOR.validate(json.loads(to_text(qrobot.read(path))))


@settings(max_examples=50, deadline=None)
@given(instances(multi_trip=True))
def test_whatever_is_written_is_valid(one: qrobot.Instance) -> None:
    VALIDATOR.validate(json.loads(to_text(one)))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("schema",), "qrobot.instance/2"),
        (("colour",), "red"),
        (("warehouse", "kind"), "hall"),
        (("warehouse", "aisles"), 0),
        (("warehouse", "aisle_pitch"), "3"),
        (("robots", "count"), 0),
        (("robots", "capacity"), 0),
        (("items", 0, "weight"), -1),
        (("items", 0, "weight"), "8 kg"),
        (("items", 0, "at"), {"x": 1}),
        (("items", 0, "at"), {"x": 1, "y": 1, "node": 1}),
        (("items", 0, "id"), ""),
        (("orders", 0, "items"), []),
    ],
)
def test_an_editor_sees_the_common_faults(path: tuple[str | int, ...], value: object) -> None:
    document: Any = json.loads(next(p for p in EXAMPLES if "small" in p.name).read_text())
    VALIDATOR.validate(document)
    target = document = copy.deepcopy(document)
    for part in path[:-1]:
        target = target[part]
    target[path[-1]] = value
    assert not VALIDATOR.is_valid(document)


def test_an_editor_may_be_told_the_schema(tmp_path: Path) -> None:
    document = json.loads(EXAMPLES[0].read_text()) | {"$schema": "./instance.schema.json"}
    VALIDATOR.validate(document)
