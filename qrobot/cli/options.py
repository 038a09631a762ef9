"""Options that several commands share."""

from __future__ import annotations

import click

from qrobot.errors import InputError

__all__ = ["Robots", "seconds"]


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


def seconds(value: float) -> str:
    """Return seconds as people write them."""
    return f"{value:.2f} s" if value < 10 else f"{value:.0f} s"
