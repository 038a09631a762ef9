"""A run as a report: who ran, when, where; how one is read back, and the JSON Schema of all."""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from typing import Any

from qrobot._files import StrPath, read_text
from qrobot._text import printable
from qrobot._version import __version__
from qrobot.errors import InputError
from qrobot.health.model import SCHEMA, CheckResult, Finding, Report
from qrobot.health.system import Machine, board_model

__all__ = ["Stopwatch", "make_report", "read_report", "schema_text"]

LONGEST = 255
"""Letters of a host's name; the Domain Name System allows no more."""

DIGITS, LARGEST = 18, 1e100
"""Of a whole number, and the absolute value of any other: beyond, sums and ratios overflow."""

ADVICE = "give a file that qrobot health --output wrote"


class Stopwatch:
    """When a run began, by the calendar and by a clock that is never set."""

    def __init__(self) -> None:
        self.made = datetime.now(UTC).isoformat(timespec="seconds")
        self._begun = time.monotonic()

    def seconds(self) -> float:
        """Return the wall-clock time since the beginning."""
        return round(time.monotonic() - self._begun, 3)


def make_report(
    results: Sequence[CheckResult],
    findings: Sequence[Finding] = (),
    *,
    clock: Stopwatch | None = None,
    profile: str = "all",
    required: bool = False,
) -> Report:
    """Return what was found, with who found it, when and where; `clock` began with the run."""
    clock = clock or Stopwatch()
    machine = Machine()
    return Report(
        qrobot=__version__,
        python=platform.python_version(),
        made=clock.made,
        host=platform.node().encode(errors="replace").decode() or "unknown",
        machine_id=machine.identity(),
        machine=platform.machine(),
        model=board_model(machine),
        profile=profile,
        required=required,
        seconds=clock.seconds(),
        system=tuple(findings),
        checks=tuple(results),
    )


def read_report(path: StrPath) -> Report:
    """Read a report that ``qrobot health --output`` wrote.

    Raises
    ------
    InputError
        When the file cannot be read, is not JSON, not a report of health, or of a newer qRobot;
        in one sentence, with the field.
    """
    from pydantic import ValidationError

    text = read_text(path)

    def refused(problem: str, field: str | None = None, advice: str = ADVICE) -> InputError:
        return InputError(problem, source=str(path), field=field, advice=advice)

    try:
        data = json.loads(
            text, parse_int=_read_int, parse_float=_read_float, parse_constant=_read_float
        )
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise refused(f"is not JSON: {error.msg}", where) from None
    except (RecursionError, ValueError):  # nested without end, or a number beyond all bounds
        raise refused("is not a report") from None
    schema = data.get("schema") if isinstance(data, dict) else None
    if schema != SCHEMA:
        raise refused(_wrong_schema(schema), "schema", _schema_advice(schema))
    try:
        found: Report = _adapter().validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        field = printable(".".join(map(str, first["loc"])))
        raise refused(first["msg"][:1].lower() + first["msg"][1:], field or None) from None
    try:
        made = datetime.fromisoformat(found.made)
        if made.tzinfo is None:
            raise ValueError
        made.astimezone(UTC)
    except (ValueError, OverflowError):  # OverflowError: in UTC the year is below 1
        raise refused(f"{found.made[:40]!r} is not a time with its zone", "made") from None
    if len(found.host) > LONGEST:
        raise refused(f"a name of {len(found.host)} letters is not that of a host", "host")
    return found


def _read_int(text: str) -> int:
    if len(text.lstrip("-")) > DIGITS:
        raise ValueError
    return int(text)


def _read_float(text: str) -> float:
    number = float(text)
    if not abs(number) <= LARGEST:  # nor NaN
        raise ValueError
    return number


def _schema_number(schema: object) -> int | None:
    name, _, number = str(schema).partition("/")
    own = SCHEMA.partition("/")[0]
    return int(number) if name == own and number.isdecimal() and len(number) < 9 else None


def _wrong_schema(schema: object) -> str:
    if _schema_number(schema) is not None:
        return f"{schema} is not {SCHEMA}, which this qRobot reads"
    return f"is not a report of qrobot health (this field must be {SCHEMA!r})"


def _schema_advice(schema: object) -> str:
    newer = (_schema_number(schema) or 0) > (_schema_number(SCHEMA) or 0)
    return "update qRobot, or make the report anew with this one" if newer else ADVICE


@cache
def _adapter() -> Any:
    from pydantic import TypeAdapter  # here: only who reads a report needs it

    return TypeAdapter(Report)


def schema_text() -> str:
    """Return the schema as it is shipped."""
    return (resources.files("qrobot.health") / "report.schema.json").read_text(encoding="utf-8")
