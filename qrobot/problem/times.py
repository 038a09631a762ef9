"""How long the parts of a trip take beside driving."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

from qrobot.errors import InputError
from qrobot.problem.entities import Item, Order

__all__ = ["Times", "check_available", "check_order_times"]

MAX_SECONDS = 1e6
"""More than a week for one act is a mistake."""

MAX_CLOCK = 1e9
"""Seconds from the start of all robots; times of the day since 1970 are a mistake."""

MAX_PRIORITY = 1e6


@dataclass(frozen=True, slots=True)
class Times:
    """Seconds that every robot needs beside driving; an item's ``pick_seconds`` come on top.

    Parameters
    ----------
    per_trip
        Set-up of a trip, before the robot leaves: an empty trolley, totes, labels.
    per_pick
        Of each item that is collected, however many pieces.
    per_piece
        Of each piece of an item.
    per_level
        Of each level above the floor that an item lies on.

    Raises
    ------
    InputError
        When one is not a number from 0 to 1e6.
    """

    per_trip: float = 0.0
    per_pick: float = 0.0
    per_piece: float = 0.0
    per_level: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and 0 <= value <= MAX_SECONDS):
                raise InputError(
                    f"{value:g} seconds are not 0 to {MAX_SECONDS:g}",
                    field=f"times.{field.name}",
                    advice="give seconds",
                )

    def of(self, item: Item) -> float:
        """Return how long a robot stands to collect an item, seconds."""
        return (
            item.pick_seconds
            + self.per_pick
            + self.per_piece * item.quantity
            + self.per_level * item.level
        )


def check_available(seconds: float, robot: str, field: str) -> None:
    """Refuse a robot that is available at no time that can be."""
    if not 0 <= seconds < MAX_CLOCK:
        raise InputError(
            f"available {seconds:g} of robot {robot!r} is not 0 to {MAX_CLOCK:g}",
            field=field,
            advice="give seconds from the moment when all robots begin",
        )


def check_order_times(orders: Sequence[Order]) -> None:
    """Refuse times of orders that are out of range, or that nobody can keep."""
    for i, order in enumerate(orders):
        for name, least in (("release", 0.0), ("due", order.release), ("deadline", order.release)):
            value = getattr(order, name)
            if name != "release" and value == math.inf:
                continue
            if not 0 <= value < MAX_CLOCK:
                raise InputError(
                    f"{name} {value:g} of order {order.id!r} is not 0 to {MAX_CLOCK:g}",
                    field=f"orders[{i}].{name}",
                    advice="give seconds from the moment when all robots begin",
                )
            if value < least:
                raise InputError(
                    f"{name} {value:g} of order {order.id!r} is before its release {least:g}",
                    field=f"orders[{i}].{name}",
                    advice="correct one of them",
                )
        if not 0 <= order.priority <= MAX_PRIORITY:
            raise InputError(
                f"priority {order.priority:g} of order {order.id!r} is not 0 to {MAX_PRIORITY:g}",
                field=f"orders[{i}].priority",
                advice="give what a second of its lateness counts, usually 1",
            )
