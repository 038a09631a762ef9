"""Options that several commands share."""

from __future__ import annotations

import json
from typing import Any

import click

from qrobot.errors import InputError

__all__ = ["FILE", "Robots", "Setting", "seconds"]

FILE = click.Path(readable=False)
"""A path; who may not read it is told by whoever reads, with the mend."""


class Robots(click.ParamType[int | str]):
    """A number of robots, or ``free`` for as many as wanted."""

    name = "N|free"

    def convert(
        self, value: str | int, _param: click.Parameter | None, _ctx: click.Context | None
    ) -> int | str:
        """Return the number or ``free``."""
        if value == "free":
            return "free"
        try:
            return int(value)
        except ValueError:
            raise InputError(
                f"{value!r} is no number of robots",
                field="--robots",
                mend="give 1 or more, or 'free'",
            ) from None


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
