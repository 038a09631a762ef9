"""What is collected, where else it lies, and who collects: items, orders, stock, robots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from qrobot.errors import InputError
from qrobot.problem.checks import canonical
from qrobot.problem.units import Quantity, exact
from qrobot.problem.warehouse import Place

__all__ = ["Item", "Order", "Robot", "Stock"]


@dataclass(frozen=True, slots=True)
class Item:
    """One thing to collect, from one place.

    Parameters
    ----------
    id
        Unique name; kept in Unicode's composed form (NFC), so that names that look the same
        are the same.
    weight
        Weight, kg by convention. Numbers and text count as the decimal that they are written
        as; the field is an exact fraction.
    place
        Where it lies.
    pick_seconds
        How long it takes to collect it there.
    quantity
        How many pieces it is; weight and time are of all of them together.
    article
        What the article is called where several items are of one; empty: as the item.
    level
        Levels above the floor, for `Times.per_level`.
    """

    id: str
    weight: Fraction
    place: Place
    pick_seconds: float = 0.0
    quantity: int = 1
    article: str = ""
    level: int = 0

    if TYPE_CHECKING:  # what is taken is wider than what is kept

        def __init__(
            self,
            id: str,
            weight: Quantity,
            place: Place,
            pick_seconds: float = 0.0,
            quantity: int = 1,
            article: str = "",
            level: int = 0,
        ) -> None: ...

    def __post_init__(self) -> None:
        """Keep the names' composed form, and a number as the decimal that it is written as."""
        object.__setattr__(self, "id", canonical(self.id))
        object.__setattr__(self, "article", canonical(self.article))
        if not isinstance(self.weight, Fraction):
            object.__setattr__(self, "weight", exact(self.weight, field="weight"))


@dataclass(frozen=True, slots=True)
class Order:
    """A whole lot of items that stay together on one trip.

    Parameters
    ----------
    id
        Unique name.
    items
        Ids of its items.
    release
        When its trip may leave at the earliest, seconds: what is not in yet, or cannot be
        prepared yet.
    due
        When it should be back at the depot, seconds; what comes later is its lateness.
    deadline
        When it must be back; no plan brings it later.
    priority
        What a second of its lateness counts.
    """

    id: str
    items: tuple[str, ...]
    release: float = 0.0
    due: float = math.inf
    deadline: float = math.inf
    priority: float = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            id: str,
            items: Sequence[str],
            release: float = 0.0,
            due: float = math.inf,
            deadline: float = math.inf,
            priority: float = 1.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        """Keep the ids of any sequence as a tuple, in their composed form."""
        if isinstance(self.items, str):
            raise InputError(
                f"{self.items!r} is one text, not several ids",
                field="items",
                advice="give a tuple of ids",
            )
        object.__setattr__(self, "id", canonical(self.id))
        object.__setattr__(self, "items", tuple(map(canonical, self.items)))


@dataclass(frozen=True, slots=True)
class Stock:
    """The pieces of an article that lie in one place.

    Parameters
    ----------
    article
        Name of the article, as items have it.
    place
        Where the pieces lie.
    quantity
        How many there are.
    """

    article: str
    place: Place
    quantity: int

    def __post_init__(self) -> None:
        """Keep the name's composed form."""
        object.__setattr__(self, "article", canonical(self.article))


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot that collects.

    Parameters
    ----------
    id
        Unique name.
    capacity
        Largest load of one trip, in the unit of the weights; taken as an item's weight is.
    speed
        Metres a second, for times in reports; distances do not depend on it.
    trips
        The most trips the robot may make.
    """

    id: str
    capacity: Fraction
    speed: float = 1.0
    trips: int = 1

    if TYPE_CHECKING:

        def __init__(
            self, id: str, capacity: Quantity, speed: float = 1.0, trips: int = 1
        ) -> None: ...

    def __post_init__(self) -> None:
        """Keep the name's composed form, and a number as the decimal that it is written as."""
        object.__setattr__(self, "id", canonical(self.id))
        if not isinstance(self.capacity, Fraction):
            object.__setattr__(self, "capacity", exact(self.capacity, field="capacity"))
