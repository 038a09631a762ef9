"""Plan files: read as strictly as instances, refused with one sentence and the place."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from native_documents import json_values, paths

import qrobot
from qrobot.errors import InputError
from qrobot.plan import Plan, read_plan
from qrobot.problem import Instance, Item, OpenFloor, Order, Point, Robot

ONE = Instance(
    OpenFloor(),
    (Item("a", 1, Point(3, 4)), Item("b", 2, Point(0, 1))),
    (Order("o", ("a", "b")),),
    (Robot("R1", 5),),
)
PLAN = Plan.from_routes(ONE, [[1, 2]]).to_dict()


def test_what_was_written_is_read(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(json.dumps(PLAN))
    assert read_plan(tmp_path / "plan.json") == Plan.from_routes(ONE, [[1, 2]])
    short = copy.deepcopy(PLAN)
    del short["trips"][0]["seconds"]
    assert qrobot.check(Plan.from_dict(short), ONE).ok


BAD = [
    ('"distance": 9.5', '"distance": 1' + "0" * 400, "not finite, or too large"),
    ('"distance": 9.5', '"distance": 1e400', "not finite, or too large"),
    ('"distance": 9.5', '"distance": NaN', "NaN is not a number in JSON"),
    ('"distance": 9.5', '"distance": -Infinity', "-Infinity is not a number in JSON"),
    ('"distance": 9.5', '"distance": true', "True is not a number"),
    ('"distance": 9.5', '"distance": "9.5"', "'9.5' is not a number"),
    ('"distance": 9.5', '"distance": 9.5, "distance": 7', "'distance' is given twice"),
    ('"load": 3.0', '"load": 1e-400000000000000000000', "is not a finite number"),
    ('"load": 3.0', '"load": null', "None is not a number"),
    ('"stops": [', '"stops": "ab", "x": [', "'ab' is not a list"),
    ('"stops": [', '"stops": [7, ', "7 is not text"),
    ('"split_orders": false', '"split_orders": "no"', "'no' is not true or false"),
    ('"trips": [', '"trips": 3, "more": [', "3 is not a list"),
    ('"trips": [', '"trips": [3, ', "not an object"),
    ('"schema": "qrobot.plan/1"', '"schema": "qrobot.plan/2"', "unknown schema"),
    ('"robot": "R1",', "", "is missing"),
    ("}", "", "broken JSON in line"),
]


@pytest.mark.parametrize(("old", "new", "says"), BAD)
def test_a_malformed_plan_is_one_sentence_with_its_place(
    tmp_path: Path, old: str, new: str, says: str
) -> None:
    text = json.dumps(PLAN | {"distance": 9.5}, indent=1)
    assert old in text
    path = tmp_path / "plan.json"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        read_plan(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert says in said
    assert re.search(r"line \d+, column \d+", said), said
    assert "; " in said
    assert len(said) < 400


@given(st.sampled_from(paths(PLAN)), json_values, st.booleans())
def test_no_plan_gets_a_traceback(path: tuple[Any, ...], value: object, remove: bool) -> None:
    data = json.loads(json.dumps(PLAN))
    target = data
    for part in path[:-1]:
        target = target[part]
    if remove:
        del target[path[-1]]
    else:
        target[path[-1]] = value
    advice: str | None = "none is needed"
    try:
        report = qrobot.check(Plan.from_dict(data), ONE)
        json.dumps(report.to_dict(), allow_nan=False)
    except InputError as error:
        advice = error.advice
    assert advice
