"""The report as JSON: its schema, and what of it can be read back."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from health import samples
from health.report_schema import json_schema
from hypothesis import given
from hypothesis import strategies as st

import qrobot
from qrobot.errors import InputError
from qrobot.health import SCHEMA, read_report
from qrobot.health.record import schema_text
from qrobot.health.reports import as_json, compare

VALIDATOR = jsonschema.Draft202012Validator(
    json.loads(schema_text()), format_checker=jsonschema.FormatChecker()
)


def written(tmp_path: Path, data: Any) -> Path:
    path = tmp_path / "report.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return path


def test_the_shipped_schema_is_the_models() -> None:
    assert json.dumps(json_schema(), indent=1) + "\n" == schema_text(), (
        "run: PYTHONPATH=tests python -m health.report_schema > qrobot/health/report.schema.json"
    )
    jsonschema.Draft202012Validator.check_schema(json.loads(schema_text()))


def test_a_report_is_valid_and_comes_back_as_it_was(tmp_path: Path) -> None:
    one = samples.report()
    one = samples.changed(one, "numpy", status="error", run_seconds=None, answer=None)
    data = json.loads(as_json(one))
    VALIDATOR.validate(data)
    assert read_report(written(tmp_path, data)) == one
    data = json.loads(as_json(one, compare(samples.report(), one)))
    VALIDATOR.validate(data)
    assert read_report(written(tmp_path, data)) == one


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("schema",), "qrobot.health/2"),
        (("made",), 5),
        (("host",), None),
        (("healthy",), "yes"),
        (("totals", "pass"), -1),
        (("checks", 0, "status"), "fine"),
        (("checks", 0, "versions"), ["1.2"]),
        (("checks", 0, "answer"), ["1"]),
        (("checks", 0, "run_seconds"), "fast"),
        (("system", 0, "status"), "fail"),
        (("system", 0, "value"), {"a": 1}),
    ],
)
def test_what_is_not_a_report_is_not_valid(path: tuple[Any, ...], value: Any) -> None:
    data = json.loads(as_json(samples.report()))
    where = data
    for step in path[:-1]:
        where = where[step]
    where[path[-1]] = value
    assert not VALIDATOR.is_valid(data)


def test_no_field_may_be_missing() -> None:
    data = json.loads(as_json(samples.report()))
    for field in data:
        assert not VALIDATOR.is_valid({k: v for k, v in data.items() if k != field}), field


def test_fields_of_later_versions_are_borne(tmp_path: Path) -> None:
    data = json.loads(as_json(samples.report()))
    data["colour"] = data["checks"][0]["colour"] = data["system"][0]["colour"] = "red"
    VALIDATOR.validate(data)
    assert read_report(written(tmp_path, data)) == samples.report()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["is empty"]),
        ("{", ["is not JSON", "line 1"]),
        ("[" * 100_000, ["is not a report"]),
        ("[]", ["schema", "qrobot.health/1"]),
        ("3", ["schema"]),
        ('{"schema": "qrobot.plan/1"}', ["schema", "qrobot health --output"]),
        ('{"schema": "qrobot.health/2"}', ["qrobot.health/2 is not qrobot.health/1", "update"]),
        ('{"schema": "qrobot.health/99999999999999999999"}', ["schema"]),
        ('{"schema": ["qrobot.health/1"]}', ["schema"]),
        ('{"schema": "qrobot.health/1"}', ["qrobot: field required"]),
        ('{"schema": "qrobot.health/1", "seconds": NaN}', ["is not a report"]),
        ('{"schema": "qrobot.health/1", "seconds": 1e999}', ["is not a report"]),
        ('{"schema": "qrobot.health/1", "seconds": ' + "9" * 5000 + "}", ["is not a report"]),
    ],
)
def test_an_unreadable_baseline_is_one_sentence(
    tmp_path: Path, text: str, words: list[str]
) -> None:
    with pytest.raises(InputError) as error:
        read_report(written(tmp_path, text))
    said = str(error.value)
    assert "report.json" in said
    assert "\n" not in said
    for word in words:
        assert word in said


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("checks", 1, "status"), "fine", "checks.1.status"),
        (("checks", 1, "run_seconds"), "1", "checks.1.run_seconds"),
        (("made",), "yesterday", "'yesterday' is not a time with its zone"),
        (("made",), "2026-11-20T08:00:00", "is not a time with its zone"),
        (("made",), "0001-01-01T00:00:00+14:00", "is not a time with its zone"),
        (("made",), "9999-12-31T23:59:00-14:00", "is not a time with its zone"),
        (("system", 0, "value"), {"a": 1}, "system.0.value"),
        (("host",), 5, "host"),
        (("host",), "9" * 5000, "host: a name of 5000 letters"),
        (("system", 4, "value"), 10**4000, "is not a report"),
        (("seconds",), 1e200, "is not a report"),
        (("checks", 0, "versions"), {"\x1b[2J": 5}, "checks.0.versions.\ufffd[2J"),
    ],
)
def test_a_wrong_field_is_named(
    tmp_path: Path, path: tuple[Any, ...], value: Any, words: str
) -> None:
    data = json.loads(as_json(samples.report()))
    where = data
    for step in path[:-1]:
        where = where[step]
    where[path[-1]] = value
    with pytest.raises(InputError, match=r"give a file that qrobot health --output wrote") as error:
        read_report(written(tmp_path, data))
    assert words in str(error.value)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)


@given(field=st.sampled_from(sorted(samples.report().to_dict())), value=JSON)
def test_any_field_may_hold_anything(
    field: str, value: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = samples.report().to_dict() | {field: value}
    path = written(tmp_path_factory.mktemp("any"), data)
    try:
        found = read_report(path)
    except InputError:
        return  # refused in a sentence: no other error is allowed
    VALIDATOR.validate(json.loads(as_json(found)))


def test_totals_and_health_are_counted() -> None:
    one = samples.report()
    assert one.healthy
    assert one.totals == {
        "pass": 3, "fail": 0, "error": 0, "absent": 0, "good": 6, "warning": 1, "fault": 0,
        "unknown": 1,
    }  # fmt: skip
    absent = samples.changed(one, "numpy", status="absent")
    assert absent.healthy
    assert not replace(absent, required=True).healthy
    assert not samples.changed(one, "numpy", status="error").healthy
    assert not samples.found(one, "memory", status="fault").healthy


def test_a_number_that_is_not_finite_is_null() -> None:
    one = samples.changed(samples.report(), "numpy", answer=(math.inf, math.nan, 1.0))
    data = json.loads(as_json(one))
    assert data["checks"][0]["answer"] == [None, None, 1.0]
    VALIDATOR.validate(data)


def test_the_schema_is_part_of_the_package() -> None:
    assert (Path(qrobot.__file__).parent / "health" / "report.schema.json").is_file()
    assert json.loads(schema_text())["properties"]["schema"] == {"const": SCHEMA}
