"""Options that limit what a check may take."""

from __future__ import annotations

import math

import click

__all__ = ["Limit"]


class Limit(click.FloatRange):
    """A finite number above zero: with ``nan`` or ``inf`` there would be no limit."""

    def __init__(self) -> None:
        super().__init__(min=0, min_open=True)

    def convert(
        self, value: str | float, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number."""
        number = float(super().convert(value, param, ctx))  # type: ignore[arg-type]
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number
