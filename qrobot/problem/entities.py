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

__all__ = ["Item", "Order", "Robot", "Stock", "picked"]


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
        Shelves above the floor, for `Times.per_level`: one slot may have bins above each other.
    label
        What the warehouse calls the bin; empty: the numbers of the place say where it is.
    volume
        Of all pieces together, in one unit of your choice; taken as the weight is.
    category
        Class of the article, such as ``frozen``.
    """

    id: str
    weight: Fraction
    place: Place
    pick_seconds: float = 0.0
    quantity: int = 1
    article: str = ""
    level: int = 0
    label: str = ""
    volume: Fraction = Fraction(0)
    category: str = ""

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
            label: str = "",
            volume: Quantity = 0,
            category: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        """Keep the names' composed form, and a number as the decimal that it is written as."""
        for name in ("id", "article", "label", "category"):
            object.__setattr__(self, name, canonical(getattr(self, name)))
        for name in ("weight", "volume"):
            if not isinstance(getattr(self, name), Fraction):
                object.__setattr__(self, name, exact(getattr(self, name), field=name))


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
    level, label
        Of the bin, as an item has them.
    """

    article: str
    place: Place
    quantity: int
    level: int = 0
    label: str = ""

    def __post_init__(self) -> None:
        """Keep the names' composed form."""
        object.__setattr__(self, "article", canonical(self.article))
        object.__setattr__(self, "label", canonical(self.label))


def picked(group: Sequence[Item], id_: str, source: Stock, quantity: int) -> Item:
    """Return the item that is taken from one place of a stock, a share of what is asked for.

    Parameters
    ----------
    group
        What an order asks of the article.
    id_, quantity
        Of the item.
    source
        Where it is taken from.
    """
    share = Fraction(quantity, max(1, sum(item.quantity for item in group)))
    return Item(
        id_,
        weight=share * sum((item.weight for item in group), Fraction(0)),
        place=source.place,
        pick_seconds=float(share) * sum(item.pick_seconds for item in group),
        quantity=quantity,
        article=source.article,
        level=source.level,
        label=source.label,
        volume=share * sum((item.volume for item in group), Fraction(0)),
        category=group[0].category if group else "",
    )


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
    available
        When its first trip may begin, seconds: it comes later, or is still under way.
    """

    id: str
    capacity: Fraction
    speed: float = 1.0
    trips: int = 1
    available: float = 0.0

    if TYPE_CHECKING:

        def __init__(
            self,
            id: str,
            capacity: Quantity,
            speed: float = 1.0,
            trips: int = 1,
            available: float = 0.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        """Keep the name's composed form, and a number as the decimal that it is written as."""
        object.__setattr__(self, "id", canonical(self.id))
        if not isinstance(self.capacity, Fraction):
            object.__setattr__(self, "capacity", exact(self.capacity, field="capacity"))
