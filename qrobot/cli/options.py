"""Options that several commands share."""

from __future__ import annotations

import json
import re
from typing import Any

import click

from qrobot.errors import InputError

__all__ = ["FILE", "Robots", "Setting", "ignore_columns", "rounding", "seconds"]

FILE = click.Path(readable=False)
"""A path; who may not read it is told by whoever reads, with the mend."""


rounding = click.option("--rounding", help="Of a .vrp file's distances: none, nearest, up or down.")


def _names(_ctx: click.Context, _param: click.Parameter, value: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name.strip() for text in value for name in text.split(",") if name.strip())


ignore_columns = click.option(
    "--ignore-columns",
    multiple=True,
    callback=_names,
    help="Columns of CSV orders that are not ours, with commas.",
)


class Robots(click.ParamType[int | str]):
    """A number of robots, or ``free`` for as many as wanted."""

    name = "N|free"

    def convert(
        self, value: str | int, _param: click.Parameter | None, _ctx: click.Context | None
    ) -> int | str:
        """Return the number or ``free``."""
        if value == "free":
            return "free"
        if isinstance(value, int) or re.fullmatch(r"[-+]?[0-9]{1,12}", value):
            return int(value)
        raise InputError(
            f"{value!r:.40} is not a number of robots",
            field="--robots",
            mend="give 1 or more, or 'free'",
        )


OWN_FLAGS = {
    **{name: f"use --{name}" for name in ("backend", "control", "deadline", "fallback", "seed")},
    "max_cost": "use --max-cost",
    "max_work": "use --max-work",
    "dry_run": "use --dry-run",
    "wait": "use --no-wait",
    **dict.fromkeys(
        ("instance", "stop", "on_progress", "interrupt_function", "context"), "leave it out"
    ),
}
"""What is set in another way, or not from a command line at all."""


class Setting(click.ParamType[tuple[str, Any]]):
    """An option of a sampler: ``name=value``, the value as JSON or else as text."""

    name = "NAME=VALUE"

    def convert(
        self,
        value: str | tuple[str, Any],
        _param: click.Parameter | None,
        _ctx: click.Context | None,
    ) -> tuple[str, Any]:
        """Return the name and the value."""
        if isinstance(value, tuple):
            return value
        name, equals, text = value.partition("=")
        if not (equals and name.isidentifier()):
            raise InputError(
                f"{value!r} sets nothing", field="--option", mend="write it as name=value"
            )
        if name in OWN_FLAGS:
            raise InputError(
                f"{name} is no option of a sampler here", field="--option", mend=OWN_FLAGS[name]
            )
        try:
            return name, json.loads(text)
        except ValueError:
            return name, text


def seconds(value: float) -> str:
    """Return seconds as people write them."""
    return f"{value:.2f} s" if value < 10 else f"{value:.0f} s"
