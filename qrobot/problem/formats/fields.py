"""The types of single fields in native JSON, with refusals in our own words.

Nothing is converted silently: text is no number, ``true`` is not 1, and weights keep the
digits that they are written with.
"""

from __future__ import annotations

import json
import math
from decimal import Decimal
from fractions import Fraction
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    WithJsonSchema,
)
from pydantic_core import PydanticCustomError

from qrobot.errors import InputError
from qrobot.problem.checks import canonical, first_invisible
from qrobot.problem.fleets import NO_LIMIT
from qrobot.problem.units import MAX_WEIGHT, exact, number_advice

__all__ = [
    "Capacity",
    "Count",
    "Index",
    "Length",
    "Matrix",
    "Name",
    "Number",
    "Positive",
    "Trips",
    "Volume",
    "Weight",
    "quoted",
    "refuse",
    "shown",
]


def refuse(problem: str, advice: str, *, at: str = "") -> PydanticCustomError:
    """Return an error with our own words; `at` continues the path of the field."""
    return PydanticCustomError(
        "qrobot", "{problem}", {"problem": problem, "advice": advice, "at": at}
    )


def shown(value: object) -> str:
    """Return a value as its JSON text, cut short; containers only by their kind."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, list | dict):
        return "an object" if isinstance(value, dict) else "a list" if value else "an empty list"
    text = quoted(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f"{text[:56]}..."


def quoted(text: str) -> str:
    """Return a text in quotes, on one line whatever it holds."""
    return json.dumps(text, ensure_ascii=not text.isprintable())


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        raise refuse(f"{shown(value)} is not a number", "give a plain number")
    number = float(value)
    if not math.isfinite(number):
        raise refuse(f"{shown(value)} is too large", "use a larger unit")
    return number


def _visible(value: str) -> str:
    """Return a name in its composed form, refusing what cannot be seen in it."""
    if (hidden := first_invisible(value)) is not None:
        raise refuse(f"{shown(value)} holds the invisible character {hidden}", "remove it")
    return canonical(value)


def _whole(value: Any) -> Any:
    """Take 3.0 for 3, as JSON Schema does."""
    if isinstance(value, float | Decimal):
        near = float(value)
        return int(near) if near == value and near.is_integer() and abs(near) < 1e15 else value
    return value


def _exact(value: Any) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        advice = number_advice(value) if isinstance(value, str) else ""
        advice = (
            f"{advice}, without quotes" if advice.startswith("write ") else "give a plain number"
        )
        raise refuse(f"{shown(value)} is not a number", advice)
    try:
        return exact(value, field="")
    except InputError as error:
        raise refuse(error.problem, error.advice or "") from None


def _matrix(value: Any) -> tuple[tuple[float, ...], ...]:
    """Check millions of entries without a model each; the diagonal may hold any number."""
    if not isinstance(value, list):
        raise refuse(f"{shown(value)} is not a list of rows", "give one list per row")
    rows = []
    for i, row in enumerate(value):
        if not isinstance(row, list):
            raise refuse(f"{shown(row)} is not a row", "give one list per row", at=f"[{i}]")
        numbers = []
        for j, entry in enumerate(row):
            kind = type(entry)
            number = math.inf if entry is None else math.nan
            if kind is int or kind is float or kind is Decimal:
                number = float(entry)
            if number != number or (number == math.inf and entry is not None and i != j):
                raise refuse(
                    f"{shown(entry)} is not a distance",
                    "give a number, or null where no way leads directly",
                    at=f"[{i}][{j}]",
                )
            numbers.append(number)
        rows.append(tuple(numbers))
    return tuple(rows)


Number = Annotated[float, BeforeValidator(_number)]
Length = Annotated[float, Field(ge=0), BeforeValidator(_number)]
Positive = Annotated[float, Field(gt=0), BeforeValidator(_number)]
Index = Annotated[int, Field(ge=0), BeforeValidator(_whole)]
Trips = Annotated[
    int,
    Field(ge=1),
    BeforeValidator(lambda value: NO_LIMIT if value == "free" else _whole(value)),
    WithJsonSchema({"anyOf": [{"type": "integer", "minimum": 1}, {"const": "free"}]}),
]
Count = Annotated[int, Field(ge=1), BeforeValidator(_whole)]
# Names end up in tables on terminals: no control characters, no line ends.
Name = Annotated[
    str,
    Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]+$"),
    AfterValidator(_visible),
]
Weight = Annotated[
    Fraction,
    PlainValidator(_exact),
    WithJsonSchema({"type": "number", "minimum": 0, "maximum": MAX_WEIGHT}),
]
Volume = Annotated[
    Fraction,
    PlainValidator(_exact),
    WithJsonSchema({"type": "number", "minimum": 0, "maximum": MAX_WEIGHT, "default": 0}),
]
Capacity = Annotated[
    Fraction,
    PlainValidator(_exact),
    WithJsonSchema({"type": "number", "exclusiveMinimum": 0, "maximum": MAX_WEIGHT}),
]
Matrix = Annotated[
    tuple[tuple[float, ...], ...],
    PlainValidator(_matrix),
    WithJsonSchema(
        {
            "type": "array",
            "minItems": 1,
            "items": {"type": "array", "items": {"type": ["number", "null"], "minimum": 0}},
        }
    ),
]
